// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The mesh of one body, from a file or from one of deal.II's generators, distributed over all ranks by p4est.

#pragma once

#include <dovetail/scene/section.h>

#include <deal.II/distributed/tria.h>

#include <memory>

namespace dovetail {

template <int dim>
using Mesh = dealii::parallel::distributed::Triangulation<dim>;

/// Make the mesh that a `subsection Mesh` describes: File (.msh 2.2 and 4.1, .inp of Abaqus or AVS UCD, .vtk,
/// .unv) or Generator with Arguments; then X -> Scale X + Shift (curved manifolds follow), then global
/// Refinements, then the local ones.
template <int dim>
std::unique_ptr<Mesh<dim>> make_mesh(const Section &section, const MPI_Comm &communicator);

/// Whether all cells are straight: the mapping of degree 1 is then exact.
template <int dim>
bool is_straight(const dealii::Triangulation<dim> &mesh);

} // namespace dovetail
