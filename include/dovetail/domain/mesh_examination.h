// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Whether what a file says is a mesh on which anything can be solved.

#pragma once

#include <dovetail/domain/mesh_file.h>

namespace dovetail {

/// Bring the vertices of every cell into deal.II's order, mirrored cells the right way round, leave out other
/// nodes, and examine the mesh in a time linear in the cells (times log, to sort their faces):
///
/// * the further nodes of curved cells of second order are kept; cells of which a part is turned over get a
/// note;
/// * all cells have one shape and different nodes, and lie in one plane in 2D;
/// * det dX/dxi has one sign at the Gauss points of a cell, which is turned round if that is minus;
/// * no two cells have the same nodes, at most two cells share a face, from its two sides and with their
/// nodes
///   in the same order round it: cells that lie on the same side overlap;
/// * a face with an id is a face of a cell (of the whole file). Faces between two cells lose theirs. Faces
/// with several ids get a new one, and boundary_names say which ids each name and each id of the file stands
/// for.
///
/// Nodes that no cell has are no error. Nodes of the boundary at the same place are none either, since a body
/// may have a crack, but the mesh gets a note.
/// @throw MeshError, which names the elements and nodes as in the file and where they are
template <int dim>
void examine(MeshFile &mesh);

} // namespace dovetail
