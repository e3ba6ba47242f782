// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "point_products.h"

// One version for each generation of processors, of which the loader takes one. A sanitizer cannot look into
// the choice, which is made before it has started.
#if defined(__x86_64__) && defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
#define DOVETAIL_WIDEST_VECTORS                                                                              \
  __attribute__((target_clones("arch=skylake-avx512", "arch=haswell", "default")))
#else
#define DOVETAIL_WIDEST_VECTORS
#endif

namespace dovetail {

DOVETAIL_WIDEST_VECTORS void add_at_points(const std::vector<PointTerm> &terms, const std::size_t n,
                                           const double *const A, const double *const x, double *const y)
{
  for (const PointTerm &term : terms) {
    const double *const __restrict__ a = A + term.entry * n;
    const double *const __restrict__ from = x + term.from * n;
    double *const __restrict__ to = y + term.to * n;
    for (std::size_t i = 0; i < n; ++i)
      to[i] += term.factor * a[i] * from[i];
  }
}

} // namespace dovetail
