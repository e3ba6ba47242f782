// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/iterative_refinement.h>

#include <algorithm>
#include <utility>

namespace dovetail {

IterativeRefinement::IterativeRefinement(Residual residual, Inverse inverse, Share share,
                                         const bool is_symmetric)
    : residual(std::move(residual)), inverse(std::move(inverse)), share(std::move(share)),
      is_symmetric(is_symmetric)
{
}

void IterativeRefinement::refine(Vector &x)
{
  const unsigned int most = 20, patience = 3;
  const double enough = 1e-11, largest_gain = 1e-2, least_gain = 0.6, largest_step = 100,
               largest_growth = 1e3;
  last_share = smallest_share = 1;
  iterations = 0;
  Vector r = x, next = x, c = x, d = x, change = x; // change is A d
  if (!residual(x, r))
    return;
  double product = 0; // d . A d
  for (unsigned int pass = 0, n_without_gain = 0; pass < most; ++pass) {
    const auto n = inverse(r, c);
    if (!n)
      return;
    iterations += *n;
    if (product > 0)
      c.add(-(c * change) / product, d);
    d = c;
    Vector end = x;
    end += d;
    if (!residual(end, next))
      return;
    change = r;
    change -= next;
    product = is_symmetric ? d * change : 0.;
    const double length = product > 0 ? (d * r) / product : 1.;
    Vector step = d;
    step *= length;
    const double size = share(step, x);
    n_without_gain = size < least_gain * smallest_share ? 0 : n_without_gain + 1;
    const double largest = std::min(largest_step, largest_growth * smallest_share);
    const bool may_wait = product > 0 && !is_exact() && n_without_gain <= patience && size < largest;
    if (n_without_gain > 0 && !may_wait) {
      if (!is_exact())
        last_share = std::max(last_share, std::min(size, 1.));
      return;
    }
    x += step;
    const bool is_done = size * std::max(size / last_share, largest_gain) < enough; // the next one
    last_share = size;
    smallest_share = std::min(smallest_share, size);
    if (is_done)
      return;
    r.add(-length, change);
  }
}

} // namespace dovetail
