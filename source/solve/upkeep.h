// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// When a preconditioner that was made for one matrix still serves for the next ones.

#pragma once

#include <dovetail/solve/krylov.h>

#include <functional>

namespace dovetail {

/// Keeps a preconditioner while matrices change, as long as that costs less than to make a new one. Time is
/// measured in iterations, so that a run takes the same way wherever it runs: an iteration with the old
/// preconditioner that a new one would have spared counts one, a new one counts as many as it costs
/// (doc/theory/linear_solvers.md). A new one is made once these iterations, summed over the systems since the
/// last one, exceed the cost; if they grow in proportion to the number of systems, no other time is better.
class Upkeep
{
public:
  /// Asked n iterations after the beginning, with the norm of the residual then.
  using GivesUp = std::function<bool(unsigned int n, double r)>;
  /// A number of iterations for K x = b from x = 0, until they give up.
  using Iterate = std::function<unsigned int(GroupVector &x, const GroupVector &b, const GivesUp &gives_up)>;

  /// The facts are kept by reference.
  explicit Upkeep(const GroupFacts &facts) : facts(facts) {}

  /// There is another matrix: keep the preconditioner, or @p make it.
  void prepare(const std::function<void()> &make, GroupSolver::Preparations &counts);
  /// Solve K x = b. A preconditioner that is kept is made anew on the way if that is the shorter way from
  /// there. @p with_new: with one of the present matrix. @return the number of iterations
  unsigned int solve(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal,
                     const std::function<void()> &make, GroupSolver::Preparations &counts,
                     const Iterate &iterate, const Attempt &with_new);

  void forget() { is_made = false; }
  void made(); ///< for the present matrix
  /// A system has been solved by @p n iterations, which reduced the residual by @p decades.
  void solved(unsigned int n, double decades);

private:
  void renew(const std::function<void()> &make, GroupSolver::Preparations &counts);
  GivesUp gives_up(double r_0, double goal) const;

  const GroupFacts &facts;
  static constexpr double cost = 12;      ///< of a new preconditioner, measured
  bool is_made = false, is_fresh = false; ///< fresh: made for the present matrix
  bool was_symmetric = true;              ///< the matrix it was made for
  double per_decade = 0;                  ///< the fewest iterations since it was made; 0: none yet
  double excess = 0;
};

} // namespace dovetail
