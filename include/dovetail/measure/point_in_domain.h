// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where a point that the scene names is in the mesh.

#pragma once

#include <dovetail/domain/domain.h>

#include <vector>

namespace dovetail {

template <int dim>
struct PointInCell
{
  typename Domain<dim>::cell_iterator cell;
  dealii::Point<dim> unit_point;
};

/// The owned cells that have the point X: over all ranks one cell, or all around a face, an edge or a vertex
/// that has it. A body is found up to a fraction of the cell's size: typed coordinates are rounded, and the
/// facets of a curved body leave a part of it out. Collective. @throw UserError about the entry Point if X is
/// outside of the domain.
template <int dim>
std::vector<PointInCell<dim>> find_cells(const Domain<dim> &domain, const dealii::Point<dim> &X,
                                         const Section &asking, const MPI_Comm &communicator);

} // namespace dovetail
