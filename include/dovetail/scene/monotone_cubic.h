// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Tables of measured values.

#pragma once

#include <string>
#include <vector>

namespace dovetail {

/// The monotone cubic through pairs (x_i, y_i), constant outside [x_1, x_n]: between two points a cubic with
/// slopes d_i at its ends,
/// @f[ y = y_i h_{00} + h d_i h_{10} + y_{i+1} h_{01} + h d_{i+1} h_{11}, \qquad h = x_{i+1} - x_i, @f]
/// where d_i is the weighted harmonic mean of the slopes of the chords beside it, or 0 where these differ in
/// sign: it never overshoots. Reference: Fritsch and Carlson (1980), Fritsch and Butland (1984).
class MonotoneCubic
{
public:
  /// @pre why_invalid(x, y) is empty.
  MonotoneCubic(const std::vector<double> &x, const std::vector<double> &y);
  /// "" if x grows strictly, there are at least two pairs and all is finite; else a sentence without subject.
  static std::string why_invalid(const std::vector<double> &x, const std::vector<double> &y);

  /// d^order y/dx^order; from the right where it jumps.
  double derivative(unsigned int order, double x) const;

  double first() const { return x.front(); }
  double last() const { return x.back(); }

private:
  std::vector<double> x, y, slopes;
};

} // namespace dovetail
