// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Newton's method with a line search; knows no finite element.

#pragma once

#include <dovetail/scene/section.h>

#include <functional>
#include <optional>
#include <vector>

namespace dovetail {

/// What Newton's method needs of a nonlinear system with the unknowns x, which the system holds itself.
struct NewtonProblem
{
  bool is_linear = false; ///< one iteration is exact

  /// Assemble at the trial state, with or without the tangent; the norm of the residual, NaN if it is not
  /// defined.
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
  /// Told of each iteration: number, norm, linear iterations, damping.
  std::function<void(unsigned int, double, unsigned int, double)> report;
};

struct NewtonResult
{
  bool is_converged = false;
  std::vector<double> residuals; ///< relative, before the first and after each iteration
  std::vector<unsigned int> linear_iterations;
};

/// Settings of `subsection Newton`.
class Newton
{
public:
  explicit Newton(const Section &section);
  NewtonResult solve(const NewtonProblem &problem) const;

  /// A field whose residual is below this counts as solved.
  double absolute_tolerance() const { return tolerance; }

private:
  double search_line(const NewtonProblem &problem, double norm, bool with_tangent, double &damping) const;

  double relative_tolerance, tolerance;
  unsigned int maximum_iterations;
  bool line_search;
};

} // namespace dovetail
