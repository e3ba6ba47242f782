// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The small problem of GMRES: Y. Saad, M. H. Schultz: GMRES, a generalized minimal residual algorithm, 1986.

#pragma once

#include <array>
#include <cmath>
#include <vector>

namespace dovetail {

/// The y with the smallest |r e_1 - H y|, where H is an upper Hessenberg matrix that gets one column after
/// the other; by rotations that make H triangular.
class LeastSquares
{
public:
  explicit LeastSquares(const double r = 0) : right({r}) {}

  /// @p column of H, down to the entry below its diagonal
  void append(std::vector<double> column);
  unsigned int n_columns() const { return R.size(); }
  double residual() const { return std::abs(right.back()); }
  /// cosine and sine
  const std::array<double, 2> &last_rotation() const { return rotations.back(); }
  /// y, without its last number if the last column depends on the others.
  std::vector<double> solution() const;

private:
  std::vector<std::vector<double>> R; ///< by column, upper triangle
  std::vector<std::array<double, 2>> rotations;
  std::vector<double> right; ///< r e_1, rotated
};

} // namespace dovetail
