// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Small matrices, one at each point, times small vectors, one at each point.

#pragma once

#include <cstddef>
#include <vector>

namespace dovetail {

/// One summand of a product with an entry of the matrix.
struct PointTerm
{
  unsigned int to, from, entry;
  double factor;
};

/// y[to][i] += factor A[entry][i] x[from][i] for all @p terms and all points i < @p n. The points are what
/// follows each other in memory: the loop over them runs with the widest vectors that the processor has,
/// which deal.II's own loops do only where deal.II was built for that processor.
void add_at_points(const std::vector<PointTerm> &terms, std::size_t n, const double *A, const double *x,
                   double *y);

} // namespace dovetail
