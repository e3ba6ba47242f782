// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The interval of a step.

#pragma once

#include <cmath>

namespace dovetail {

/// From the last good state at the time begin to the time end [s].
struct StepTime
{
  double begin = 0, end = 0;
  double size = 0; ///< end - begin, but for rounding
  /// A toggle has switched, or prescribed values jump: the states before begin are on another curve, and a
  /// scheme of several steps starts anew.
  bool starts_anew = false;
  /// Likewise, but of first rates alone: what has second ones goes on as before.
  bool first_rates_start_anew = false;

  bool begins_curve() const { return starts_anew || first_rates_start_anew; } ///< of some rates

  StepTime with_new_first_rates() const { return {begin, end, size, starts_anew, true}; }

  /// The step after this one. Times are sums, so sizes that were meant to be equal differ by the rounding of
  /// the time: these are made equal, and a matrix that depends on the size alone stays as it is.
  StepTime next(const double next_end, const bool starts_anew_there = false) const
  {
    const double difference = next_end - end, rounding = 1e-14 * std::abs(next_end);
    return {end, next_end, std::abs(difference - size) <= rounding ? size : difference, starts_anew_there,
            false};
  }
};

} // namespace dovetail
