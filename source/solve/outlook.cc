// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "outlook.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

void Outlook::see(const unsigned int number, const double residual)
{
  n = number;
  if (residual >= largest) {
    largest = smallest = residual;
    n_of_largest = n;
  }
  smallest = std::min(smallest, residual);
}

double Outlook::per_decade(const unsigned int n_counted) const
{
  return smallest < largest ? n_counted / std::log10(largest / smallest)
                            : std::numeric_limits<double>::infinity();
}

double Outlook::iterations(const double decades) const
{
  return decades * per_decade(n);
}

double Outlook::iterations_since_largest(const double decades) const
{
  return decades * per_decade(n - n_of_largest);
}

double Outlook::iterations_to(const double goal) const
{
  const double least = std::max(goal, largest * std::numeric_limits<double>::epsilon());
  return n_of_largest + iterations_since_largest(std::log10(largest / least));
}

bool Outlook::is_long(const double goal, const double most) const
{
  const double expected = iterations_to(goal);
  return 4 * n_of_largest <= n && expected > n + most && expected < largest_credible;
}

bool Outlook::is_hopeless(const double goal, const double most) const
{
  return n - n_of_largest >= n_for_hopeless && iterations_to(goal) > most;
}

} // namespace dovetail
