// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/step_control.h>

#include <algorithm>

namespace dovetail {

namespace {

const double smallest_size = 1. / 1024; ///< of a step or of a share of the load, relative

} // namespace

Steps::Steps(const Section &section)
    : is_transient(section.choose("Kind", {"static", "transient"}, 0,
                                  "static: loads follow the time t, and nothing is stored; transient: heat "
                                  "and species are stored, by their capacities [-]") == 1),
      end_time(section.read<double>("End time", 1.,
                                    "The time t of the last step; the first step starts at 0 [s]",
                                    Patterns::Double(1e-300))),
      n_steps(section.read<unsigned int>("Number of steps", 1, "Equal steps up to the end time [-]",
                                         Patterns::Integer(1))),
      is_adaptive(section.read<bool>("Adaptive", true,
                                     "Halve a step that does not converge, down to 1/1024 of its size [-]"))
{
  const bool has_inertia =
      section.read<bool>("Inertia", false, "Solids have inertia, by their Density, in transient scenes [-]");
  section.check(!has_inertia || is_transient, "Inertia",
                "needs Kind = transient: a static scene has no accelerations.");
}

template <int dim>
StepControl<dim>::StepControl(const Steps &steps, NonlinearStep<dim> &step, Results<dim> &results, Log &log)
    : steps(steps), step(step), results(results), log(log), size(steps.size())
{
}

template <int dim>
bool StepControl<dim>::run(Vector &x)
{
  const double almost_end = steps.end_time - 1e-6 * steps.size(); // sizes do not add up exactly
  while (t < almost_end) {
    const double next = t + size < almost_end ? t + size : steps.end_time;
    log.step_begins(n_good + 1, steps.n_steps, next, steps.end_time);
    step.allow_jumps(next - t < 0.75 * steps.size()); // it has been halved
    Vector trial = x;
    Outcome outcome = Outcome::failed_at_any_size;
    try {
      outcome = try_step(next, x, trial);
    } catch (const UserError &) { // toggles, or formulas in t: the steps before it are kept
      if (n_good == 0)
        throw;
      problem_of_step = std::current_exception();
    }
    if (outcome == Outcome::converged) {
      x = trial;
      accept_step(next, x);
    } else if (!retry_smaller(outcome, next)) {
      end_at_last_good(next, x);
      return false;
    }
  }
  return true;
}

/// One step to time @p next from the last good state @p x. @param[in,out] trial begins there, too
template <int dim>
typename StepControl<dim>::Outcome StepControl<dim>::try_step(const double next, const Vector &x,
                                                              Vector &trial)
{
  const bool is_first = t == 0 && !step.has_rates(); // else the first state is no guess
  if (t > 0 && step.is_solution(next, x)) {
    results.report().add_step(next, {step.tolerance()}, {});
    return step.remember(next, x) ? Outcome::converged : Outcome::failed_at_any_size;
  }
  step.begin(next, x);
  step.add_notes();
  NewtonResult result = step.solve(trial);
  Outcome outcome = Outcome::failed_at_any_size;
  const bool may_try_again = steps.is_adaptive && !step.is_linear(); // a linear scene fails in the same way
  if (!result.is_converged && may_try_again && is_first) {
    trial = x;
    if (const auto other = step.solve_from_given_values(next, trial))
      result.append(*other);
  }
  if (!result.is_converged && may_try_again) {
    if (is_first) // the guess may have been another one
      step.find_loads(next, x);
    if (step.has_other_loads((t + next) / 2, x))
      outcome = Outcome::failed;
    else
      result.append(continue_in_load(next, x, trial));
  }
  results.report().add_step(next, result.residuals, result.linear_iterations);
  step.add_notes();
  if (!result.is_converged || !step.remember(next, trial))
    return outcome;
  step.explain_solution(next, trial);
  return Outcome::converged;
}

/// Where halving the step changes nothing: Newton's homotopy in what is not in balance at the last good state
/// @p x.
template <int dim>
NewtonResult StepControl<dim>::continue_in_load(const double next, const Vector &x, Vector &trial)
{
  step.begin(next, x);
  log.line("  did not converge; nothing depends on t, so the load is increased bit by bit");
  step.system().hold_back_from(x);
  NewtonResult result;
  Vector last_good = x;
  double share = 0, increment = 0.5;
  while (share < 1 && increment >= smallest_size) {
    const double next_share = std::min(1., share + increment);
    step.system().set_share(next_share);
    trial = last_good;
    result.append(next_share < 1 ? step.iterate(trial) : step.solve(trial));
    if (result.is_converged) {
      last_good = trial;
      share = next_share;
      increment *= 2;
    } else {
      step.system().begin_step(next, last_good); // the ties forget the share that failed
      increment = (next_share - share) / 2;
    }
  }
  step.system().set_share(1);
  return result;
}

/// Once for each good step, never for one that has failed: what has been tried becomes what the next step
/// starts from.
template <int dim>
void StepControl<dim>::accept_step(const double next, const Vector &x)
{
  t = next;
  ++n_good;
  step.accept_step(next, x);
  size = std::min(steps.size(), 2 * size);
  log.step_ends();
  results.forget_solution();
  if (!results.is_due(n_good) && t != steps.end_time)
    return;
  results.write_pictures({step.system(), x, t, true});
  if (step.has_rates())
    results.record_step({step.system(), x, t, true}, step.tolerance());
}

/// @return whether a smaller step than that to time @p next can be tried.
template <int dim>
bool StepControl<dim>::retry_smaller(const Outcome outcome, const double next)
{
  if (outcome != Outcome::failed || size <= steps.size() * smallest_size)
    return false;
  size = (next - t) / 2; // the last step may have been shorter than size
  log.step_ends("did not converge; half of the step is tried");
  return true;
}

/// The last good state @p x is kept: what is measured belongs to it. @p failed: the time that was not reached
template <int dim>
void StepControl<dim>::end_at_last_good(const double failed, const Vector &x)
{
  log.step_ends(problem_of_step ? "cannot be done" : "did not converge");
  if (!problem_of_step)
    step.explain_failure(failed, x);
  step.begin_last_good(t, x);
  results.forget_solution(); // the ties may have been set up anew
  if (n_good > 0 && !results.is_due(n_good))
    results.write_pictures({step.system(), x, t, false});
}

template class StepControl<2>;
template class StepControl<3>;

} // namespace dovetail
