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
  const unsigned int most = 20;
  const double sufficient = 1e-8, enough = 1e-11, largest_gain = 1e-2, least_gain = 0.6, largest_step = 100;
  has_digits = false;
  iterations = 0;
  Vector r = x, next = x, c = x, d = x, change = x; // change is A d
  if (!residual(x, r))
    return;
  double share_before = 1, product = 0; // d . A d
  for (unsigned int pass = 0; pass < most; ++pass) {
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
    has_digits = size < sufficient;
    const bool may_be_far_off = pass == 0 && product > 0;
    if (!(size < (may_be_far_off ? largest_step : least_gain * share_before)))
      return;
    x += step;
    if (size * std::max(size / share_before, largest_gain) < enough) // the next one
      return;
    r.add(-length, change);
    share_before = size;
  }
}

} // namespace dovetail
