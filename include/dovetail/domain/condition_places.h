// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where on a mesh conditions act: the planes of their faces, the nodes at points.

#pragma once

#include <dovetail/domain/condition.h>

#include <deal.II/base/tensor.h>
#include <deal.II/grid/tria.h>

#include <map>
#include <optional>
#include <utility>

namespace dovetail {

template <int dim>
class Domain;

/// A node of a field by a cell that has it and its number there.
template <int dim>
struct NodeOfCell
{
  typename dealii::Triangulation<dim>::active_cell_iterator cell;
  unsigned int node;
};

/// Unit normals by active_cell_index and number of the face.
template <int dim>
using PlaneNormals = std::map<std::pair<unsigned int, unsigned int>, dealii::Tensor<1, dim>>;

/// Of the faces of owned and ghost cells on which a condition constrains normal components. All faces of one
/// plane (1e-3 rad; meshes from files have rounded coordinates) get the mean of their normals, on all ranks
/// alike. Collective.
/// @throw UserError if the faces with a boundary id have more than dim directions: they are curved
template <int dim>
PlaneNormals<dim> find_plane_normals(const Domain<dim> &domain, const MPI_Comm &communicator);

/// The node at Condition::point(), on the rank that owns it. Hanging nodes do not count. Collective.
/// @throw UserError if no node is nearer than a hundredth of the diameter of its cell
template <int dim>
std::optional<NodeOfCell<dim>> find_node(const Domain<dim> &domain, const Condition<dim> &condition,
                                         const MPI_Comm &communicator);

} // namespace dovetail
