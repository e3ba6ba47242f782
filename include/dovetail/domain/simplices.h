// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Meshes of triangles or tetrahedra, all on one level, straight or of second order.

#pragma once

#include <dovetail/domain/mesh.h>

#include <deal.II/fe/mapping.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace dovetail {

/// The nodes of curved cells of a file beside their vertices, for each cell of a mesh:
/// MeshFile::further_nodes. Empty where all cells are straight.
template <int dim>
using FurtherNodes = std::vector<std::vector<dealii::Point<dim>>>;

/// Refine a mesh and make it one of simplices on one level, without manifolds. Quadrilaterals and hexahedra
/// are divided into 8 triangles or 24 tetrahedra after the refinement: the vertices then follow a curved
/// boundary. The parts of a curved simplex are those of its image X(xi): the body remains what it is.
/// @return of a mesh that was one of hexahedra: by vertex whether it was added, in the middle of a face
template <int dim>
std::vector<bool> make_simplices(unsigned int n_refinements, dealii::Triangulation<dim> &mesh,
                                 FurtherNodes<dim> &nodes_on_edges);

/// Give every rank its share, with a note, of a mesh of one level that all ranks have. Its cells are numbered
/// alike on any number of ranks (CellId), and there may be fewer than ranks.
template <int dim>
std::unique_ptr<Mesh<dim>>
distribute(dealii::Triangulation<dim> &mesh, const FurtherNodes<dim> &nodes_on_edges,
           const std::vector<bool> &is_added, const std::string &note, const MPI_Comm &communicator);

/// By vertex of this rank whether it was added to those of hexahedra; nullptr on all ranks if the cells are
/// no parts of hexahedra. Among the vertices of the tetrahedra at an added one, those that were not added are
/// the vertices of the face in whose middle it is.
template <int dim>
const std::vector<bool> *added_vertices(const Mesh<dim> &mesh);

/// X(xi) = sum_a phi_a(xi) X_a with the functions phi_a of FE_SimplexP of a @p degree: 1, or 2 with the nodes
/// on edges of a mesh with curved cells.
template <int dim>
std::unique_ptr<dealii::Mapping<dim>> mapping_of_simplices(const Mesh<dim> &mesh, unsigned int degree);

/// Whether it has curved cells.
template <int dim>
bool has_curved_simplices(const Mesh<dim> &mesh);

} // namespace dovetail
