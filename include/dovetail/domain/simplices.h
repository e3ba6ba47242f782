// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Meshes of triangles or tetrahedra, all on one level and straight.

#pragma once

#include <dovetail/domain/mesh.h>

namespace dovetail {

/// Refine a mesh and make it one of simplices on one level, without manifolds. Quadrilaterals and hexahedra
/// are divided into 8 triangles or 24 tetrahedra after the refinement: the vertices then follow a curved
/// boundary.
template <int dim>
void make_simplices(unsigned int n_refinements, dealii::Triangulation<dim> &mesh);

/// Give every rank its share of a mesh of one level that all ranks have. Its cells are numbered alike on any
/// number of ranks (CellId), and there may be fewer than ranks.
template <int dim>
std::unique_ptr<Mesh<dim>> distribute(dealii::Triangulation<dim> &mesh, const MPI_Comm &communicator);

} // namespace dovetail
