// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The vertices of a domain that coarser meshes of its hierarchy do not have, for multigrid.

#pragma once

#include <dovetail/domain/domain.h>
#include <dovetail/domain/numbering.h>

#include <dovetail/solve/mesh_levels.h>

namespace dovetail {

/// Of each owned unknown of the block of a field. In each step, a cell whose children are cells takes their
/// place, everywhere in the mesh. A vertex between those of such a cell, on an edge or a face of it or
/// inside, is the mean of the vertices it lies between. So is a hanging one, until the cells on both sides of
/// it are of one size. Cells that are stretched keep the vertices of their children, and so do those that
/// they are children of. Where tetrahedra were made of hexahedra, these are the only coarser mesh. Other
/// meshes of simplices have none. Collective.
template <int dim>
MeshLevels mesh_levels(const Domain<dim> &domain, const Block &block, bool with_parents,
                       const MPI_Comm &communicator);

/// Whether there are any. On all ranks alike.
template <int dim>
bool has_coarser_meshes(const Mesh<dim> &mesh);

} // namespace dovetail
