// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where a quantity is largest or smallest.

#pragma once

#include <dovetail/measure/reduction.h>

#include <vector>

namespace dovetail {

/// Of each number of a quantity: the dim - 1 vertices of the mesh, in one cell, next to the Gauss point at
/// which the number has its minimum or maximum over the region; empty if it is nowhere a number. Collective;
/// @p solution is ghosted.
template <int dim>
std::vector<std::vector<dealii::Point<dim>>> places_of_extremes(const Region<dim> &region,
                                                                const Quantity<dim> &quantity, Reduce how,
                                                                const Vector &solution, double t);

} // namespace dovetail
