// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/newton.h>

#include <cmath>

namespace dovetail {

Newton::Newton(const Section &section)
    : relative_tolerance(section.read<double>(
          "Relative tolerance", 1e-9, "Residual over its largest value in the step, field by field [-]",
          Patterns::Double(0, 1))),
      tolerance(section.read<double>(
          "Absolute tolerance", 0, "A field whose residual (Euclidean norm) is below this is solved [N or W]",
          Patterns::Double(0))),
      maximum_iterations(section.read<unsigned int>("Maximum iterations", 20, "Iterations per step [-]",
                                                    Patterns::Integer(1))),
      line_search(section.read<bool>(
          "Line search", true,
          "Damp an update after which the residual is ten times larger, or not defined [-]"))
{
}

/// Take the full update unless it is not defined or the residual grows tenfold; then halve it until the
/// residual decreases. A bending-dominated body needs the full update though its residual grows for an
/// iteration.
/// @return the norm at the trial state, NaN if no damping helps.
double Newton::search_line(const NewtonProblem &problem, const double norm, const bool with_tangent,
                           double &damping) const
{
  const bool is_full_step_needed = !line_search || problem.moves_constraints();
  damping = 1;
  problem.try_update(damping);
  double new_norm = problem.assemble(with_tangent);
  if (is_full_step_needed || new_norm <= 10 * norm)
    return new_norm;
  while (!(new_norm <= (1 - 1e-4 * damping) * norm)) {
    damping /= 2;
    if (damping < 1. / 1024)
      return std::nan("");
    problem.try_update(damping);
    new_norm = problem.assemble(with_tangent);
  }
  return new_norm;
}

namespace {

/// A linear system is solved once; how far rounding lets the residual down depends on its condition.
/// A singular system leaves a residual of order one.
const double largest_linear_residual = 1e-3;

} // namespace

NewtonResult Newton::solve(const NewtonProblem &problem) const
{
  NewtonResult result;
  problem.try_update(0);
  double norm = problem.assemble(true);
  result.residuals.push_back(norm);
  if (!std::isfinite(norm))
    return result;

  while (result.linear_iterations.size() < maximum_iterations) {
    if (norm == 0 && !problem.moves_constraints()) {
      result.is_converged = true;
      return result;
    }
    const auto linear_iterations = problem.solve();
    if (!linear_iterations)
      return result;
    result.linear_iterations.push_back(*linear_iterations);

    double damping = 1;
    if (problem.is_linear) {
      norm = problem.linear_residual();
      problem.try_update(1);
    } else {
      // near convergence the next tangent is probably not needed
      const bool is_near = norm * norm <= relative_tolerance;
      norm = search_line(problem, norm, !is_near, damping);
      if (is_near && std::isfinite(norm) && norm > relative_tolerance)
        norm = problem.assemble(true);
    }
    result.residuals.push_back(norm);
    problem.report(result.linear_iterations.size(), norm, *linear_iterations, damping);
    if (!std::isfinite(norm))
      return result;
    problem.accept();
    if (problem.is_linear || (norm <= relative_tolerance && damping == 1)) {
      result.is_converged = norm <= (problem.is_linear ? largest_linear_residual : relative_tolerance);
      return result;
    }
  }
  return result;
}

} // namespace dovetail
