// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Newton's method, damped where the updates demand it; knows no finite element.

#pragma once

#include <dovetail/scene/section.h>
#include <dovetail/solve/nonlinear_problem.h>

#include <vector>

namespace dovetail {

struct NewtonResult
{
  bool is_converged = false;
  bool has_jumped = false;       ///< past a limit point
  std::vector<double> residuals; ///< relative, before the first and after each iteration
  std::vector<unsigned int> linear_iterations;

  /// Another solve of the same step.
  void append(const NewtonResult &next);
};

/// Settings of `subsection Newton`.
class Newton
{
public:
  explicit Newton(const Section &section);

  /// The first full update is tried without being confirmed by its tangent, but not from a guess. A predicted
  /// state may be the solution, but only a small update shows it.
  enum class Start { nearby, predicted, guess };
  /// Newton's method from @p x, which becomes the last iterate that was accepted.
  NewtonResult solve(NonlinearProblem &problem, NonlinearProblem::Vector &x,
                     Start start = Start::nearby) const;

  unsigned int largest_number() const { return maximum_iterations; } ///< of iterations
  double residual_tolerance() const { return relative_tolerance; }
  /// A part whose residual is below this counts as solved.
  double absolute_tolerance() const { return tolerance; }

private:
  class Iteration;

  double relative_tolerance, tolerance;
  unsigned int maximum_iterations;
  bool line_search;
};

} // namespace dovetail
