// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The mesh of one body, from a file or from one of deal.II's generators, distributed over all ranks: along
// the curve of p4est if its cells are quadrilaterals or hexahedra, by METIS if they are triangles or
// tetrahedra. p4est itself is used where cells may be divided one by one.

#pragma once

#include <dovetail/scene/section.h>

#include <deal.II/distributed/tria_base.h>

#include <memory>

namespace dovetail {

template <int dim>
using Mesh = dealii::parallel::DistributedTriangulationBase<dim>;

/// Make the mesh that a `subsection Mesh` describes: File (.msh 2.2 and 4.1, .inp of Abaqus or AVS UCD, .vtk,
/// .unv) or Generator with Arguments; then X -> Scale X + Shift (curved manifolds follow), then global
/// Refinements, then the local ones, or what Cells asks for. All cells have one shape. Triangles and
/// tetrahedra are on one level, each a cell of the coarse mesh. Cells of second order remain curved.
template <int dim>
std::unique_ptr<Mesh<dim>> make_mesh(const Section &section, const MPI_Comm &communicator);

/// Whether the cells are triangles or tetrahedra. Every rank knows, also without cells.
template <int dim>
bool has_simplices(const Mesh<dim> &mesh);

/// Whether all cells are straight: the mapping of degree 1 is then exact.
template <int dim>
bool is_straight(const dealii::Triangulation<dim> &mesh);

} // namespace dovetail
