// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The criterion of convergence by its definition, doc/theory/convergence.md: three parts, two of them of one
// field. Numbers by hand.

#include <dovetail/solve/convergence.h>

#include <cmath>
#include <iostream>

using namespace dovetail;

int main()
{
  const std::vector<double> no_rounding = {0, 0, 0};
  Convergence criterion({0, 0, 1}, {false, false, false}, 1e-9, 0);

  std::cout << "first state, " << criterion.residual({{1, 0, 2}, {1, 0, 2}, no_rounding}) << std::endl;
  std::cout << "a light body beside a heavy one, "
            << criterion.residual({{1e-3, 1e-8, 0}, {1e8, 1e-6, 2}, no_rounding}) << " of part "
            << criterion.worst_part() << std::endl;
  std::cout << "rounding, " << criterion.residual({{1e-17, 1e-16, 0}, {1, 1e-6, 2}, {1e-16, 1e-16, 0}})
            << std::endl;

  criterion.begin_step();
  criterion.residual({{1, 0, 2}, {1, 0, 2}, no_rounding});
  std::cout << "forces that have grown by 1e6 count 100 times, "
            << criterion.residual({{1e-3, 0, 0}, {1e6, 0, 2}, no_rounding}) << std::endl;
  std::cout << "forces that vanish count as they are, "
            << criterion.residual({{1e-30, 0, 0}, {2e-30, 0, 2}, no_rounding}) << std::endl;
  std::cout << "not finite, " << std::isnan(criterion.residual({{1, NAN, 0}, {1, 1, 2}, no_rounding}))
            << std::endl;

  criterion.begin_step();
  criterion.residual({{0, 0, 0}, {1, 1, 1}, no_rounding});
  std::cout << "held, " << criterion.residual({{1e-12, 0, 0}, {1, 1, 1}, no_rounding}) << std::endl;

  const auto is_small = [&](const double first, const double third, const double energy) {
    return criterion.is_small(
        {{first, 0, third}, {300, 310, -1}, {305, 400, 1}, {energy, 0, 0}, {100, 100, 100}});
  };
  std::cout << "updates in the range of their fields, 100 and 2: " << is_small(0.09, 1e-3, 0)
            << is_small(0.11, 0, 0) << is_small(0, 3e-3, 0) << std::endl;
  std::cout << "energies, work 1 * 100 * 10: " << is_small(0, 0, 0.9e-3) << is_small(0, 0, 1.1e-3)
            << std::endl;
  Convergence constant({0}, {false}, 1e-9, 0);
  constant.residual({{0}, {1}, {0}});
  std::cout << "a constant of 300, updates 4e-7 and 2e-7: "
            << constant.is_small({{4e-7}, {300}, {300}, {0}, {1}})
            << constant.is_small({{2e-7}, {300}, {300}, {0}, {1}}) << std::endl;
  std::cout << "an absolute tolerance, " << Convergence({0}, {false}, 1e-9, 1e-3).residual({{9e-4}, {0}, {0}})
            << std::endl;
}
