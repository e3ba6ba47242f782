// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/nonlinear_step.h>

#include <dovetail/domain/cell_terms.h>
#include <dovetail/material/transient.h>
#include <dovetail/run/initial_values.h>
#include <dovetail/run/saved_time.h>
#include <dovetail/system/place.h>
#include <dovetail/system/solve_groups.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

namespace dovetail {

namespace {

const NoteName of_snap_through("snap through", "the solution jumps within a step");
const NoteName of_unstable_solution("unstable solution", "a static solution is in balance but not stable");
const NoteName of_time_step("time step", "the error of a time step is above the Tolerance");
const NoteName of_failure("failure", "a step does not converge");

template <int dim>
bool follows_fields(const Model<dim> &model)
{
  return model.has_conditions_by_fields() ||
         std::any_of(model.interfaces.begin(), model.interfaces.end(),
                     [](const auto &interface) { return interface->tie().follows_fields(); });
}

} // namespace

template <int dim>
NonlinearStep<dim>::NonlinearStep(const Section &scene, Model<dim> &model, const unsigned int n_equal_steps,
                                  Phases &phases, Notes &notes, Log &log)
    : model(model), n_equal_steps(n_equal_steps), phases(phases), notes(notes), log(log),
      newton(scene.subsection("Newton")), scheme(make_time_scheme(scene.subsection("Steps"))),
      linear_solver(scene.subsection("Linear solver"),
                    scene.documenting() ? std::vector<SolveGroup>() : solve_groups())
{
  if (model.order_in_time() == 0 || finds_eigenmodes(scene))
    scheme.reset();
  else if (model.sees_past())
    scheme->show_past();
}

template <int dim>
void NonlinearStep<dim>::add_to(Plan &plan) const
{
  if (scheme)
    plan.needed.push_back("rates in time: " + scheme->description());
}

template <int dim>
std::vector<SolveGroup> NonlinearStep<dim>::solve_groups() const
{
  auto groups =
      make_solve_groups<dim>(model, [this]() -> const BlockSystem<dim> & { return *present_system; });
  if (model.has_constant_tangent())
    for (SolveGroup &group : groups)
      group.n_solves = n_equal_steps;
  return groups;
}

template <int dim>
void NonlinearStep<dim>::make_system(const double t)
{
  present_system = std::make_unique<BlockSystem<dim>>(model);
  present_system->leave_out_couplings(model.solves_stages_apart());
  predictor.forget();
  set_up(t);
  problem = std::make_unique<StepProblem<dim>>(model, *present_system, newton, linear_solver, phases, log);
  given = std::make_unique<GivenValues<dim>>(model);
  range_watch = std::make_unique<RangeWatch<dim>>(model, *given);
}

template <int dim>
void NonlinearStep<dim>::release_system()
{
  phases.add("tie", present_system->seconds_of_ties());
  assemblies_of_released = assemblies();
  linear_solver.forget_matrix();
  n_predictions = n_predicted();
  problem.reset();
  present_system.reset();
}

/// A gap that a tie by constraints would close in the first step is one between interpolations.
template <int dim>
void NonlinearStep<dim>::start(const double t, Vector &x)
{
  if (scheme && model.order_in_time() > 1) {
    Vector rate = initial_rates(model, x);
    present_system->begin_step(t, x);
    StartOfMotion<dim> motion = start_of_motion(t);
    motion.satisfy_ties(x, rate);
    notes.add(motion.notes());
    scheme->start(x, rate);
  } else if (scheme)
    scheme->start(x);
  present_system->look_at_start(x);
  if (!scheme)
    return;
  range_watch->start(x);
  widen(ranges, x);
  ranges_of_first = ranges;
}

template <int dim>
void NonlinearStep<dim>::save(SavedState &to) const
{
  to.numbers["step"] = {{"ranges", ranges},
                        {"has noted an inexact step", has_noted_inexact_step},
                        {"toggles of predictor", toggles_of_predictor}};
  save_predictor(predictor, to);
  if (model.has_conditions_by_fields())
    to.vectors["begin of the last step"] = begin_of_step;
  if (!scheme)
    return;
  to.numbers["step"]["histories"] = range_watch->save();
  save_memory(scheme->memory(), to);
  save_rates(rates_of_last_good, to);
}

template <int dim>
void NonlinearStep<dim>::go_on(const Checkpoint<dim> &checkpoint, const SavedState &from, const double t,
                               const Vector &x)
{
  const nlohmann::ordered_json &numbers = from.numbers["step"];
  ranges = numbers["ranges"].get<Ranges>();
  ranges_of_first = ranges;
  has_noted_inexact_step = numbers["has noted an inexact step"];
  predictor = saved_predictor(from);
  toggles_of_predictor = numbers["toggles of predictor"].get<std::vector<bool>>();
  checkpoint.restore_memory(model);
  if (scheme) {
    range_watch->restore(numbers["histories"]);
    scheme->restore(saved_memory(from));
    rates_of_last_good = saved_rates(from);
  }
  problem->set_converged();
  if (model.has_conditions_by_fields())
    present_system->keep_last_good(t, from.vectors.at("begin of the last step"));
  begin_last_good(t, x);
  checkpoint.restore_penalties(model);
}

template <int dim>
const StepTime &NonlinearStep<dim>::step_to(const double t)
{
  const StepTime &last = scheme->memory().last;
  if (present_step.begin != last.end || present_step.end != t || present_step.size == 0) {
    const bool looks_back = last.size > 0 && scheme->order() > 1;
    present_step = scheme->step_to(t, looks_back && starts_anew(last.end, t));
  }
  return present_step;
}

/// Toggles are asked just before and just after a step begins, too, which it may do where one switches.
template <int dim>
bool NonlinearStep<dim>::starts_anew(const double begin, const double t) const
{
  return model.active_toggles(begin) != model.active_toggles(t) || given->jump_between(begin, t);
}

/// Whether the step that has begun is on another curve, since a toggle that looks at fields has switched,
/// also one that chooses the material of a point.
template <int dim>
bool NonlinearStep<dim>::has_switched_by_fields() const
{
  return condition_switches.have_switched() ||
         std::any_of(model.interfaces.begin(), model.interfaces.end(),
                     [](const auto &interface) { return interface->tie().has_switched(); });
}

/// Whether it is a force on what has inertia that has switched, so that accelerations jump. Others, as a
/// heater, change no acceleration, and a motion would lose by a new start.
template <int dim>
bool NonlinearStep<dim>::has_pushed_by_fields() const
{
  return condition_switches.have_pushed() ||
         std::any_of(model.interfaces.begin(), model.interfaces.end(), [](const auto &interface) {
           return interface->tie().has_switched() &&
                  std::any_of(interface->fields.begin(), interface->fields.end(),
                              [&](const TiedField &field) {
                                const unsigned int first = field.first_component[source];
                                return interface->sides[source].domain->material.order_in_time(first) > 1;
                              });
         });
}

/// Whether the step that has begun is smaller than the last one, and knows accelerations that belong to that.
/// In incompressible bodies at large strain what the motion is off the volume by in the larger step would
/// have to be closed by accelerations, which grow without limit.
template <int dim>
bool NonlinearStep<dim>::has_shrunk()
{
  const TimeMemory &memory = scheme->memory();
  return !memory.second_rates.empty() && present_step.size < 0.999 * memory.last.size &&
         start_of_motion(present_step.end).may_limit_volume();
}

namespace {

const double just_after = 1e-9; ///< the beginning of a step, relative to its size

} // namespace

template <int dim>
StepOfMotion NonlinearStep<dim>::last_motion(const Vector &x) const
{
  if (velocity() == nullptr)
    return {};
  const StepTime &last = scheme->memory().last;
  StepOfMotion motion;
  motion.rates_at_end = *velocity();
  motion.second_rates_at_end = rates_of_last_good.second_rest;
  motion.second_rates_at_end->add(rates_of_last_good.second_by_value, x);
  if (last.size > 0 && (last.starts_anew || last.begin == 0)) {
    motion.new_start = last.begin + just_after * last.size;
    motion.rates_at_start = rates_at_start;
    motion.second_rates_at_start = second_rates_at_start;
    motion.supports_at_start = supports_at_start;
  }
  return motion;
}

template <int dim>
StartOfMotion<dim> NonlinearStep<dim>::start_of_motion(const double end)
{
  return {model, *present_system, *problem, linear_solver, phases, end};
}

/// Those of constrained unknowns are constant during the step: what is prescribed is known at its end only.
template <int dim>
void NonlinearStep<dim>::find_second_rates(const Vector &x)
{
  const double h = present_step.size, now = present_step.begin + just_after * h;
  StartOfMotion<dim> motion = start_of_motion(present_step.end);
  if (scheme->memory().last.size > 0 && motion.may_limit_volume()) {
    Vector kept = scheme->memory().rates[0];
    motion.keep_volume(now, x, kept);
    scheme->change_rate(kept);
  }
  const Vector &rate = scheme->memory().rates[0];
  Vector of_constrained = x, along = rate;
  present_system->constrain(of_constrained);
  of_constrained -= x;
  present_system->distribute_rate(along, true);
  along -= rate;
  of_constrained.add(h, along);
  of_constrained *= 2 / (h * h);
  Vector forces = x;
  const auto found = motion.second_rates(now, x, rate, of_constrained, h, forces);
  second_rates_at_start = found.value_or(of_constrained); // else the step fails by itself
  rates_at_start = rate;
  if (keeps_supports)
    find_supports(now, x, forces);
  scheme->start_second_rates(*second_rates_at_start);
}

/// Before the step changes what materials and ties remember.
template <int dim>
void NonlinearStep<dim>::find_supports(const double now, const Vector &x, const Vector &forces)
{
  Vector state = x;
  for (unsigned int b = 0; b < state.n_blocks(); ++b)
    if (model.numbering->blocks()[b].is_constraint)
      state.block(b) = forces.block(b);
  Rates rates;
  rates.rest = rates_at_start;
  rates.second_rest = *second_rates_at_start;
  rates.weights = {0};
  rates.past = {state};
  const Vector ghosted = present_system->ghosted(state);
  const NodalForces<dim> nodal = present_system->nodal_forces(state, now, rates);
  supports_at_start = forces_of_supports(model, Reactions<dim>(model, nodal, ghosted), x);
}

template <int dim>
double NonlinearStep<dim>::end_before_switch(const double begin, const double end) const
{
  if (!scheme)
    return end;
  const double least = just_after * (end - begin); // what is nearer counts as the beginning
  const auto at_begin = model.active_toggles(begin + least);
  const unsigned int n_looks = 8;
  double before = begin + least, after = end;
  bool is_found = false;
  for (unsigned int i = 1; i <= n_looks && !is_found; ++i) {
    const double look = i == n_looks ? end : begin + i * (end - begin) / n_looks;
    is_found = model.active_toggles(look) != at_begin;
    (is_found ? after : before) = look;
  }
  if (!is_found)
    return end;
  for (double middle = (before + after) / 2; before < middle && middle < after; middle = (before + after) / 2)
    (model.active_toggles(middle) == at_begin ? before : after) = middle;
  return before > begin + 2 * least ? before : end;
}

/// Where nothing but solids with inertia stores, no term sees first rates, and no tangent depends on them.
template <int dim>
Rates NonlinearStep<dim>::rates_to(const double t)
{
  if (!scheme)
    return Rates();
  Rates rates = scheme->rates(step_to(t));
  const bool sees_first = std::any_of(model.domains.begin(), model.domains.end(), [](const auto &domain) {
    return std::any_of(domain->fields().begin(), domain->fields().end(), [&](const Field &field) {
      return !field.is_multiplier && domain->material.order_in_time(field.first_component) < 2;
    });
  });
  if (!sees_first)
    rates.by_value = 0;
  return rates;
}

template <int dim>
void NonlinearStep<dim>::accept_step(const double t, const Vector &x)
{
  if (has_jumped)
    predictor.forget();
  if (may_predict())
    predictor.add(t, x);
  if (!scheme)
    return;
  const StepTime this_step = step_to(t);
  rates_of_last_good = scheme->rates(this_step);
  scheme->accept_step(this_step, x);
  range_watch->add(t, this_step.size, x);
  widen(ranges, x);
  ranges_of_first = ranges;
}

template <int dim>
bool NonlinearStep<dim>::must_start_anew(const double t, const Vector &x)
{
  const bool looks_back = scheme && scheme->order() > 1 && scheme->memory().states.size() > 1;
  return looks_back && !step_to(t).begins_curve() &&
         std::any_of(model.domains.begin(), model.domains.end(),
                     [](const auto &domain) { return !lumped_components(*domain, 1).empty(); }) &&
         range_watch->leaves(t, x);
}

template <int dim>
void NonlinearStep<dim>::estimate_errors()
{
  if (scheme)
    scheme->estimate_errors();
}

template <int dim>
void NonlinearStep<dim>::widen(Ranges &ranges, const Vector &x) const
{
  const auto &blocks = model.numbering->blocks();
  for (unsigned int b = 0; b < blocks.size(); ++b) {
    if (blocks[b].is_of_multipliers)
      continue;
    const double smallest = x.block(b).min(), largest = x.block(b).max();
    ValueRange &range = ranges.try_emplace(blocks[b].field, ValueRange{{smallest, largest}}).first->second;
    range = {{std::min(range[0], smallest), std::max(range[1], largest)}};
  }
}

template <int dim>
typename BlockSystem<dim>::Assemblies NonlinearStep<dim>::assemblies() const
{
  auto sum = assemblies_of_released;
  if (!present_system)
    return sum;
  sum.tangents += present_system->assemblies().tangents;
  sum.residuals_alone += present_system->assemblies().residuals_alone;
  sum.tangents_by_sums += present_system->assemblies().tangents_by_sums;
  sum.residuals_by_products += present_system->assemblies().residuals_by_products;
  return sum;
}

template <int dim>
void NonlinearStep<dim>::set_up(const double t)
{
  const Phases::Scope scope(phases, "setup");
  linear_solver.forget_matrix();
  model.check_ties(t);
  present_system->set_up(t, [this]() {
    linear_solver.consider_constraints();
    return linear_solver.needs_entries();
  });
  add_notes();
}

template <int dim>
void NonlinearStep<dim>::add_notes()
{
  notes.add(present_system->notes());
  notes.add(linear_solver.notes());
  if (problem)
    notes.add(problem->notes());
}

template <int dim>
bool NonlinearStep<dim>::is_solution(const double t, const Vector &x)
{
  if (has_rates() || model.is_linear() || model.interfaces.empty() || present_system->is_outdated(t) ||
      follows_fields(model))
    return false;
  present_system->set_time(t);
  problem->begin_step(t, x);
  return problem->residual(x) <= tolerance() && !present_system->moves_constraints() &&
         !problem->has_hidden_load();
}

template <int dim>
void NonlinearStep<dim>::begin(const double t, const Vector &x)
{
  const auto asks = [&]() { return scheme && scheme->asks_for_second_rates(step_to(t)); };
  const bool has_asked = asks();
  begin(t, x, has_asked ? Rates() : rates_to(t));
  bool starts = has_asked;
  if (has_switched_by_fields()) {
    predictor.forget();
    if (scheme && scheme->order() > 1 && scheme->memory().last.size > 0 && !step_to(t).starts_anew) {
      present_step =
          has_pushed_by_fields() ? scheme->step_to(t, true) : scheme->step_to(t).with_new_first_rates();
      starts = true;
    }
  }
  if (scheme && has_shrunk()) {
    present_step = scheme->step_to(t, true);
    starts = true;
  }
  if (asks())
    find_second_rates(x);
  if (starts)
    present_system->set_rates(rates_to(t));
}

template <int dim>
bool NonlinearStep<dim>::begin_last_good(const double t, const Vector &x)
{
  const bool is_the_same = !present_system->is_outdated(t);
  begin(t, x, rates_of_last_good);
  return is_the_same;
}

template <int dim>
void NonlinearStep<dim>::begin(const double t, const Vector &x, const Rates &rates)
{
  if (present_system->is_outdated(t))
    set_up(t);
  const Phases::Scope scope(phases, "setup");
  has_jumped = false;
  if (model.has_conditions_by_fields())
    begin_of_step = x;
  present_system->set_rates(rates);
  present_system->begin_step(t, x);
  problem->begin_step(t, x);
  condition_switches.look(model, t);
  if (scheme && scheme->memory().last.size > 0 &&
      std::any_of(model.materials.begin(), model.materials.end(),
                  [](const auto &material) { return material->has_phases(); }))
    condition_switches.look_at_phases(model, scheme->memory().last.end, t, present_system->ghosted(x));
}

/// A linear scene that is solved directly does not ask where its solution may lie.
template <int dim>
bool NonlinearStep<dim>::may_predict() const
{
  return !model.is_linear() || linear_solver.iterates();
}

/// The first assembly is at x: what a step freezes there, and what it is measured by, stays as it is without
/// a prediction.
template <int dim>
bool NonlinearStep<dim>::predict(const double t, const Vector &x, Vector &trial)
{
  const std::vector<bool> active = model.active_toggles(t);
  if (std::exchange(toggles_of_predictor, active) != active)
    predictor.forget();
  if (!predictor.has_guess() || !may_predict())
    return false;
  Vector guess = predictor.guess(t);
  if (model.is_linear()) {
    guess -= x;
    problem->set_guess(guess);
    return false;
  }
  problem->first_stage(); // what iterates judges the guess
  Vector moves = x;
  present_system->constrain(moves);
  moves -= x;
  // what prescribed values do when they move is known by the tangent only
  const double at_x = moves.linfty_norm() > 0 ? problem->residual_and_tangent(x) : problem->residual(x);
  present_system->constrain(guess);
  if (!(problem->start_at(guess) < at_x)) {
    begin(t, x);
    return false;
  }
  trial = guess;
  ++n_predictions;
  return true;
}

template <int dim>
NewtonResult NonlinearStep<dim>::iterate(Vector &x, const Newton::Start start)
{
  last_result = newton.solve(*problem, x, start);
  if (last_result.is_converged)
    problem->set_converged();
  else
    failure = describe_failure();
  has_jumped = has_jumped || last_result.has_jumped;
  return last_result;
}

template <int dim>
NewtonResult NonlinearStep<dim>::solve(Vector &x, const Newton::Start start)
{
  if (model.is_linear())
    present_system->constrain(x);
  NewtonResult result = iterate(x, start);
  const unsigned int largest_number_of_passes = 5;
  for (unsigned int pass = 1; pass < largest_number_of_passes && result.is_converged &&
                              present_system->update_penalties(problem->time(), x);
       ++pass) {
    log.detail("  penalties no longer fit the solution: solved again from here");
    result.append(iterate(x));
  }
  return result;
}

template <int dim>
std::optional<NewtonResult> NonlinearStep<dim>::solve_from_given_values(const double t, Vector &x)
{
  const std::string &name = model.numbering->blocks()[problem->convergence().worst_part()].field;
  const bool is_scalar = std::any_of(model.domains.begin(), model.domains.end(), [&](const auto &domain) {
    const Field *field = domain->material.find_field(name);
    return field != nullptr && field->n_components == 1;
  });
  if (!is_scalar)
    return {};
  log.detail("  did not converge from the first guess; the " + name + " begins at what is prescribed");
  set_initial_values(model, t, x, name);
  begin(t, x);
  const bool is_guess = problem->spread_prescribed_values(x);
  begin(t, x);
  return solve(x, is_guess ? Newton::Start::guess : Newton::Start::nearby);
}

template <int dim>
void NonlinearStep<dim>::find_loads(const double t, const Vector &x)
{
  begin(t, x);
  problem->first_stage();           // as Newton's method does
  problem->residual_and_tangent(x); // moving prescribed values are loads by the tangent
}

template <int dim>
bool NonlinearStep<dim>::has_other_loads(const double t, const Vector &x)
{
  if (has_rates() || present_system->is_outdated(t))
    return true;
  const auto last_loads = problem->loads();
  find_loads(t, x);
  for (const unsigned int i : {0, 1})
    if (std::abs(problem->loads()[i] - last_loads[i]) > 1e-12 * last_loads[i])
      return true;
  return false;
}

/// As the beginning of "… of the temperature of left".
template <int dim>
std::string NonlinearStep<dim>::what_failed() const
{
  const double residual = problem->last_residual();
  if (!std::isfinite(residual))
    return "the last state that was tried is not defined; the largest residual is that";
  if (!std::isfinite(last_result.residuals.back()))
    return "no share of the last update leads on; the largest residual is that";
  std::ostringstream words;
  words.precision(2);
  words << "the largest residual, " << residual << " of the forces at work, is that";
  return words.str();
}

template <int dim>
std::string NonlinearStep<dim>::what_may_help() const
{
  if (has_rates()) { // its Initial is no guess
    const bool may_gain_energy = !scheme->memory().second_rates.empty() && model.has_large_strain();
    return std::string("Take smaller steps: raise Number of steps in the subsection Steps.") +
           (may_gain_energy
                ? " At large strain oscillations that steps do not resolve may gain energy; a smaller "
                  "Spectral radius damps them, and Energy = true in the subsection Output shows it."
                : "");
  }
  if (last_result.linear_iterations.size() >= newton.largest_number())
    return "Raise Maximum iterations in the subsection Newton, or give an Initial that is nearer to the "
           "solution.";
  return "Let the load grow with t in more steps, or give an Initial that is nearer to the solution.";
}

template <int dim>
void NonlinearStep<dim>::explain_solution(const double t, const Vector &x)
{
  if (has_jumped) {
    std::ostringstream words;
    words.precision(4);
    words << "in the step to t = " << t
          << " the solution jumps: the tangent became singular on the way, as where bodies or single cells "
             "snap "
             "through. What comes after depends on the path; compare with smaller steps and a finer mesh";
    notes.add(of_snap_through(words.str()));
  }
  note_unstable_solution(t);
  if (!scheme)
    notes.add(range_watch->explain(t, x));
}

/// With inertia the tangent is not that of the forces alone, and what is unstable moves.
template <int dim>
void NonlinearStep<dim>::note_unstable_solution(const double t)
{
  if (has_noted_unstable_solution || model.order_in_time() > 1 || !problem->is_unstable())
    return;
  has_noted_unstable_solution = true;
  std::ostringstream words;
  words.precision(4);
  words
      << "the solution at t = " << t
      << " is in balance but not stable: the tangent has a negative eigenvalue, "
      << (model.has_large_strain()
              ? "as past a buckling load. Bodies leave such a state for another one; a small load or a small "
                "change of the shape may lead there, and the modes of Kind = eigenmodes show the direction"
              : "as with a material that softens, or with a penalty of a tie that is too small");
  notes.add(of_unstable_solution(words.str()));
}

template <int dim>
void NonlinearStep<dim>::explain_steps()
{
  if (scheme)
    notes.add(range_watch->explain_history());
}

/// After the first step only how far it has led is known, d: of what decays like exp(-t) it leaves the error
/// d^2/2. Loads may begin suddenly, and what they lead to gives the range: also that of a larger first step
/// that has been given up, without which a body whose values are equal at first would never be judged. A
/// field that moves by its inertia is not judged before the second step.
template <int dim>
typename NonlinearStep<dim>::Error NonlinearStep<dim>::error(const double t, const Vector &x)
{
  StepError error = scheme->local_error(step_to(t), x);
  const bool is_first = error.order == 0;
  for (const auto dof : model.numbering->owned)
    if (present_system->is_constrained(dof))
      error.state_error(dof) = 0;
  error.state_error.compress(dealii::VectorOperation::insert);
  Error result = {0, std::max(1u, error.order), is_first};
  if (is_first)
    widen(ranges_of_first, x);
  Ranges ranges_with = is_first ? ranges_of_first : ranges;
  widen(ranges_with, x);
  const auto &blocks = model.numbering->blocks();
  for (unsigned int b = 0; b < blocks.size(); ++b) {
    if (blocks[b].is_of_multipliers)
      continue;
    const auto &domain = *model.domains[blocks[b].domain_index];
    const unsigned int order_in_time =
        domain.material.order_in_time(domain.fields()[blocks[b].field_index].first_component);
    if (order_in_time == 0 || (is_first && order_in_time > 1))
      continue;
    const ValueRange &range = ranges_with.at(blocks[b].field);
    const double width = range[1] - range[0],
                 rounding = 1e-12 * std::max(std::abs(range[0]), std::abs(range[1]));
    if (!(width > rounding))
      continue;
    const double relative = error.state_error.block(b).linfty_norm() / width;
    result.relative = std::max(result.relative, is_first ? relative * relative / 2 : relative);
  }
  return result;
}

template <int dim>
void NonlinearStep<dim>::note_inexact_step(const double t, const double relative_error, const bool is_of_mesh)
{
  if (std::exchange(has_noted_inexact_step, true))
    return;
  std::ostringstream words;
  words.precision(3);
  words << "the step to t = " << t << " has the error " << relative_error
        << " of the range of its field, more than the Tolerance, but "
        << (is_of_mesh ? "a smaller one has a larger error: cells are too large for what jumps there"
                       : "the Smallest step allows no smaller one");
  notes.add(of_time_step(words.str()));
}

/// Before anything else is assembled.
template <int dim>
std::vector<std::string> NonlinearStep<dim>::describe_failure() const
{
  const unsigned int part = problem->convergence().worst_part();
  const Block &block = model.numbering->blocks()[part];
  std::ostringstream words;
  words.precision(3);
  words << what_failed() << " of the " << block.field << (block.is_of_multipliers ? " at " : " of ")
        << block.name << in_cell_of_largest(model, present_system->negative_residual(), part);
  std::vector<std::string> sentences = {words.str() + ". " + what_may_help()};
  if (const Undefined &why = present_system->why_undefined())
    sentences.push_back("a state was tried that is not defined: " + why.reason);
  return sentences;
}

template <int dim>
void NonlinearStep<dim>::explain_failure(const double t, const Vector &x)
{
  std::ostringstream words;
  words.precision(6); // the last good step may be next to it
  words << "the step to t = " << t << " did not converge: ";
  for (unsigned int i = 0; i < failure.size(); ++i)
    notes.add(of_failure((i == 0 ? words.str() : "") + failure[i]));

  if (!present_system->assemble(x, true))
    return;
  if (const auto motion = present_system->find_unrestrained_mode(BlockSystem<dim>::Unless::never))
    notes.add(of_failure("nothing holds " + motion->in_words()));
  for (const auto &pressure : present_system->find_free_pressures())
    notes.add(of_failure("nothing that is free can change the volume of " + pressure.in_words() +
                         ": what is prescribed around incompressible bodies must keep it"));
}

template class NonlinearStep<2>;
template class NonlinearStep<3>;

} // namespace dovetail
