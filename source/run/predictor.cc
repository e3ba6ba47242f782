// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/predictor.h>

namespace dovetail {

void Predictor::add(const double t, const Vector &x)
{
  const unsigned int largest_number = 3;
  if (!solutions.empty() && !(t > solutions.back().first)) // a new beginning
    forget();
  if (solutions.size() == largest_number)
    solutions.erase(solutions.begin());
  solutions.emplace_back(t, x);
}

Predictor::Vector Predictor::guess(const double t) const
{
  Vector sum = solutions[0].second;
  sum = 0;
  for (const auto &[t_i, x_i] : solutions) {
    double weight = 1;
    for (const auto &[t_j, x_j] : solutions)
      if (t_j != t_i)
        weight *= (t - t_j) / (t_i - t_j);
    sum.add(weight, x_i);
  }
  return sum;
}

} // namespace dovetail
