// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "upkeep.h"

#include <algorithm>
#include <cmath>

namespace dovetail {

void Upkeep::made()
{
  is_made = is_fresh = true;
  per_decade = excess = 0;
}

void Upkeep::solved(const unsigned int n, const double decades)
{
  const double fewest_decades = 1; // less says little of the rate
  if (!(decades >= fewest_decades))
    return;
  const double here = n / decades;
  per_decade = per_decade > 0 ? std::min(per_decade, here) : here;
  if (!is_fresh)
    excess += n - per_decade * decades;
}

std::function<bool(unsigned int n, double r)> Upkeep::gives_up(const double r_0, const double goal) const
{
  const unsigned int first_look = 8;
  return [=](const unsigned int n, const double r) {
    if (n < first_look || per_decade == 0)
      return false;
    if (!(r < r_0))
      return n >= cost;
    const double done = std::log10(r_0 / r), rest = std::log10(r / goal);
    return n / done * rest > cost + per_decade * rest;
  };
}

} // namespace dovetail
