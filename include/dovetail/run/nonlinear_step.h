// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// One step: the solution at a time from the last good one.

#pragma once

#include <dovetail/measure/energy_balance.h>
#include <dovetail/output/checkpoint.h>
#include <dovetail/output/notes.h>
#include <dovetail/output/plan.h>
#include <dovetail/run/condition_switches.h>
#include <dovetail/run/predictor.h>
#include <dovetail/run/range_watch.h>
#include <dovetail/run/start_of_motion.h>
#include <dovetail/run/step_problem.h>
#include <dovetail/time/time_scheme.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dovetail {

/// Owns the equations of the present meshes and what solves them, and tries single steps: which ones, and
/// what comes after a failure, StepControl decides.
template <int dim>
class NonlinearStep
{
public:
  /// Reads the sections `Newton` and `Linear solver` of a scene; the others are kept by reference.
  /// @p n_equal_steps: as many steps are of one size at least, unless some fail.
  NonlinearStep(const Section &scene, Model<dim> &model, unsigned int n_equal_steps, Phases &phases,
                Notes &notes, Log &log);

  /// The equations on the present meshes with what is active at time @p t. Collective.
  void make_system(double t);
  /// Before the meshes change.
  void release_system();

  /// The state @p x at the time 0, from which rates go on to time @p t. Where something has inertia what
  /// follows by constraints of ties and cells does so.
  void start(double t, Vector &x);
  /// The step to time @p t has led to @p x. A step that fails leaves no trace in the time scheme.
  void accept_step(double t, const Vector &x);
  /// The step that was tried last is rejected: what comes next is not predicted from the steps before.
  void reject_step() { predictor.forget(); }
  bool has_rates() const { return scheme != nullptr; } ///< a term asks for them
  /// Of the last good step, which has led to @p x; empty where nothing has inertia.
  StepOfMotion last_motion(const Vector &x) const;
  void keep_supports() { keeps_supports = true; } ///< before start(): last_motion() will be asked
  /// The first rates of the last good state, where some term asks for second ones; else nullptr.
  const Vector *velocity() const
  {
    return scheme && !scheme->memory().rates.empty() ? &scheme->memory().rates[0] : nullptr;
  }

  /// What later steps depend on, after a good one.
  void save(SavedState &to) const;
  /// Instead of start(): the last good step was that to time @p t, which has led to @p x.
  void go_on(const Checkpoint<dim> &checkpoint, const SavedState &from, double t, const Vector &x);

  /// The end of a step from the last good one: @p end, or before it the last time at which all toggles are as
  /// they are just after @p begin.
  double end_before_switch(double begin, double end) const;
  /// Whether the step to time @p t that has led to @p x looks back on more than one state, and leaves the
  /// range of what is given although capacity is lumped: then backward Euler does not. Collective.
  bool must_start_anew(double t, const Vector &x);
  /// In the step to time @p t.
  void start_first_rates_anew(const double t) { present_step = scheme->step_to(t).with_new_first_rates(); }

  /// Before start(): error() will be asked.
  void estimate_errors();
  /// What a step adds to the error: the largest of all free unknowns that are stored, relative to the range
  /// that the values of their field have had so far. It shrinks like the size to the power order + 1.
  struct Error
  {
    double relative = 0;
    unsigned int order = 1;
    bool is_first = false; ///< after a new start
  };
  /// Of the step to time @p t that has led to @p x. Collective.
  Error error(double t, const Vector &x);
  /// A step has that error and is taken: it is the smallest one that is allowed or, after a jump, the cells
  /// are too large for a smaller one. Once.
  void note_inexact_step(double t, double relative_error, bool is_of_mesh);

  /// Whether @p x solves the equations of time @p t as it is. Newton's method sees that for itself, unless
  /// weights and penalties of ties are frozen anew in each step: here they stay as they are. Never where a
  /// tie follows fields, which only a step that begins asks. Collective.
  bool is_solution(double t, const Vector &x);
  /// A step to time @p t from @p x begins.
  void begin(double t, const Vector &x);
  /// In the step to time @p t from @p x that has begun: let @p trial be the last solutions, extrapolated, if
  /// that leaves a smaller residual than @p x does with the prescribed values of time t. In a linear scene
  /// the solver is told instead. @return whether trial has changed. Collective.
  bool predict(double t, const Vector &x, Vector &trial);
  /// Of steps that began, or whose solver began, from there.
  unsigned int n_predicted() const { return n_predictions + (problem ? problem->n_guesses_taken() : 0); }
  /// The last good step, which led to @p x at time @p t, is what the system stands for again. Ties freeze at
  /// its end what they froze at its beginning. @return whether what was measured of it holds still: not if
  /// the system has been set up for other toggles.
  bool begin_last_good(double t, const Vector &x);
  /// Newton's method from @p x, which becomes the last iterate.
  NewtonResult iterate(Vector &x, Newton::Start start = Newton::Start::nearby);
  /// Likewise, and again from there until the penalties that are frozen during a step fit the solution.
  NewtonResult solve(Vector &x, Newton::Start start = Newton::Start::nearby);
  /// The first step starts from a guess. If it fails from there, and by a scalar field, that begins anew:
  /// from the mean of what conditions prescribe, which spreads through the bodies as if nothing else acted on
  /// them. Nothing if there is no other guess.
  std::optional<NewtonResult> solve_from_given_values(double t, Vector &x);

  /// Let the laws remember the solution @p x of time @p t. @return false if one is not defined there.
  bool remember(double t, const Vector &x) { return present_system->remember(t, x); }

  /// Let loads() be those of a step to time @p t from @p x.
  void find_loads(double t, const Vector &x);
  /// Whether a step to time @p t from @p x would begin with others than the last one did.
  bool has_other_loads(double t, const Vector &x);
  void allow_jumps(const bool are_allowed) { problem->allow_jumps(are_allowed); } ///< past limit points

  /// What is known by now that a user should know.
  void add_notes();
  /// What is strange about the solution @p x at time @p t.
  void explain_solution(double t, const Vector &x);
  /// The first time that the solution at time @p t is in balance, but not stable.
  void note_unstable_solution(double t);
  /// What is strange about all good steps together.
  void explain_steps();
  /// After the step to time @p t has failed: where the last iteration left the largest residual, and what may
  /// help. @p x: the last good state. Perhaps a body is free; the tangent there knows.
  void explain_failure(double t, const Vector &x);

  bool is_linear() const { return model.is_linear(); }
  double tolerance() const { return newton.residual_tolerance(); } ///< of the residual, relative
  BlockSystem<dim> &system() { return *present_system; }
  StepProblem<dim> &equations() { return *problem; } ///< of the step that has begun
  unsigned int most_iterations() const { return newton.largest_number(); }
  bool has_system() const { return present_system && problem; } ///< not if the meshes have changed in vain
  const LinearSolver &solver() const { return linear_solver; }
  LinearSolver &solver() { return linear_solver; }
  void add_to(Plan &plan) const;
  std::vector<SolveGroup> solve_groups() const;
  typename BlockSystem<dim>::Assemblies assemblies() const; ///< of all systems so far

private:
  void set_up(double t);
  void begin(double t, const Vector &x, const Rates &rates);
  StartOfMotion<dim> start_of_motion(double end);
  void find_second_rates(const Vector &x);
  void find_supports(double now, const Vector &x, const Vector &forces);
  /// present_step, once it is the step to time @p t.
  const StepTime &step_to(double t);
  Rates rates_to(double t);
  bool starts_anew(double begin, double t) const;
  bool has_switched_by_fields() const;
  bool has_pushed_by_fields() const;
  bool has_shrunk();
  bool may_predict() const;
  using Ranges = std::map<std::string, ValueRange>; ///< by field
  void widen(Ranges &ranges, const Vector &x) const;
  std::vector<std::string> describe_failure() const;
  std::string what_failed() const;
  std::string what_may_help() const;

  Model<dim> &model;
  const unsigned int n_equal_steps;
  Phases &phases;
  Notes &notes;
  Log &log;
  Newton newton;
  std::unique_ptr<TimeScheme> scheme;           ///< nullptr if no term asks for rates
  std::unique_ptr<GivenValues<dim>> given;      ///< on the present meshes
  std::unique_ptr<RangeWatch<dim>> range_watch; ///< likewise
  Ranges ranges;                                ///< so far, for errors
  Ranges ranges_of_first;                       ///< and in the tries of a first step
  bool has_noted_inexact_step = false, has_noted_unstable_solution = false;
  StepTime present_step; ///< the last one that was asked for
  Rates rates_of_last_good;
  std::optional<Vector> second_rates_at_start; ///< of the last new start, if the scheme asked for them
  Vector rates_at_start;                       ///< likewise
  bool keeps_supports = false;
  Vector supports_at_start; ///< likewise, if that is asked for
  std::unique_ptr<BlockSystem<dim>> present_system;
  LinearSolver linear_solver; ///< refers to the system's matrix, so it is destroyed first
  std::unique_ptr<StepProblem<dim>> problem;
  NewtonResult last_result;
  Predictor predictor;
  ConditionSwitches<dim> condition_switches;
  Vector begin_of_step;                   ///< the state; only for conditions whose toggles look at fields
  std::vector<bool> toggles_of_predictor; ///< active ones
  unsigned int n_predictions = 0;
  bool has_jumped = false;                                      ///< in this step, past a limit point
  std::vector<std::string> failure;                             ///< of the last iteration that failed
  typename BlockSystem<dim>::Assemblies assemblies_of_released; ///< systems
};

} // namespace dovetail
