// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What is extrapolated from a residual that falls by the same factor in each iteration, from the beginning or
// after it has grown. Numbers by hand.

#include "../../source/solve/outlook.h"

#include <cmath>
#include <iostream>
#include <string>

using namespace dovetail;

namespace {

/// Of @p n iterations, in the first @p n_growing of which the residual grows by ten, and then needs
/// @p per_decade iterations for each decade.
Outlook after(const unsigned int n, const unsigned int n_growing, const double per_decade)
{
  Outlook outlook;
  for (unsigned int i = 1; i <= n; ++i)
    outlook.see(i,
                i <= n_growing ? std::pow(10., i) : std::pow(10., n_growing - (i - n_growing) / per_decade));
  return outlook;
}

void report(const std::string &name, const Outlook &outlook, const double goal)
{
  std::cout << name << ": " << outlook.iterations_to(goal) / 10 << " tens, long " << outlook.is_long(goal, 30)
            << ", hopeless " << outlook.is_hopeless(goal, 40) << std::endl;
}

} // namespace

int main()
{
  report("eight iterations, five for a decade", after(8, 1, 5), 1e-9); // ten decades, one iteration before
  report("eight iterations, three for a decade", after(8, 1, 3), 1e-9);
  report("growing for three of eight", after(8, 3, 5), 1e-7); // more than a quarter
  report("growing for three of sixteen", after(16, 3, 5), 1e-7);
  report("24 iterations after the largest", after(25, 1, 5), 1e-9);
  report("eight iterations, 200 for a decade", after(8, 1, 200), 1e-9);
  report("nothing has fallen", after(8, 8, 5), 1e-9);
}
