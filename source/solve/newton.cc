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
const double reduction_of_overshoot = 0.2, largest_return = 0.25;
const unsigned int most_passes = 5; ///< of the iterations of a step, to get past it
/// A linear system is solved once; how far rounding lets the residual down depends on its condition.
/// A singular system leaves a residual of order one.
const double largest_linear_residual = 1e-3;

} // namespace

/// The iterates of one solve.
class Newton::Iteration
{
public:
  using Vector = NonlinearProblem::Vector;

  Iteration(const Newton &settings, NonlinearProblem &problem, Vector &x, const Start start)
      : settings(settings), problem(problem), start(start), x(x), dx(x)
  {
  }
  NewtonResult solve();

private:
  bool solve_for_update();
  bool correct(double factor);
  void try_update(double factor);
  void accept();
  void reduce_rest(double &norm);
  void iteration_ends(double norm, double damping);
  double predict() const;
  double share_along(const Vector &other) const;
  double try_as_sensible(bool is_first);
  bool is_confirmed_by_next_update(double update);
  double search_line(double norm, bool with_tangent);
  void iterate(double norm);
  void cross_limit_point();
  void solve_linear();
  void solve_stage();
  unsigned int n_iterations() const { return result.linear_iterations.size() - n_before; }

  /// Of the last iteration; what the next one predicts its damping from.
  struct Damping
  {
    bool is_chosen = false; ///< by the problem, and trusted
    double factor = 1, update = 0, update_before = 0, correction = 0;
  };

  const Newton &settings;
  NonlinearProblem &problem;
  const Start start;
  Vector &x;
  Vector dx;
  Vector trial, correction; ///< empty until they are needed: not where the problem is linear
  Damping damping;
  NewtonResult result;
  unsigned int n_before = 0; ///< iterations, in other stages
};

bool Newton::Iteration::solve_for_update()
{
  const auto linear_iterations = problem.solve(x, dx);
  if (linear_iterations)
    result.linear_iterations.push_back(*linear_iterations);
  return linear_iterations.has_value();
}

bool Newton::Iteration::correct(const double factor)
{
  if (correction.size() == 0)
    correction.reinit(x);
  return problem.correct(x, trial, factor, correction);
}

void Newton::Iteration::try_update(const double factor)
{
  problem.move(x, factor, dx, trial);
}

void Newton::Iteration::accept()
{
  x = trial;
  problem.accept_state();
}

/// By a simplified Newton step from the trial state, at which the residual was assembled last; @p norm is its
/// size. Where that does not help the state stays.
void Newton::Iteration::reduce_rest(double &norm)
{
  if (!correct(1))
    return;
  trial += correction;
  if (const double reduced = problem.residual(trial); reduced < norm)
    norm = reduced;
  else {
    trial -= correction;
    norm = problem.residual(trial);
  }
}

void Newton::Iteration::iteration_ends(const double norm, const double damping)
{
  result.residuals.push_back(norm);
  problem.iteration_ends(result.linear_iterations.size(), norm, result.linear_iterations.back(), damping);
}

/// The damping for which the estimate of the curvature from the last iteration allows the decrease that
/// search_line demands (Deuflhard 2004, section 3.3.3).
double Newton::Iteration::predict() const
{
  if (!settings.line_search || damping.factor == 1 || damping.is_chosen)
    return 1;
  Vector difference = correction;
  difference -= dx;
  const double curvature = problem.norm(difference) * problem.norm(dx);
  const double predicted =
      curvature > 0 ? damping.factor * damping.update * damping.correction / curvature : 1.;
  return std::min(1., std::max(predicted, smallest_damping));
}

/// The tangent at x may say nothing of the trial state: where a slender body turns, what is left of a good
/// step is small in the stiffness there, but large in that along the old axis. A full step with a smaller
/// residual is good as well if the next update, with the tangent at the trial state, is smaller. The tangent
/// stays there then, and returns to x otherwise.
bool Newton::Iteration::is_confirmed_by_next_update(const double update)
{
  if (std::isfinite(problem.residual_and_tangent(trial)) && correct(1) && problem.norm(correction) < update)
    return true;
  problem.residual_and_tangent(x);
  problem.residual(trial);
  return false;
}

/// The factor of dx in the part of @p other that is along dx.
double Newton::Iteration::share_along(const Vector &other) const
{
  Vector sum = other, difference = other;
  sum += dx;
  difference -= dx;
  const double squares[] = {problem.norm(sum), problem.norm(difference), problem.norm(dx)};
  return (squares[0] * squares[0] - squares[1] * squares[1]) / (4 * squares[2] * squares[2]);
}

/// The full update is there and trusted. Where it may lead too far it is taken as far as the problem makes
/// sense of it, and, if it is the first one, no further than to where the next one does not go back by much:
/// a clamped plate that stiffens by stretching goes back by half of what is too far each time, and gets lost.
/// @return the norm at the trial state.
double Newton::Iteration::try_as_sensible(const bool is_first)
{
  double norm = problem.residual_and_tangent(trial);
  if (!settings.line_search || problem.moves_constraints() || !problem.may_overshoot())
    return norm;
  for (double share = problem.sensible_share(dx); share > smallest_damping; share *= reduction_of_overshoot) {
    if (share < 1) {
      damping.factor = share;
      damping.is_chosen = true;
      try_update(share);
      norm = problem.residual_and_tangent(trial);
    }
    if (!is_first || !problem.may_overshoot())
      break;
    if (std::isfinite(norm) && correct(1) && share_along(correction) > -largest_return * share)
      break;
  }
  return norm;
}

/// The updates are measured, not the residual. The full update is taken as long as it is defined and not
/// larger than the two before: a slender body goes through states with large residuals, and needs them, but
/// not through any. It is shortened where the problem knows how far its linear equations lead. Else, and
/// until a full update is taken again, the tangent K that dx was solved with must confirm what is taken: the
/// correction c = -K^-1 R(x + a dx) is smaller than dx, by a/4 where a < 1 (Deuflhard's natural monotonicity
/// test). While prescribed values move, only the share a of them does, and the residual @p norm at x says
/// nothing.
/// @return the norm at the trial state, NaN if no damping helps.
double Newton::Iteration::search_line(const double norm, const bool with_tangent)
{
  const double update = problem.norm(dx), before = std::max(damping.update, damping.update_before);
  damping.factor = predict();
  damping.is_chosen = false;
  damping.update_before = damping.update;
  damping.update = update;
  const bool is_first = before == 0;
  bool is_trusted = !settings.line_search || problem.has_linear_stage() ||
                    (damping.factor == 1 && (is_first ? start != Start::guess : update <= before));
  const double any = std::numeric_limits<double>::max(),
               largest_norm = problem.moves_constraints() ? any : largest_growth * norm;
  const auto reduce = [&](const double proposed) {
    damping.factor = std::max(std::min(proposed, damping.factor / 2), damping.factor / largest_reduction);
  };
  for (bool may_grow = true; damping.factor >= smallest_damping;) {
    const bool is_full = damping.factor == 1, replaces_tangent = with_tangent && is_full && is_trusted;
    try_update(damping.factor);
    const double new_norm = replaces_tangent ? try_as_sensible(is_first) : problem.residual(trial);
    if (is_trusted && (!settings.line_search || new_norm <= (damping.is_chosen ? any : largest_norm)))
      return new_norm;
    if (replaces_tangent) { // that at x is still needed
      problem.residual_and_tangent(x);
      problem.residual(trial);
    }
    is_trusted = damping.is_chosen = false;
    if (!std::isfinite(new_norm)) {
      reduce(damping.factor / 2);
      may_grow = false;
      continue;
    }
    if (!correct(damping.factor))
      return std::nan("");
    const double size = problem.norm(correction);
    Vector difference = correction; // from (1 - a) dx, which c is where nothing is nonlinear
    difference.add(damping.factor - 1, dx);
    const double distance = problem.norm(difference);
    const double best = distance > 0 ? 0.5 * update * damping.factor * damping.factor / distance : 1.;
    if (!(size < (is_full ? 1 : 1 - damping.factor / 4) * update)) {
      const bool is_smaller = is_full && with_tangent && new_norm < norm && !problem.moves_constraints();
      if (is_smaller && is_confirmed_by_next_update(update)) {
        damping.correction = problem.norm(correction);
        return new_norm;
      }
      reduce(best);
      may_grow = false;
    } else if (may_grow && best >= 4 * damping.factor && !is_full) {
      damping.factor = std::min(1., best);
      may_grow = false;
    } else {
      damping.correction = size;
      return is_full && !with_tangent ? new_norm : problem.residual_and_tangent(trial);
    }
  }
  return std::nan("");
}

/// Where the tangent becomes singular no branch of solutions leads on, and updates grow without bound. From
/// there a body that moved slowly would fall to another solution: pseudo-transient continuation (Kelley and
/// Keyes 1998), in which the tangent at rest takes the place of the mass, and time steps grow as the residual
/// falls.
void Newton::Iteration::cross_limit_point()
{
  const double first_share = 1, smallest_share = 1e-8, largest_share = 1e4, largest_last_share = 1e-3;
  double norm = problem.residual_and_tangent(x), share = first_share;
  while (n_iterations() < most_passes * settings.maximum_iterations && share <= largest_share) {
    if (!problem.stabilise(x, share) || !solve_for_update())
      return;
    try_update(1);
    const double new_norm = problem.residual_and_tangent(trial);
    iteration_ends(new_norm, 1 / (1 + share));
    if (!std::isfinite(new_norm)) {
      share *= 4;
      problem.residual_and_tangent(x);
      continue;
    }
    accept();
    if (new_norm <= settings.relative_tolerance && share <= largest_last_share && problem.is_small(dx, x)) {
      result.is_converged = result.has_jumped = true;
      return;
    }
    share = std::max(smallest_share, share * std::min(2., std::max(0.1, new_norm / norm)));
    norm = new_norm;
  }
}

void Newton::Iteration::solve_linear()
{
  if (!solve_for_update())
    return;
  const double norm = problem.linear_residual();
  iteration_ends(norm, 1);
  if (!std::isfinite(norm))
    return;
  try_update(1);
  accept();
  result.is_converged = norm <= largest_linear_residual;
}

void Newton::Iteration::iterate(double norm)
{
  double first_update = 0;
  while (n_iterations() < settings.maximum_iterations) {
    if (!solve_for_update())
      return;
    // near convergence the next tangent is probably not needed
    const bool is_near = problem.has_linear_stage() || norm * norm <= settings.relative_tolerance;
    if (first_update == 0)
      first_update = problem.norm(dx);
    norm = search_line(norm, !is_near);
    bool is_done = norm <= settings.relative_tolerance && damping.factor == 1 && problem.is_small(dx, trial);
    if (is_near && !is_done && std::isfinite(norm) && damping.factor == 1) {
      norm = problem.residual_and_tangent(trial);
      is_done = problem.has_linear_stage() && norm <= settings.relative_tolerance; // knows more of rounding
    }
    if (is_done && norm > 0 && problem.is_remembered())
      reduce_rest(norm);
    iteration_ends(norm, damping.factor);
    if (!std::isfinite(norm)) {
      if (settings.line_search && problem.may_cross_limit_points() &&
          damping.update > growth_at_limit_point * first_update)
        cross_limit_point();
      return;
    }
    accept();
    if (is_done) {
      result.is_converged = true;
      return;
    }
    if (damping.factor == 1 && problem.adapt(x)) {
      norm = problem.residual_and_tangent(x);
      damping = {};
      if (!std::isfinite(norm))
        return;
    }
  }
}

void Newton::Iteration::solve_stage()
{
  result.is_converged = false;
  damping = {};
  n_before = result.linear_iterations.size();
  const double norm = problem.residual_and_tangent(x);
  if (result.residuals.empty() || !std::isfinite(norm))
    result.residuals.push_back(norm);
  if (!std::isfinite(norm))
    return;
  const bool was_solution = start != Start::predicted && !problem.is_remembered();
  const double sufficient = was_solution ? settings.relative_tolerance : 0;
  if (norm <= sufficient && !problem.moves_constraints() && !problem.has_hidden_load()) // nothing has changed
    result.is_converged = true;
  else if (problem.is_linear())
    solve_linear();
  else
    iterate(norm);
}

NewtonResult Newton::Iteration::solve()
{
  problem.first_stage();
  do
    solve_stage();
  while (result.is_converged && problem.next_stage(x));
  return result;
}

NewtonResult Newton::solve(NonlinearProblem &problem, NonlinearProblem::Vector &x, const Start start) const
{
  return Iteration(*this, problem, x, start).solve();
}

void NewtonResult::append(const NewtonResult &next)
{
  is_converged = next.is_converged;
  residuals.insert(residuals.end(), next.residuals.begin(), next.residuals.end());
  linear_iterations.insert(linear_iterations.end(), next.linear_iterations.begin(),
                           next.linear_iterations.end());
}

} // namespace dovetail
