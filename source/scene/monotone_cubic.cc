// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/scene/monotone_cubic.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

/// At an end from the chords of the two intervals there (three-point formula), limited so that it stays
/// monotone.
double slope_at_end(const double h, const double h_next, const double chord, const double chord_next)
{
  const double slope = ((2 * h + h_next) * chord - h * chord_next) / (h + h_next);
  if (slope * chord <= 0)
    return 0;
  return chord * chord_next < 0 && std::abs(slope) > 3 * std::abs(chord) ? 3 * chord : slope;
}

} // namespace

MonotoneCubic::MonotoneCubic(const std::vector<double> &x, const std::vector<double> &y)
    : x(x), y(y), slopes(x.size())
{
  const unsigned int n = x.size();
  std::vector<double> h(n - 1), chord(n - 1);
  for (unsigned int i = 0; i + 1 < n; ++i) {
    h[i] = x[i + 1] - x[i];
    chord[i] = (y[i + 1] - y[i]) / h[i];
  }
  if (n == 2) {
    slopes = {chord[0], chord[0]};
    return;
  }
  for (unsigned int i = 1; i + 1 < n; ++i)
    if (chord[i - 1] * chord[i] > 0) {
      const double before = 2 * h[i] + h[i - 1], after = h[i] + 2 * h[i - 1];
      slopes[i] = (before + after) / (before / chord[i - 1] + after / chord[i]);
    }
  slopes[0] = slope_at_end(h[0], h[1], chord[0], chord[1]);
  slopes[n - 1] = slope_at_end(h[n - 2], h[n - 3], chord[n - 2], chord[n - 3]);
}

std::string MonotoneCubic::why_invalid(const std::vector<double> &x, const std::vector<double> &y)
{
  if (x.size() != y.size() || x.size() < 2)
    return "needs an argument and at least two pairs of numbers, as in table(T, 300, 11, 900, 19)";
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!std::isfinite(x[i]) || !std::isfinite(y[i]))
      return "has a number that is not finite";
  for (std::size_t i = 1; i < x.size(); ++i)
    if (!(x[i] > x[i - 1]))
      return "needs arguments that grow from pair to pair";
  return {};
}

double MonotoneCubic::derivative(const unsigned int order, const double at) const
{
  if (!(at >= x.front() && at < x.back())) {
    const double outside = at < x.front() ? y.front() : y.back();
    return std::isnan(at) ? at : order == 0 ? outside : 0;
  }
  const unsigned int i = std::upper_bound(x.begin(), x.end(), at) - x.begin() - 1;
  const double h = x[i + 1] - x[i], s = at - x[i], chord = (y[i + 1] - y[i]) / h;
  // y = y_i + d_i s + b s² + c s³
  const double b = (3 * chord - 2 * slopes[i] - slopes[i + 1]) / h,
               c = (slopes[i] + slopes[i + 1] - 2 * chord) / (h * h);
  switch (order) {
  case 0:
    return y[i] + s * (slopes[i] + s * (b + s * c));
  case 1:
    return slopes[i] + s * (2 * b + 3 * s * c);
  case 2:
    return 2 * b + 6 * s * c;
  case 3:
    return 6 * c;
  default:
    return 0;
  }
}

} // namespace dovetail
