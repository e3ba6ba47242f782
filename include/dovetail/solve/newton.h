// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Newton's method, damped where the updates demand it; knows no finite element.

#pragma once

#include <dovetail/scene/section.h>

#include <functional>
#include <optional>
#include <vector>

namespace dovetail {

/// What Newton's method needs of a nonlinear system with the unknowns x, which the system holds itself.
struct NewtonProblem
{
  bool is_linear = false;             ///< one iteration is exact
  bool confirms_first_update = false; ///< x is a guess at which no update is trusted

  /// Assemble at the trial state, with or without the tangent; the size of the residual relative to what is
  /// at work, NaN if it is not defined.
  std::function<double(bool with_tangent)> assemble;
  /// Solve for the update dx with the last tangent. The number of linear iterations; nothing if that failed.
  std::function<std::optional<unsigned int>()> solve;
  /// Set the trial state to x + damping * dx.
  std::function<void(double damping)> try_update;
  /// The trial state becomes x.
  std::function<void()> accept;
  /// Whether dx moves prescribed values: then the residual at x says nothing about a good damping.
  std::function<bool()> moves_constraints;
  /// For linear systems: the norm of K dx + R.
  std::function<double()> linear_residual;

  /// The size of dx, each field in units of its own, the same during a step.
  std::function<double()> update_norm;
  /// Whether dx was small enough for x + dx to be a solution.
  std::function<bool()> is_update_small;
  /// The simplified correction c, K c = -R(trial), with the tangent that dx was solved with.
  struct Correction
  {
    double norm;     ///< of c
    double distance; ///< of c from (1 - damping) dx, which it is where nothing is nonlinear
  };
  /// At the trial state that was assembled without a tangent, or at x + dx. Nothing if the solver failed.
  std::function<std::optional<Correction>(double damping)> correct;
  /// The distance of the last correction from dx.
  std::function<double()> distance_of_correction;
  /// At x, after each full update that does not end the iteration: whether the equations have changed, what
  /// is frozen in them being adapted to x. May be missing.
  std::function<bool()> adapt;

  /// Add @p share of a tangent that is positive definite to the last tangent. @return false if there is none.
  /// May be missing: then no limit point is crossed.
  std::function<bool(double share)> stabilise;

  /// Told of each iteration: number, norm, linear iterations, damping.
  std::function<void(unsigned int, double, unsigned int, double)> report;
};

struct NewtonResult
{
  bool is_converged = false;
  bool has_jumped = false;       ///< past a limit point
  std::vector<double> residuals; ///< relative, before the first and after each iteration
  std::vector<unsigned int> linear_iterations;
};

/// Settings of `subsection Newton`.
class Newton
{
public:
  explicit Newton(const Section &section);
  NewtonResult solve(const NewtonProblem &problem) const;

  unsigned int largest_number() const { return maximum_iterations; } ///< of iterations
  double residual_tolerance() const { return relative_tolerance; }
  /// A part whose residual is below this counts as solved.
  double absolute_tolerance() const { return tolerance; }

private:
  /// Of the last iteration; what the next one predicts its damping from.
  struct Damping
  {
    double factor = 1, update = 0, update_before = 0, correction = 0;
  };
  double predict(const NewtonProblem &problem, const Damping &last) const;
  double search_line(const NewtonProblem &problem, double norm, bool with_tangent, Damping &damping) const;
  void cross_limit_point(const NewtonProblem &problem, NewtonResult &result) const;
  void solve_linear(const NewtonProblem &problem, NewtonResult &result) const;

  double relative_tolerance, tolerance;
  unsigned int maximum_iterations;
  bool line_search;
};

} // namespace dovetail
