// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "least_squares.h"

#include <utility>

namespace dovetail {

void LeastSquares::append(std::vector<double> column)
{
  const auto rotate = [](const std::array<double, 2> &by, double &a, double &b) {
    const double rotated = by[0] * a + by[1] * b;
    b = by[0] * b - by[1] * a;
    a = rotated;
  };
  const unsigned int k = n_columns();
  for (unsigned int i = 0; i < k; ++i)
    rotate(rotations[i], column[i], column[i + 1]);
  const double length = std::hypot(column[k], column[k + 1]);
  rotations.push_back({{column[k] / length, column[k + 1] / length}});
  column.pop_back();
  column[k] = length;
  R.push_back(std::move(column));
  right.push_back(0);
  rotate(rotations[k], right[k], right[k + 1]);
}

std::vector<double> LeastSquares::solution() const
{
  unsigned int n = n_columns();
  if (n > 0 && !(std::abs(R[n - 1][n - 1]) > 0)) // NaN, too
    --n;
  std::vector<double> y(right.begin(), right.begin() + n);
  for (unsigned int k = n; k-- > 0;) {
    y[k] /= R[k][k];
    for (unsigned int i = 0; i < k; ++i)
      y[i] -= y[k] * R[k][i];
  }
  return y;
}

} // namespace dovetail
