// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/step_control.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_signal("signal", "a signal asks the run to end");
const NoteName of_path("end of the path", "a path of solutions ends before the End time");

const unsigned int usual_largest_number = 1000; ///< of steps; used.prm has it in every scene
const double smallest_size = 1. / 1024;         ///< of a step or of a share of the load, relative
// of steps by their error
const double smallest_of_run = 1e-9;                ///< of the end time
const double safety = 0.9;                          ///< of the size that the estimate allows
const double largest_growth = 2, largest_cut = 0.2; ///< from one size to the next
const double smallest_change = 0.2;                 ///< less is not worth a new matrix

} // namespace

Steps::Steps(const Section &section)
    : section(section),
      kind(static_cast<Kind>(section.choose(
          "Kind", {"static", "transient", "eigenmodes", "arc length"}, 0,
          "static: loads follow the time t, and nothing is stored; transient: heat "
          "and species are stored, by their capacities; eigenmodes: free vibrations of solids "
          "about the state at the End time; arc length: static, along the path of solutions, on which t may "
          "fall, past limit points [-]"))),
      end_time(section.read<double>("End time", 1.,
                                    "The time t of the last step; the first step starts at 0 [s]",
                                    Patterns::Double(1e-300))),
      n_steps(section.read<unsigned int>("Number of steps", 1, "Equal steps up to the end time [-]",
                                         Patterns::Integer(1))),
      is_adaptive(section.read<bool>("Adaptive", true,
                                     "Halve a step that does not converge, down to the Smallest step [-]")),
      tolerance(section.read<double>(
          "Tolerance", 0,
          "Of the error that one step adds, relative to the range of each field in all bodies: sizes of the "
          "steps follow from it, the first one from the Number of steps; 0: steps are equal [-]",
          Patterns::Double(0, 0.5))),
      smallest(
          section.read<double>("Smallest step", 0,
                               "Of the steps that are tried; 0: 1/1024 of the first one, with a Tolerance "
                               "1e-9 of the End time [s]",
                               Patterns::Double(0))),
      largest(section.read<double>("Largest step", 0, "With a Tolerance; 0: the End time [s]",
                                   Patterns::Double(0))),
      largest_number(section.read<unsigned int>(
          "Largest number of steps", usual_largest_number,
          "With Kind = arc length: after so many the run ends, if the End time has not been reached [-]",
          Patterns::Integer(1)))
{
  section.check(follows_path() || largest_number == usual_largest_number, "Largest number of steps",
                "needs Kind = arc length; otherwise the Number of steps counts.");
  const bool has_inertia =
      section.read<bool>("Inertia", false, "Solids have inertia, by their Density, in transient scenes [-]");
  const bool is_transient = kind == Kind::transient;
  section.check(!has_inertia || is_transient || finds_modes(), "Inertia",
                "needs Kind = transient: a static scene has no accelerations.");
  const bool is_lumped = section.read<bool>("Lumped capacity", false,
                                            "What heat and species store is summed at the nodes, so that no "
                                            "value leaves the range of what is given, "
                                            "however short the steps are; Degree = 1 only [-]");
  section.check(!is_lumped || is_transient, "Lumped capacity",
                "needs Kind = transient: a static scene stores nothing.");
  const bool has_lumped_mass = section.read<bool>(
      "Lumped mass", false,
      "The mass of solids is summed at the nodes, which lowers the frequencies of a mesh: with Inertia, and "
      "of eigenmodes; Degree = 1, or quadrilaterals and hexahedra in scenes without an axis [-]");
  section.check(!has_lumped_mass || finds_modes() || has_inertia, "Lumped mass",
                "needs Inertia = true, or Kind = eigenmodes: else solids have no mass.");
  section.check(tolerance == 0 || is_transient, "Tolerance",
                "needs Kind = transient: a static step has no error in time.");
  section.check(largest == 0 || controls_errors(), "Largest step",
                "needs a Tolerance; without one the Number of steps gives the size.");
  if (smallest == 0)
    smallest = controls_errors() ? smallest_of_run * end_time : smallest_size * size();
  if (largest == 0)
    largest = controls_errors() ? end_time : size();
  section.check(smallest <= std::min(size(), largest), "Smallest step",
                "is larger than the first step, End time / Number of steps, or than the Largest step.");
}

template <int dim>
StepControl<dim>::StepControl(const Steps &steps, NonlinearStep<dim> &step, Results<dim> &results,
                              Notes &notes, Log &log, const MPI_Comm &communicator)
    : steps(steps), step(step), results(results), notes(notes), log(log), communicator(communicator),
      size(std::min(steps.size(), steps.largest)), arc(step, steps.size(), steps.smallest / steps.size())
{
  if (steps.controls_errors())
    step.estimate_errors();
  if (results.has_energy())
    step.keep_supports();
}

/// From the last step of a path, which goes from @p x to @p trial past the end: there.
template <int dim>
NewtonResult StepControl<dim>::end_path(const Vector &x, double &next, Vector &trial)
{
  const double share = (steps.end_time - t) / (next - t);
  trial.sadd(share, 1 - share, x);
  next = steps.end_time;
  step.begin(next, x);
  return step.solve(trial);
}

/// Of a step along the path from @p x, again where ties freeze something anew. @param n_iterations of the
/// last time
template <int dim>
NewtonResult StepControl<dim>::try_arc(const Vector &x, double &next, Vector &trial,
                                       unsigned int &n_iterations)
{
  const unsigned int largest_number_of_passes = 5;
  step.begin(t, x);
  NewtonResult result = arc.solve(x, t, trial, next, step.most_iterations());
  n_iterations = result.linear_iterations.size();
  for (unsigned int pass = 1;
       pass < largest_number_of_passes && result.is_converged && step.system().update_penalties(next, trial);
       ++pass) {
    const NewtonResult again = arc.solve(x, t, trial, next, step.most_iterations());
    n_iterations = again.linear_iterations.size();
    result.append(again);
  }
  if (result.is_converged && next > almost_end())
    result.append(end_path(x, next, trial));
  return result;
}

template <int dim>
bool StepControl<dim>::follow_path(Vector &x)
{
  results.number_pictures();
  while (t < almost_end() && n_good < steps.largest_number) {
    log.step_begins(n_good + 1, 0, t, steps.end_time);
    double next = t;
    Vector trial = x;
    unsigned int n_iterations = 0;
    bool is_good = false;
    try {
      const NewtonResult result = try_arc(x, next, trial, n_iterations);
      results.report().add_step(next, result.residuals, result.linear_iterations);
      step.add_notes();
      is_good = result.is_converged && step.remember(next, trial);
    } catch (const UserError &) { // formulas in t: the steps before it are kept
      if (n_good == 0)
        throw;
      problem_of_step = std::current_exception();
    }
    if (!is_good && (problem_of_step || !arc.shorten())) {
      end_at_last_good(next, x);
      return false;
    }
    if (!is_good) {
      log.step_ends("did not converge; half of the arc is tried");
      continue;
    }
    if (next > t) // past a limit point nothing is stable, as a user of paths expects
      step.note_unstable_solution(next);
    Vector change = trial;
    change -= x;
    arc.accept(change, n_iterations);
    x = trial;
    accept_step(next, x);
    if (ends_for_signal(x))
      return false;
  }
  if (t < almost_end()) {
    if (results.has_checkpoints() && !results.is_checkpoint_due(n_good))
      write_checkpoint(x);
    if (!results.is_due(n_good))
      results.write_pictures({step.system(), x, t, true});
    notes.add(of_path("the path has " + std::to_string(n_good) + " steps and has not reached the End time"));
  }
  return true;
}

template <int dim>
bool StepControl<dim>::run(Vector &x)
{
  if (steps.follows_path())
    return follow_path(x);
  double next = 0;
  Outcome outcome = Outcome::converged;
  while (t < almost_end()) {
    next = outcome == Outcome::out_of_range ? next : end_of_next();
    log.step_begins(n_good + 1, steps.controls_errors() ? 0 : steps.n_steps, next, steps.end_time);
    step.allow_jumps(!steps.controls_errors() && next - t < 0.75 * steps.size()); // it has been halved
    Vector trial = x;
    outcome = Outcome::failed_at_any_size;
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
      if (ends_for_signal(x))
        return false;
    } else if (step.reject_step(); outcome == Outcome::out_of_range)
      log.step_ends("a value leaves the range of what is given; backward Euler is tried");
    else if (outcome == Outcome::inexact)
      log.step_ends("the error of the step is too large; a smaller one is tried");
    else if (!retry_smaller(outcome, next)) {
      end_at_last_good(next, x);
      return false;
    }
  }
  return true;
}

/// Of the steps; sizes do not add up exactly.
template <int dim>
double StepControl<dim>::almost_end() const
{
  return steps.end_time - 1e-6 * std::min(size, steps.size());
}

/// The sum of sizes up to @p time has rounding errors, and a load such as if(t <= 0.5, 1, 0) may see the last
/// digit: the time of an equal step is its share of the End time, as a scene would write it (7/10 of 0.6 is
/// 0.42, not the product's 0.42000000000000004).
template <int dim>
double StepControl<dim>::without_rounding(const double time) const
{
  const double equal = steps.end_time * std::round(time / steps.size()) / steps.n_steps;
  if (!(std::abs(time - equal) < 1e-9 * steps.size()))
    return time;
  std::ostringstream digits;
  digits.precision(12);
  digits << equal;
  const double written = std::stod(digits.str());
  return std::abs(written - equal) <= 4 * std::numeric_limits<double>::epsilon() * steps.end_time ? written
                                                                                                  : equal;
}

/// A step that a toggle cuts short is followed by one that ends where that would have ended: steps stay
/// equal.
template <int dim>
double StepControl<dim>::end_of_next()
{
  double next = t + size < almost_end() ? without_rounding(t + size) : steps.end_time;
  if (cut_short > t)
    next = std::min(next, cut_short);
  const double end = step.end_before_switch(t, next);
  cut_short = next - end > 1e-6 * size ? next : 0; // a switch may be where the step would end anyway
  return end;
}

/// Whether the error of the step to time @p next allows to go on from @p trial; the size of the next one,
/// or of this one tried again.
template <int dim>
bool StepControl<dim>::is_exact_enough(const double next, const Vector &trial)
{
  if (!steps.controls_errors() || !step.has_rates())
    return true;
  const auto error = step.error(next, trial);
  results.report()["steps"].back()["error"] = error.relative;
  const double h = next - t, ratio = steps.tolerance / std::max(error.relative, 1e-300);
  const double factor =
      std::min(largest_growth, std::max(largest_cut, safety * std::pow(ratio, 1. / (error.order + 1))));
  // after a jump the first cells may not follow however small the step is: then its error grows again
  const bool is_of_mesh = error.is_first && rejected_error > 0 && error.relative > rejected_error;
  if (ratio < 1 && !is_of_mesh && h > 1.000001 * steps.smallest) {
    rejected_error = error.is_first ? error.relative : 0;
    size = std::max(steps.smallest, h * factor);
    return false;
  }
  rejected_error = 0;
  if (ratio < 1)
    step.note_inexact_step(next, error.relative, is_of_mesh);
  size_by_error = std::max(factor * h, factor < 1 ? 0 : size); // h may have been cut short
  if (std::abs(size_by_error - size) < smallest_change * size)
    size_by_error = size;
  size_by_error = std::min(steps.largest, std::max(steps.smallest, size_by_error));
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
  const bool is_predicted = step.predict(next, x, trial);
  NewtonResult result = step.solve(trial, is_predicted ? Newton::Start::predicted : Newton::Start::nearby);
  if (!result.is_converged && is_predicted) {
    log.line("  did not converge from the prediction; the step begins at the last state");
    step.begin(next, x);
    trial = x;
    result.append(step.solve(trial));
  }
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
  if (result.is_converged && step.must_start_anew(next, trial)) {
    step.start_first_rates_anew(next);
    return Outcome::out_of_range;
  }
  if (result.is_converged && !is_exact_enough(next, trial))
    return Outcome::inexact;
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
  log.detail("  did not converge; nothing depends on t, so the load is increased bit by bit");
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
  size = steps.controls_errors() ? size_by_error : std::min(steps.size(), 2 * size);
  log.step_ends();
  results.forget_solution();
  if (step.has_rates() || ((steps.n_steps > 1 || steps.follows_path()) && results.has_probes()))
    results.record_step({step.system(), x, t, true, step.velocity(),
                         results.has_energy() ? step.last_motion(x) : StepOfMotion()});
  if (steps.n_steps > 1)
    results.record_ranges({step.system(), x, t, true});
  if (!steps.finds_modes() && (results.is_due(n_good) || t >= almost_end()))
    results.write_pictures({step.system(), x, t, true, step.velocity()});
  remember_good_step();
  if (results.is_checkpoint_due(n_good) || (results.has_checkpoints() && t >= almost_end()))
    write_checkpoint(x);
}

template <int dim>
void StepControl<dim>::remember_good_step()
{
  results.mark_good_step();
  last_good = {{"time", t},
               {"steps", n_good},
               {"size", size},
               {"size by error", size_by_error},
               {"cut short", cut_short},
               {"is of full size", size == steps.size()}};
}

/// Of the last good state @p x, whatever has been tried since then.
template <int dim>
void StepControl<dim>::write_checkpoint(const Vector &x)
{
  SavedState state;
  state.numbers["step control"] = last_good;
  state.vectors["solution"] = x;
  if (steps.follows_path())
    arc.save(state);
  step.save(state);
  results.write_checkpoint(state);
}

/// The number of steps may be another one.
template <int dim>
void StepControl<dim>::go_on(const nlohmann::ordered_json &saved)
{
  t = saved["time"];
  n_good = saved["steps"];
  size = saved["size"];
  size_by_error = saved["size by error"];
  cut_short = saved["cut short"];
  if (steps.controls_errors())
    size = std::min(steps.largest, std::max(steps.smallest, size));
  else
    size = saved["is of full size"] ? steps.size() : std::min(size, steps.size());
  std::ostringstream words;
  words << "t = " << t;
  steps.section.check(t <= steps.end_time + 1e-6 * steps.size(), "End time",
                      "lies before the time of the checkpoint, " + words.str() +
                          ". Set a later one, or run the scene from its beginning, without --resume.");
  last_good = saved;
  if (t >= almost_end())
    log.line("nothing is left of the steps: the checkpoint is of the end, " + words.str());
  else if (steps.controls_errors() || steps.follows_path())
    log.line("goes on after step " + std::to_string(n_good) + ", " + words.str());
  else
    log.line("goes on at step " + std::to_string(n_good + 1) + " of " + std::to_string(steps.n_steps) + ", " +
             words.str());
}

template <int dim>
void StepControl<dim>::go_on_path(const SavedState &saved)
{
  if (steps.follows_path())
    arc.restore(saved);
}

template <int dim>
bool StepControl<dim>::is_asked_to_end()
{
  if (t >= almost_end()) {
    end_request.reset();
    return false;
  }
  if (!end_request)
    end_request.emplace();
  const int signal = EndRequest::signal(communicator);
  if (signal == 0)
    return false;
  std::ostringstream words;
  words << "the run has ended at t = " << t << " of " << steps.end_time << ", after step " << n_good
        << ", since it was asked to by a signal (" << strsignal(signal) << ")";
  notes.add(of_signal(words.str()));
  return true;
}

/// From the last good state @p x a later run goes on.
template <int dim>
bool StepControl<dim>::ends_for_signal(const Vector &x)
{
  if (!is_asked_to_end())
    return false;
  if (!results.is_checkpoint_due(n_good))
    write_checkpoint(x);
  write_last_good(x);
  return true;
}

template <int dim>
void StepControl<dim>::write_last_good(const Vector &x)
{
  if (n_good > 0 && !results.is_due(n_good))
    results.write_pictures({step.system(), x, t, false, step.velocity()});
}

/// @return whether a smaller step than that to time @p next can be tried.
template <int dim>
bool StepControl<dim>::retry_smaller(const Outcome outcome, const double next)
{
  if (outcome != Outcome::failed || size <= steps.smallest)
    return false;
  size = (next - t) / 2; // the last step may have been shorter than size
  log.step_ends("did not converge; half of the step is tried");
  return true;
}

/// The last good state @p x is kept: what is measured belongs to it. @p failed: the time that was not reached
template <int dim>
void StepControl<dim>::end_at_last_good(const double failed, const Vector &x)
{
  log.show_details();
  log.step_ends(problem_of_step ? "cannot be done" : "did not converge");
  if (!problem_of_step)
    step.explain_failure(failed, x);
  if (!step.begin_last_good(t, x) || !step.has_rates())
    results.forget_solution();
  if (n_good > 0 && results.has_checkpoints() && !results.is_checkpoint_due(n_good))
    write_checkpoint(x);
  write_last_good(x);
}

template class StepControl<2>;
template class StepControl<3>;

} // namespace dovetail
