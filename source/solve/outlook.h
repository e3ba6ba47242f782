// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How many iterations a solve will take.

#pragma once

namespace dovetail {

/// Extrapolates the iterations from those seen so far: each decade of the residual takes as many. Decades are
/// counted from the largest residual, because residuals grow at first where stiff bodies move with soft ones.
class Outlook
{
public:
  void see(unsigned int n, double residual); ///< after n iterations

  static constexpr unsigned int n_between_looks = 8;
  bool is_time_to_look() const { return n != 0 && n % n_between_looks == 0; }

  double iterations(double decades) const; ///< from the beginning
  double iterations_since_largest(double decades) const;
  /// To the residual @p goal more than @p most, in all.
  bool is_hopeless(double goal, double most) const;
  /// More than @p most after those that are done. Also after few of them, in most of which the residual has
  /// fallen; where it has hardly done so, that tells little.
  bool is_long(double goal, double most) const;
  double iterations_to(double goal) const; ///< or to what rounding leaves at best

private:
  double per_decade(unsigned int n_counted) const;

  static constexpr unsigned int n_for_hopeless = 24;
  static constexpr double largest_credible = 1000;
  unsigned int n = 0, n_of_largest = 0;
  double largest = 0, smallest = 0;
};

} // namespace dovetail
