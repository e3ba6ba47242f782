// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Meshes of quadrilaterals or hexahedra of second order, as files give them, refined as often as one likes.

#pragma once

#include <dovetail/domain/mesh.h>

#include <deal.II/fe/mapping.h>

#include <boost/signals2/connection.hpp>

#include <memory>
#include <vector>

namespace dovetail {

/// A base of meshes that know how their coarse cells are curved,
///
///     X(xi) = sum_a phi_a(xi) X_a,
///
/// with the functions phi_a of FE_Q(2). Refined cells are parts of these: the body remains what it is.
template <int dim>
class WithCurvedCells
{
public:
  virtual ~WithCurvedCells() = default;

  /// The nodes X_a of every coarse cell, in the order of FE_Q(2). From now on the vertices of @p mesh, which
  /// must be this object, lie where they belong, however it is refined.
  void curve(std::vector<std::vector<dealii::Point<dim>>> nodes_of_cells, dealii::Triangulation<dim> &mesh);

  bool is_curved() const { return !nodes.empty(); }

  /// The nodes of a cell of any level, in that order.
  std::vector<dealii::Point<dim>>
  nodes_of(const typename dealii::Triangulation<dim>::cell_iterator &cell) const;

private:
  std::vector<std::vector<dealii::Point<dim>>> nodes; ///< of the coarse cells
  boost::signals2::scoped_connection on_change;       ///< a mesh changes last when it is deleted
};

/// Whether a mesh is one of these, with curved cells.
template <int dim>
bool has_curved_cells(const dealii::Triangulation<dim> &mesh);

/// Their X(xi), for cells of all levels; of degree 2. @p mesh must outlive it.
template <int dim>
std::unique_ptr<dealii::Mapping<dim>> mapping_of_curved_cells(const Mesh<dim> &mesh);

} // namespace dovetail
