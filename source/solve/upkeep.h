// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// When a preconditioner that was made for one matrix still serves for the next ones.

#pragma once

#include <functional>

namespace dovetail {

/// Keeps a preconditioner while matrices change, as long as that costs less than to make a new one. Time is
/// measured in iterations, so that a run takes the same way wherever it runs: an iteration with the old
/// preconditioner that a new one would have spared counts one, a new one counts @p cost. A new one is made
/// once these iterations, summed over the systems since the last one, exceed the cost; if they grow in
/// proportion to the number of systems, no other time is better.
class Upkeep
{
public:
  explicit Upkeep(double cost) : cost(cost) {}

  void forget() { is_made = false; }
  void made();                                            ///< for the present matrix
  bool pays() const { return is_made && excess <= cost; } ///< to keep it for the next matrix
  void keep() { is_fresh = false; }                       ///< for the next matrix
  bool is_of_earlier() const { return is_made && !is_fresh; }

  /// A system has been solved by @p n iterations, which reduced the residual by @p decades.
  void solved(unsigned int n, double decades);
  /// What a system that has to be solved by so many decades is asked after n iterations, with the residual r
  /// beside r_0 at the beginning: whether a new preconditioner would be the shorter way from there.
  std::function<bool(unsigned int n, double r)> gives_up(double r_0, double goal) const;

private:
  const double cost;
  bool is_made = false, is_fresh = false; ///< fresh: made for the present matrix
  double per_decade = 0;                  ///< the fewest iterations since it was made; 0: none yet
  double excess = 0;
};

} // namespace dovetail
