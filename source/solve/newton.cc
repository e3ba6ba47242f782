// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/newton.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

Newton::Newton(const Section &section)
    : relative_tolerance(section.read<double>(
          "Relative tolerance", 1e-9,
          "Tolerance of the residual divided by the forces at work, for each field of each domain [-]",
          Patterns::Double(0, 1))),
      tolerance(section.read<double>("Absolute tolerance", 0,
                                     "A field of a domain has converged if the Euclidean norm of its "
                                     "residual is below this tolerance [N or W]",
                                     Patterns::Double(0))),
      maximum_iterations(section.read<unsigned int>(
          "Maximum iterations", 20, "Maximum number of iterations per step [-]", Patterns::Integer(1))),
      line_search(section.read<bool>("Line search", true,
                                     "Damp an update that leads to an undefined state, or that is larger "
                                     "than the previous update and not confirmed by its tangent [-]"))
{
}

namespace {

const double smallest_damping = 1e-6;
const double largest_reduction = 10; ///< of a damping that was too bold: far off, no estimate holds
/// Of the residual, by a full update that is trusted. That of a body of slenderness s grows by less than s^3.
const double largest_growth = 1e10;
const double growth_at_limit_point = 10; ///< of updates within a step
const unsigned int most_passes = 5;      ///< of the iterations of a step, to get past it
/// A linear system is solved once; how far rounding lets the residual down depends on its condition.
/// A singular system leaves a residual of order one.
const double largest_linear_residual = 1e-3;

} // namespace

/// The damping for which the estimate of the curvature from the last iteration allows the decrease that
/// search_line demands (Deuflhard 2004, section 3.3.3).
double Newton::predict(const NewtonProblem &problem, const Damping &last) const
{
  if (!line_search || last.factor == 1)
    return 1;
  const double curvature = problem.distance_of_correction() * problem.update_norm();
  const double predicted = curvature > 0 ? last.factor * last.update * last.correction / curvature : 1.;
  return std::min(1., std::max(predicted, smallest_damping));
}

/// The updates are measured, not the residual. The full update is taken as long as it is defined and not
/// larger than the two before: a slender body goes through states with large residuals, and needs them, but
/// not through any. Else, and until a full update is taken again, the tangent K that dx was solved with must
/// confirm what is taken: the correction c = -K^-1 R(x + a dx) is smaller than dx, by a/4 where a < 1
/// (Deuflhard's natural monotonicity test). While prescribed values move, only the share a of them does, and
/// the residual @p norm at x says nothing.
/// @return the norm at the trial state, NaN if no damping helps.
double Newton::search_line(const NewtonProblem &problem, const double norm, const bool with_tangent,
                           Damping &damping) const
{
  const double update = problem.update_norm(), before = std::max(damping.update, damping.update_before);
  damping.factor = predict(problem, damping);
  damping.update_before = damping.update;
  damping.update = update;
  const bool is_first = before == 0;
  bool is_trusted =
      !line_search || (damping.factor == 1 && (is_first ? !problem.confirms_first_update : update <= before));
  const double largest_norm =
      problem.moves_constraints() ? std::numeric_limits<double>::max() : largest_growth * norm;
  const auto reduce = [&](const double proposed) {
    damping.factor = std::max(std::min(proposed, damping.factor / 2), damping.factor / largest_reduction);
  };
  for (bool may_grow = true; damping.factor >= smallest_damping;) {
    const bool is_full = damping.factor == 1;
    problem.try_update(damping.factor);
    const double new_norm = problem.assemble(with_tangent && is_full);
    if (!line_search || (is_trusted && new_norm <= largest_norm))
      return new_norm;
    is_trusted = false;
    if (!std::isfinite(new_norm)) {
      reduce(damping.factor / 2);
      may_grow = false;
      continue;
    }
    const auto correction = problem.correct(damping.factor);
    if (!correction)
      return std::nan("");
    const double best =
        correction->distance > 0 ? 0.5 * update * damping.factor * damping.factor / correction->distance : 1.;
    if (!(correction->norm < (is_full ? 1 : 1 - damping.factor / 4) * update)) {
      reduce(best);
      may_grow = false;
    } else if (may_grow && best >= 4 * damping.factor && !is_full) {
      damping.factor = std::min(1., best);
      may_grow = false;
    } else {
      damping.correction = correction->norm;
      return is_full ? new_norm : problem.assemble(true);
    }
  }
  return std::nan("");
}

/// Where the tangent becomes singular no branch of solutions leads on, and updates grow without bound. From
/// there a body that moved slowly would fall to another solution: pseudo-transient continuation (Kelley and
/// Keyes 1998), in which the tangent at rest takes the place of the mass, and time steps grow as the residual
/// falls.
void Newton::cross_limit_point(const NewtonProblem &problem, NewtonResult &result) const
{
  const double first_share = 1, smallest_share = 1e-8, largest_share = 1e4, largest_last_share = 1e-3;
  problem.try_update(0);
  double norm = problem.assemble(true), share = first_share;
  while (result.linear_iterations.size() < most_passes * maximum_iterations && share <= largest_share) {
    if (!problem.stabilise(share))
      return;
    const auto linear_iterations = problem.solve();
    if (!linear_iterations)
      return;
    result.linear_iterations.push_back(*linear_iterations);
    problem.try_update(1);
    const double new_norm = problem.assemble(true);
    result.residuals.push_back(new_norm);
    problem.report(result.linear_iterations.size(), new_norm, *linear_iterations, 1 / (1 + share));
    if (!std::isfinite(new_norm)) {
      share *= 4;
      problem.try_update(0);
      problem.assemble(true);
      continue;
    }
    problem.accept();
    if (new_norm <= relative_tolerance && share <= largest_last_share && problem.is_update_small()) {
      result.is_converged = result.has_jumped = true;
      return;
    }
    share = std::max(smallest_share, share * std::min(2., std::max(0.1, new_norm / norm)));
    norm = new_norm;
  }
}

void Newton::solve_linear(const NewtonProblem &problem, NewtonResult &result) const
{
  const auto linear_iterations = problem.solve();
  if (!linear_iterations)
    return;
  result.linear_iterations.push_back(*linear_iterations);
  const double norm = problem.linear_residual();
  problem.try_update(1);
  result.residuals.push_back(norm);
  problem.report(1, norm, *linear_iterations, 1);
  if (!std::isfinite(norm))
    return;
  problem.accept();
  result.is_converged = norm <= largest_linear_residual;
}

NewtonResult Newton::solve(const NewtonProblem &problem) const
{
  NewtonResult result;
  problem.try_update(0);
  double norm = problem.assemble(true);
  result.residuals.push_back(norm);
  if (!std::isfinite(norm))
    return result;
  if (norm <= relative_tolerance && !problem.moves_constraints()) { // nothing has changed
    result.is_converged = true;
    return result;
  }
  if (problem.is_linear) {
    solve_linear(problem, result);
    return result;
  }

  Damping damping;
  double first_update = 0;
  while (result.linear_iterations.size() < maximum_iterations) {
    const auto linear_iterations = problem.solve();
    if (!linear_iterations)
      return result;
    result.linear_iterations.push_back(*linear_iterations);
    // near convergence the next tangent is probably not needed
    const bool is_near = norm * norm <= relative_tolerance;
    if (first_update == 0)
      first_update = problem.update_norm();
    norm = search_line(problem, norm, !is_near, damping);
    const bool is_done = norm <= relative_tolerance && damping.factor == 1 && problem.is_update_small();
    if (is_near && !is_done && std::isfinite(norm) && damping.factor == 1)
      norm = problem.assemble(true);
    result.residuals.push_back(norm);
    problem.report(result.linear_iterations.size(), norm, *linear_iterations, damping.factor);
    if (!std::isfinite(norm)) {
      if (line_search && problem.stabilise && damping.update > growth_at_limit_point * first_update)
        cross_limit_point(problem, result);
      return result;
    }
    problem.accept();
    if (is_done) {
      result.is_converged = true;
      return result;
    }
    if (damping.factor == 1 && problem.adapt && problem.adapt()) {
      norm = problem.assemble(true);
      damping = {};
      if (!std::isfinite(norm))
        return result;
    }
  }
  return result;
}

} // namespace dovetail
