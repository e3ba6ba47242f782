// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// In which order the cells of a file are numbered. The unknowns follow that order, and so does every loop
// over rows of a matrix: where neighbours lie far apart, they are fetched from memory again and again.

#pragma once

#include <dovetail/domain/mesh_file.h>

namespace dovetail {

/// Sort scattered cells along Hilbert's curve (1891) through their centres, and the nodes by the first cell
/// that has them. Cells count as scattered if more than a fifth of the steps from a cell at a node to the
/// next cell at this node, in the order of the file, are longer than 256 cells, and eight times as many as
/// along the curve. So the unstructured meshes of Gmsh are; cells in columns, as an extrusion leaves them,
/// are not, and keep their order, which serves the smoothers better. Small meshes keep theirs.
///
/// @p mesh: as examine() leaves it
template <int dim>
void sort_scattered_cells(MeshFile &mesh);

} // namespace dovetail
