// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/step_problem.h>

#include <dovetail/domain/cell_terms.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

namespace dovetail {

namespace {

const NoteName of_singular_matrix("singular matrix", "a linear system cannot be solved to its tolerance");

/// Of a linear scene, relative to the forces at work. The balance of forces is asked for to 1e-10 of what is
/// put in, which is less.
const double exact_linear_residual = 1e-11;
const double share_of_exact = 0.1; ///< that the solver is asked for
/// Of the first step, and of the smallest cell, for differences.
const double small_share = 1e-5;
/// Of Newton's method for the beginning of a motion.
const double smallest_damping = 1e-4;
const unsigned int most_passes = 50;

std::vector<bool> blocks_of_constraints(const Numbering &numbering)
{
  std::vector<bool> are;
  for (const Block &block : numbering.blocks())
    are.push_back(block.is_constraint);
  return are;
}

/// With zero in the other blocks.
template <typename Is>
Vector only(const Is &is, const Vector &all)
{
  Vector result = all;
  for (unsigned int b = 0; b < result.n_blocks(); ++b)
    if (!is(b))
      result.block(b) = 0;
  return result;
}

} // namespace

template <int dim>
StepProblem<dim>::StepProblem(const Model<dim> &model, BlockSystem<dim> &system, const Newton &newton,
                              LinearSolver &solver, Phases &phases, Log &log)
    : model(model), system(system), linear_solver(solver), phases(phases), log(log),
      criterion(system.fields_of_blocks(), blocks_of_constraints(*model.numbering),
                newton.residual_tolerance(), newton.absolute_tolerance()),
      stages(make_stages())
{
  enter_all_stages();
  for (const Block &block : model.numbering->blocks()) {
    content_updates.emplace_back();
    if (block.is_constraint || block.is_of_multipliers)
      continue;
    const Domain<dim> &domain = *model.domains[block.domain_index];
    const unsigned int component = domain.fields()[block.field_index].first_component;
    const auto lumped = lumped_components(domain, 1);
    if (std::find(lumped.begin(), lumped.end(), component) == lumped.end())
      continue;
    auto update = std::make_unique<ContentUpdate<dim>>(domain.material, component);
    if (update->is_needed())
      content_updates.back() = std::move(update);
  }
}

/// A group that is affine gets a stage of its own, since one update solves it there. Others iterate beside
/// those that drive them: one after the other they would take more assemblies. A linear scene has one stage,
/// because the linear solver takes the groups one after the other anyway.
template <int dim>
std::vector<typename StepProblem<dim>::Stage> StepProblem<dim>::make_stages() const
{
  const auto groups = model.field_groups();
  const auto depends = [this](const auto &fields, const auto &on_fields) {
    return std::any_of(fields.begin(), fields.end(), [&](const std::string &field) {
      return std::any_of(on_fields.begin(), on_fields.end(),
                         [&](const std::string &other) { return model.depends(field, other); });
    });
  };
  std::vector<Stage> result;
  std::vector<std::string> fields; // of the last stage
  for (unsigned int g = 0; g < groups.size(); ++g) {
    if (g == 0 || (depends(groups[g], fields) && model.is_linear(groups[g]) && !model.is_linear())) {
      result.push_back({g, g, {}, true});
      fields.clear();
    }
    fields.insert(fields.end(), groups[g].begin(), groups[g].end());
    Stage &stage = result.back();
    stage.end_group = g + 1;
    stage.is_linear = model.is_linear(fields);
    stage.has_block.clear();
    for (const Block &block : model.numbering->blocks())
      stage.has_block.push_back(std::find(fields.begin(), fields.end(), block.field) != fields.end());
  }
  return result;
}

template <int dim>
void StepProblem<dim>::enter_stage(const unsigned int number)
{
  present_stage = number;
  residual_of_update = 0;
  has_block = stages[number].has_block;
  criterion.restrict_to(has_block);
}

/// Between solves.
template <int dim>
void StepProblem<dim>::enter_all_stages()
{
  has_block.assign(model.numbering->blocks().size(), true);
  criterion.restrict_to(has_block);
}

/// After the last one everything is measured. If something is not solved, it depends on what no material
/// knows of, for instance by a condition: then all is one stage from now on.
template <int dim>
bool StepProblem<dim>::next_stage()
{
  if (present_stage + 1 < stages.size()) {
    enter_stage(present_stage + 1);
    return true;
  }
  enter_all_stages();
  if (stages.size() == 1 || measure(true) <= criterion.tolerance())
    return false;
  stages = {{0, stages.back().end_group, has_block, false}};
  enter_stage(0);
  return true;
}

/// Other updates are zero.
template <int dim>
void StepProblem<dim>::keep_stage(Vector &dx) const
{
  for (unsigned int b = 0; b < has_block.size(); ++b)
    if (!has_block[b])
      dx.block(b) = 0;
}

template <int dim>
bool StepProblem<dim>::moves_constraints() const
{
  for (unsigned int b = 0; b < has_block.size(); ++b)
    if (has_block[b] && system.moves_constraints(b))
      return true;
  return false;
}

template <int dim>
void StepProblem<dim>::begin_step(const double t_of_step, const Vector &x)
{
  t = t_of_step;
  guess.reset();
  is_at_start = false;
  tangent_at_rest.clear(); // ties and conditions may have changed
  may_adapt_penalties = starts_from_guess && !model.is_linear();
  start = Vector();
  if (may_adapt_penalties)
    start = x;
  is_first_assembly = true;
  criterion.begin_step();
  enter_all_stages();
  smallest_at_start.clear();
  largest_at_start.clear();
  for (unsigned int b = 0; b < x.n_blocks(); ++b) {
    smallest_at_start.push_back(x.block(b).min());
    largest_at_start.push_back(x.block(b).max());
  }
  scales.assign(x.n_blocks(), 0.);
}

template <int dim>
double StepProblem<dim>::residual(const Vector &x)
{
  const Phases::Scope scope(phases, "assembly");
  is_at_start = false;
  return measure(system.assemble(x, false));
}

template <int dim>
double StepProblem<dim>::start_at(const Vector &x)
{
  const double norm = residual_and_tangent(x);
  is_at_start = std::isfinite(norm);
  return norm;
}

template <int dim>
double StepProblem<dim>::residual_and_tangent(const Vector &x)
{
  const Phases::Scope scope(phases, "assembly");
  if (std::exchange(is_at_start, false)) // assembled already, but perhaps measured with other stages
    return measure(true);
  const bool with_tangent = !system.keeps_tangent();
  has_new_tangent = has_new_tangent || with_tangent;
  is_stabilised = is_stabilised && !with_tangent;
  return measure(system.assemble(x, with_tangent));
}

/// What has been assembled.
template <int dim>
double StepProblem<dim>::measure(const bool is_defined)
{
  if (is_first_assembly)
    loads_at_start = {{system.negative_residual().l2_norm(), system.largest_move()}};
  is_first_assembly = false;
  residual_of_last = is_defined ? criterion.residual({system.residuals(), system.forces(), system.rounding()})
                                : std::numeric_limits<double>::quiet_NaN();
  return residual_of_last;
}

/// A linear scene needs no iteration to know that a body is free; a nonlinear one may hold it once it has
/// moved.
template <int dim>
void StepProblem<dim>::check_is_held() const
{
  if (const auto motion = system.find_unrestrained_mode())
    motion->bodies[0]->section.fail("Boundary conditions",
                                    "and interfaces do not hold " + motion->in_words() +
                                        ". Add a condition of Type = value, or a tie, that does.");
}

template <int dim>
void StepProblem<dim>::give_tangent()
{
  if (has_new_tangent) {
    linear_solver.set_matrix(system.tangent());
    if (model.is_linear())
      check_is_held();
  }
  has_new_tangent = false;
}

/// How exact an update has to be, relative to its residual: such that what is left of the residual is a tenth
/// of what Newton's method will leave if it converges quadratically (Eisenstat and Walker 1996, choice 2). 0:
/// exact, because one iteration solves the stage or because the residual says nothing of the update: while
/// prescribed values move, and with a tangent that is not that of the state.
template <int dim>
double StepProblem<dim>::forcing() const
{
  const double largest = 1e-4, share = 0.1;
  if (stages[present_stage].is_linear || is_stabilised || !(residual_of_last > 0) || moves_constraints())
    return 0;
  if (!(residual_of_update > residual_of_last))
    return std::min(largest, share * residual_of_last);
  return std::min(largest, share * std::pow(residual_of_last / residual_of_update, 2));
}

/// The last iteration does not have to solve far below the tolerance; if the residual is remembered, it does.
template <int dim>
LinearSolver::Demand StepProblem<dim>::demand() const
{
  const double largest = 1e-2, rest = 1e-3; // of the tolerance
  const Stage &stage = stages[present_stage];
  const bool is_exact = model.is_linear() || is_remembered() || !(residual_of_last > 0);
  return {stage.first_group, stage.end_group,
          is_exact ? 0 : std::min(largest, rest * criterion.tolerance() / residual_of_last)};
}

/// Of an update: as demand(), unless what the update leaves is surely more than the tolerance.
template <int dim>
LinearSolver::Demand StepProblem<dim>::demand_of_update()
{
  LinearSolver::Demand result = demand();
  if (const double share = forcing(); share * residual_of_last > criterion.tolerance())
    result.enough = std::max(result.enough, share);
  residual_of_update = residual_of_last;
  return result;
}

template <int dim>
std::optional<unsigned int> StepProblem<dim>::solve(const Vector &x, Vector &dx)
{
  const Phases::Scope scope(phases, "solve");
  give_tangent();
  const LinearSolver::Demand needed = demand_of_update();
  auto n_iterations =
      guess ? solve_from_guess(dx) : linear_solver.solve(dx, system.negative_residual(), needed);
  guess.reset();
  while (!n_iterations && linear_solver.lacks_operator()) {
    make_other_tangent(x);
    n_iterations = linear_solver.solve(dx, system.negative_residual(), needed);
  }
  if (model.is_linear() && n_iterations)
    residual_of_solver = refine_linear_solution(x, dx);
  update_moves = moves_constraints();
  update_loads = system.negative_residual();
  moving_loads.reset();
  system.distribute(dx);
  keep_stage(dx);
  if (!model.is_linear())
    learn_scales(x, dx);
  return n_iterations;
}

/// Of a linear scene. The solver only has to find what the guess leaves, unless that is no less than what
/// there is without it.
template <int dim>
std::optional<unsigned int> StepProblem<dim>::solve_from_guess(Vector &dx)
{
  Vector start = system.owned_vector(), rest = start;
  const double without = system.linear_residual_norm(start, rest);
  for (unsigned int b = 0; b < start.n_blocks(); ++b) {
    const Block &block = model.numbering->blocks()[b];
    for (unsigned int i = 0; i < block.owned.n_elements(); ++i)
      if (!system.is_constrained(block.begin + block.owned.nth_index_in_set(i)))
        start.block(b).trilinos_vector()[0][i] = guess->block(b).trilinos_vector()[0][i];
  }
  const double with = system.linear_residual_norm(start, rest);
  LinearSolver::Demand needed = demand();
  if (!(with < without))
    return linear_solver.solve(dx, system.negative_residual(), needed);
  ++n_guesses;
  if (with > 0)
    needed.enough = share_of_exact * exact_linear_residual / with;
  const auto n_iterations = linear_solver.solve(dx, rest, needed);
  if (n_iterations)
    dx += start;
  return n_iterations;
}

/// For a matrix with entries, where products of cells did not do, or for products, where factors do not fit.
template <int dim>
void StepProblem<dim>::make_other_matrix()
{
  linear_solver.forget_matrix();
  tangent_at_rest.clear(); // it has none either
  system.choose_entries(linear_solver.needs_entries());
  system.make_matrix();
}

template <int dim>
void StepProblem<dim>::make_other_tangent(const Vector &x)
{
  make_other_matrix();
  residual_and_tangent(x);
  give_tangent();
}

/// The linear solver sees one norm for all bodies; a body that carries little beside one that carries much
/// may be left unsolved. The rest is solved for once more, then directly.
/// @return the relative residual of dx, the largest of all parts
template <int dim>
double StepProblem<dim>::refine_linear_solution(const Vector &x, Vector &dx)
{
  const double usual = 1e-8;
  Vector rest = system.owned_vector(), correction;
  double relative = system.linear_residual_norm(dx, rest);
  for (unsigned int pass = 0; pass < 2 && relative > (pass == 0 ? exact_linear_residual : usual); ++pass) {
    if (pass == 1 && linear_solver.prefer_direct() && linear_solver.lacks_operator())
      make_other_tangent(x);
    const Stage &stage = stages[present_stage];
    correction.reinit(rest);
    if (!linear_solver.solve(
            correction, rest,
            {stage.first_group, stage.end_group, share_of_exact * exact_linear_residual / relative}))
      break;
    Vector trial = dx;
    trial += correction;
    if (const double refined = system.linear_residual_norm(trial, rest); refined < relative) {
      dx = trial;
      relative = refined;
    }
  }
  if (relative > usual) {
    std::ostringstream words;
    words.precision(2);
    words << "the linear system is solved to " << relative
          << " of the forces at work only, by the direct solver too: its matrix is close to singular. Check "
             "what holds the bodies, and how far their stiffnesses and penalties differ";
    all_notes.push_back(of_singular_matrix(words.str()));
  }
  return relative;
}

/// @return whether it is defined at @p x: the tangent for second rates mass_alone x.
template <int dim>
bool StepProblem<dim>::assemble_mass(const Vector &x)
{
  Rates rates;
  rates.by_value = rates.second_by_value = mass_alone;
  rates.rest = rates.second_rest = x;
  rates.rest *= -mass_alone;
  rates.second_rest *= -mass_alone;
  rates.weights = {-mass_alone};
  rates.past = {x};
  system.set_rates(rates);
  if (!system.keeps_tangent() && !system.assemble(x, true))
    return false;
  linear_solver.set_matrix(system.tangent());
  has_new_tangent = false;
  return true;
}

/// Solved again for what the solver leaves.
template <int dim>
Vector StepProblem<dim>::solve_mass(const Vector &x, const Vector &right_hand_side)
{
  const double exact = 1e-14;
  Vector solution = system.owned_vector(), rest = right_hand_side, correction = rest;
  for (unsigned int pass = 0; pass < 3 && rest.l2_norm() > exact * right_hand_side.l2_norm(); ++pass) {
    bool is_solved = linear_solver.solve(correction, rest).has_value();
    for (bool is_assembled = true; is_assembled && !is_solved && linear_solver.lacks_operator();) {
      make_other_matrix();
      is_assembled = assemble_mass(x);
      is_solved = is_assembled && linear_solver.solve(correction, rest).has_value();
    }
    if (!is_solved)
      throw UserError(
          "accelerations at the beginning of a step cannot be found: the linear solver fails with "
          "the mass of the bodies.");
    solution += correction;
    system.tangent().vmult(rest, solution);
    rest.sadd(-1, 1, right_hand_side);
  }
  return solution;
}

/// Given ones.
template <int dim>
void StepProblem<dim>::set_rates_alone(const Vector &x, const Vector &rate, const Vector &second_rate)
{
  Rates rates;
  rates.rest = rate;
  rates.second_rest = second_rate;
  rates.weights = {0};
  rates.past = {x};
  system.set_rates(rates);
}

template <int dim>
bool StepProblem<dim>::is_of_pressure(const unsigned int b) const
{
  const Block &block = model.numbering->blocks()[b];
  return !block.is_of_multipliers &&
         model.domains[block.domain_index]->fields()[block.field_index].is_multiplier;
}

template <int dim>
bool StepProblem<dim>::has_pressures() const
{
  for (unsigned int b = 0; b < model.numbering->blocks().size(); ++b)
    if (is_of_pressure(b))
      return true;
  return false;
}

/// Whose equation knows displacements alone by the tangent at hand, since the body is incompressible where
/// the pressure acts: it says nothing of the pressure, but limits how the body moves. By block.
template <int dim>
typename StepProblem<dim>::Rows StepProblem<dim>::incompressible_rows() const
{
  Rows rows(model.numbering->blocks().size());
  for (unsigned int b = 0; b < rows.size(); ++b)
    if (is_of_pressure(b)) {
      const std::vector<double> diagonal = system.tangent().diagonal(b);
      for (unsigned int i = 0; i < diagonal.size(); ++i)
        if (diagonal[i] == 0)
          rows[b].push_back(i);
    }
  return rows;
}

template <int dim>
bool StepProblem<dim>::is_any(const Rows &rows) const
{
  const bool is_here = std::any_of(rows.begin(), rows.end(), [](const auto &list) { return !list.empty(); });
  return dealii::Utilities::MPI::max(is_here ? 1 : 0, model.communicator) == 1;
}

namespace {

void copy_rows(const std::vector<std::vector<unsigned int>> &rows, const Vector &from, Vector &to)
{
  for (unsigned int b = 0; b < rows.size(); ++b)
    for (const unsigned int i : rows[b])
      to.block(b).trilinos_vector()[0][i] = from.block(b).trilinos_vector()[0][i];
}

} // namespace

/// With the matrix c M + K, where c is as large as can be, an update is a/c of what has a mass; the forces of
/// multipliers and pressures, and other fields, are found with it. Where a body is incompressible, this
/// update must not close what its volume is off by now, which is rounding. Accelerations, constant until the
/// end of the step, have to keep the volume until then: B a = -2/h^2 of what @p without is off by there.
template <int dim>
std::optional<Vector> StepProblem<dim>::second_rates(const double now, const Vector &x, const Vector &rate,
                                                     const Vector &of_constrained, const double h,
                                                     Vector &forces)
{
  const Phases::Scope scope(phases, "solve");
  if (!assemble_mass(x))
    return {};
  const double end = t;
  Vector at_end = x;
  bool is_defined = true;
  const Rows of_volume = incompressible_rows();
  if (is_any(of_volume)) {
    Vector without = x;
    without.add(h, rate);
    without.add(h * h / 2, of_constrained);
    set_rates_alone(x, rate, of_constrained);
    is_defined = system.assemble(without, false);
    at_end = system.negative_residual();
    at_end *= 2 / (h * h) / mass_alone;
  }
  if (!system.is_outdated(now))
    system.set_time(now);
  set_rates_alone(x, rate, of_constrained);
  is_defined = system.assemble(x, false) && is_defined;
  Vector rest = system.negative_residual();
  system.set_time(end);
  if (!is_defined)
    return {};
  for (unsigned int b = 0; b < rest.n_blocks(); ++b)
    if (is_of_multipliers(b)) // else what bodies are apart at x would be closed at once
      rest.block(b) = 0;
  copy_rows(of_volume, at_end, rest);
  Vector result = solve_mass(x, rest);
  forces = x;
  forces += result;
  result *= mass_alone;
  system.distribute_rate(result, true);
  result += of_constrained;
  for (unsigned int b = 0; b < result.n_blocks(); ++b)
    if (model.numbering->blocks()[b].is_constraint)
      result.block(b) = 0;
  return result;
}

template <int dim>
void StepProblem<dim>::keep_volume(const double now, const Vector &x, Vector &rate)
{
  if (!assemble_mass(x))
    return;
  const Rows of_volume = incompressible_rows();
  if (!is_any(of_volume))
    return;
  const double end = t;
  Vector none = rate;
  none = 0;
  Vector limited = none;
  find_rates_of_volume(now, x, rate, of_volume, limited);
  rate += projection(x, none, limited);
  system.set_time(end);
}

template <int dim>
void StepProblem<dim>::satisfy_ties(Vector &x, Vector &rate)
{
  const double end = t, begin = 0;
  if (!system.is_outdated(begin))
    system.set_time(begin);
  project_start(x, rate);
  system.set_time(end);
}

template <int dim>
bool StepProblem<dim>::has_inertia(const unsigned int b) const
{
  const Block &block = model.numbering->blocks()[b];
  if (block.is_constraint || block.is_of_multipliers)
    return false;
  const Domain<dim> &domain = *model.domains[block.domain_index];
  return domain.material.order_in_time(domain.fields()[block.field_index].first_component) > 1;
}

/// Of constrained unknowns, just after the beginning, where what is prescribed may jump; others stay, as does
/// what is prescribed where constraints change by then.
template <int dim>
void StepProblem<dim>::follow_rates(Vector &rate)
{
  const double later = small_share * t; // t is the end of the first step
  const bool is_known = !system.is_outdated(0) && !system.is_outdated(3 * later);
  system.distribute_rate(rate, is_known);
  if (!is_known)
    return;
  std::vector<Vector> given(3, system.owned_vector()); // what follows if all that is free is zero
  for (unsigned int k = 0; k < 3; ++k) {
    system.set_time((k + 1) * later);
    system.constrain(given[k]);
  }
  system.set_time(0);
  given[1] -= given[0];
  given[2] -= given[0];
  rate.add(4 / later, given[1], -1.5 / later, given[2]);
}

template <int dim>
void StepProblem<dim>::project_start(Vector &x, Vector &rate)
{
  const auto moves = [this](const unsigned int b) { return has_inertia(b); };
  Vector x_change = x, rate_change = rate;
  system.follow(x_change);
  x_change -= x;
  x_change = only(moves, x_change);
  follow_rates(rate_change);
  rate_change -= rate;
  rate_change = only(moves, rate_change);
  const bool is_changed = system.has_multipliers() || x_change.l2_norm() != 0 || rate_change.l2_norm() != 0;
  if (!is_changed && !has_pressures())
    return;
  x += x_change;
  rate += rate_change;
  assemble_mass_of_start(x);
  const Rows of_volume = incompressible_rows();
  const bool keeps_volume = is_any(of_volume);
  if (is_changed || keeps_volume)
    project_positions(of_volume, x_change, x);
  if (has_pressures())
    find_pressures(of_volume, x);
  if (!is_changed && !keeps_volume)
    return;
  Vector jumps = rate;
  system.tangent().vmult(jumps, rate);
  jumps *= -1;
  if (keeps_volume)
    find_rates_of_volume(0, x, rate, of_volume, jumps);
  rate += projection(x, rate_change, limits(of_volume, jumps));
}

/// With a message in place of a first step that fails whatever its size.
template <int dim>
void StepProblem<dim>::assemble_mass_of_start(const Vector &x)
{
  if (assemble_mass(x))
    return;
  Undefined why = system.why_undefined();
  why.reason = "the initial state is not defined: " + why.reason;
  refuse_undefined(why, model.communicator);
}

/// The rows of what limits motions.
template <int dim>
Vector StepProblem<dim>::limits(const Rows &of_volume, const Vector &residual) const
{
  Vector result = only([this](const unsigned int b) { return is_of_multipliers(b); }, residual);
  copy_rows(of_volume, residual, result);
  return result;
}

/// What moves with @p change of constrained unknowns, by the mass of the last assembly at @p x, such that
/// the motion is @p limited.
template <int dim>
Vector StepProblem<dim>::projection(const Vector &x, const Vector &change, const Vector &limited)
{
  const auto moves = [this](const unsigned int b) { return has_inertia(b); };
  Vector none = x, of_mass = change;
  none = 0;
  of_mass *= mass_alone;
  set_rates_alone(x, none, of_mass);
  system.assemble(x, false);
  Vector update = solve_mass(x, only(moves, system.negative_residual()));
  update += solve_mass(x, limited);
  system.distribute_rate(update, true);
  return only(moves, update);
}

/// The residual at rest, of all. @return whether it is defined.
template <int dim>
bool StepProblem<dim>::assemble_at_rest(const Vector &x)
{
  Vector none = x;
  none = 0;
  set_rates_alone(x, none, none);
  return system.assemble(x, false);
}

/// Newton's method, damped such that what is to be closed shrinks. The mass is that of @p x.
template <int dim>
void StepProblem<dim>::project_positions(const Rows &of_volume, const Vector &x_change, Vector &x)
{
  const double rounding = 1e-13, small = 1e-8; // of updates, relative to the bodies
  double size = 0;
  for (const auto &domain : model.domains)
    size = std::max(size, domain->typical_length());
  const auto error = [&](const Vector &state) {
    return assemble_at_rest(state) ? limits(of_volume, system.negative_residual()).l2_norm()
                                   : std::numeric_limits<double>::infinity();
  };
  Vector none = x, trial = x;
  none = 0;
  x += projection(x, x_change, none); // closes nothing, so that it is not damped
  double now = error(x), damping = 1;
  Vector update = projection(x, none, limits(of_volume, system.negative_residual()));
  const bool is_nonlinear = is_any(of_volume) && has_large_strain();
  for (unsigned int pass = 0; pass < most_passes && damping >= smallest_damping; ++pass) {
    double next = 0;
    const bool is_last = !is_nonlinear || update.linfty_norm() <= rounding * size;
    for (damping = 1; !is_last && damping >= smallest_damping; damping /= 2) {
      trial = x;
      trial.add(damping, update);
      next = error(trial);
      if (next < now)
        break;
    }
    if (damping >= smallest_damping)
      x.add(damping, update);
    else if (update.linfty_norm() <= small * size)
      return;
    if (is_last)
      return;
    now = next;
    assemble_mass(x);
    assemble_at_rest(x);
    const Vector limited = limits(of_volume, system.negative_residual());
    update = projection(x, none, limited);
  }
  refuse_positions(limits(of_volume, system.negative_residual()));
}

template <int dim>
void StepProblem<dim>::refuse_positions(const Vector &limited) const
{
  unsigned int worst = 0;
  for (unsigned int b = 0; b < limited.n_blocks(); ++b)
    if (is_of_pressure(b) &&
        (!is_of_pressure(worst) || limited.block(b).l2_norm() > limited.block(worst).l2_norm()))
      worst = b;
  const Section &domain = model.domains[model.numbering->blocks()[worst].domain_index]->section;
  domain.fail("Initial",
              "changes the volume of this incompressible body, and no displacement that keeps the volume is "
              "found near it. Give one with det F = 1, or let loads bring the body there from rest.");
}

/// Of bodies that are compressible: those which belong to the displacement. Newton's method, damped such that
/// the volumetric functions have them.
template <int dim>
void StepProblem<dim>::find_pressures(const Rows &of_volume, Vector &x)
{
  const auto are_pressures = [this](const unsigned int b) { return is_of_pressure(b); };
  const double rounding = 1e-12;
  Vector none = x;
  none = 0;
  for (unsigned int pass = 0; pass < most_passes && assemble_at_rest(x); ++pass) {
    Vector rest = only(are_pressures, system.negative_residual());
    copy_rows(of_volume, none, rest);
    const Vector update = only(are_pressures, solve_mass(x, rest));
    x += update;
    for (double damping = 0.5; damping >= smallest_damping && !assemble_at_rest(x); damping /= 2)
      x.add(-damping, update);
    if (!(update.linfty_norm() > rounding * x.linfty_norm()) || !assemble_mass(x))
      return;
  }
}

/// Of incompressible bodies, with what is prescribed and moves (the tangent knows of free unknowns alone),
/// and with what makes them swell in time. Differences: central along the motion, from the beginning on in
/// time.
template <int dim>
void StepProblem<dim>::find_rates_of_volume(const double begin, const Vector &x, const Vector &rate,
                                            const Rows &rows, Vector &negative_rates)
{
  const double speed = rate.linfty_norm();
  Vector none = rate, moved = x, change = x;
  none = 0;
  change = 0;
  set_rates_alone(x, none, none);
  const auto add = [&](const double factor) {
    system.assemble(moved, false);
    change.add(factor, system.negative_residual());
  };
  if (speed > 0) {
    double size = std::numeric_limits<double>::infinity();
    for (const auto &domain : model.domains)
      for (const auto &cell : domain->mesh().active_cell_iterators())
        if (cell->is_locally_owned())
          size = std::min(size, cell->minimum_vertex_distance());
    const double later = small_share * dealii::Utilities::MPI::min(size, model.communicator) / speed;
    for (const double sign : {1., -1.}) {
      moved = x;
      moved.add(sign * later, rate);
      add(sign / (2 * later));
    }
  }
  moved = x;
  const double later = small_share * (t - begin);
  const std::array<double, 3> factors = {{-1.5, 2, -0.5}};
  for (unsigned int k = 0; k < 3 && !system.is_outdated(begin) && !system.is_outdated(begin + 2 * later);
       ++k) {
    system.set_time(begin + k * later);
    add(factors[k] / later);
  }
  copy_rows(rows, change, negative_rates);
}

/// Updates of different fields are compared in the ranges of their values, which a step does not shrink.
template <int dim>
void StepProblem<dim>::learn_scales(const Vector &x, const Vector &dx)
{
  const unsigned int n_blocks = scales.size();
  const auto &field = system.fields_of_blocks();
  std::vector<double> smallest(n_blocks, std::numeric_limits<double>::infinity()),
      largest(n_blocks, -std::numeric_limits<double>::infinity()); // by field
  Vector state = x;
  bool is_without_scale = true;
  for (unsigned int b = 0; b < n_blocks; ++b)
    is_without_scale = is_without_scale && (!has_block[b] || scales[b] == 0);
  if (is_without_scale)
    state += dx; // where prescribed values have not moved yet, all may be zero
  for (unsigned int b = 0; b < n_blocks; ++b) {
    const unsigned int f = field[b];
    smallest[f] = std::min({smallest[f], smallest_at_start[b], state.block(b).min()});
    largest[f] = std::max({largest[f], largest_at_start[b], state.block(b).max()});
  }
  for (unsigned int b = 0; b < n_blocks; ++b) {
    const unsigned int f = field[b];
    const double range =
        std::max(largest[f] - smallest[f],
                 Convergence::smallest_range * std::max(std::abs(largest[f]), std::abs(smallest[f])));
    scales[b] = std::max(scales[b], range);
  }
}

/// Multipliers follow the bodies: they do not count.
template <int dim>
double StepProblem<dim>::norm(const Vector &dx) const
{
  double square = 0;
  for (unsigned int b = 0; b < scales.size(); ++b)
    if (scales[b] > 0 && !model.numbering->blocks()[b].is_constraint)
      square += std::pow(dx.block(b).l2_norm() / scales[b], 2);
  return std::sqrt(square);
}

/// What the moving prescribed values do to the right-hand side, if they move from @p x by as much as in dx.
/// Leaves R(x) assembled.
template <int dim>
Vector StepProblem<dim>::find_moving_loads(const Vector &x)
{
  system.assemble(x, false);
  Vector loads = update_loads;
  loads -= system.negative_residual();
  return loads;
}

template <int dim>
bool StepProblem<dim>::correct(const Vector &x, const Vector &trial, const double damping, Vector &correction)
{
  const bool has_to_move = update_moves && damping < 1;
  if (has_to_move && !moving_loads) {
    const Phases::Scope scope(phases, "assembly");
    moving_loads = find_moving_loads(x);
    system.assemble(trial, false);
  }
  const Phases::Scope scope(phases, "solve");
  give_tangent();
  Vector loads = system.negative_residual();
  if (has_to_move)
    loads.add(1 - damping, *moving_loads);
  bool is_solved = linear_solver.solve(correction, loads, demand()).has_value();
  while (!is_solved && linear_solver.lacks_operator()) {
    make_other_tangent(x);
    is_solved = linear_solver.solve(correction, loads, demand()).has_value();
    system.assemble(trial, false);
  }
  if (!is_solved)
    return false;
  system.distribute(correction);
  keep_stage(correction);
  return true;
}

/// What nodes store nonlinearly is moved by way of the content (content_update.h), and what follows these
/// nodes with them.
template <int dim>
void StepProblem<dim>::move(const Vector &x, const double damping, const Vector &dx, Vector &trial)
{
  NonlinearProblem::move(x, damping, dx, trial);
  std::optional<Vector> further;
  for (unsigned int b = 0; b < has_block.size() && system.has_rates(); ++b) {
    if (!has_block[b] || !content_updates[b])
      continue;
    if (!further)
      further = system.owned_vector();
    const Block &block = model.numbering->blocks()[b];
    const double *from = x.block(b).trilinos_vector()[0], *update = dx.block(b).trilinos_vector()[0];
    double *change = further->block(b).trilinos_vector()[0];
    for (unsigned int i = 0; i < block.owned.n_elements(); ++i)
      if (!system.is_constrained(block.begin + block.owned.nth_index_in_set(i)))
        change[i] = content_updates[b]->after(from[i], damping * update[i]) - (from[i] + damping * update[i]);
  }
  if (!further)
    return;
  Vector prescribed = system.owned_vector(); // what moves without any of them is in dx
  system.distribute(prescribed);
  system.distribute(*further);
  *further -= prescribed;
  trial += *further;
}

/// Of unknowns that are free; the others follow them or are prescribed.
template <int dim>
bool StepProblem<dim>::is_small(const Vector &dx, const Vector &x) const
{
  if (has_linear_stage())
    return true;
  const unsigned int n_blocks = dx.n_blocks();
  std::vector<double> largest(n_blocks, 0.), energies(n_blocks, 0.);
  WorkingUpdate sizes;
  for (unsigned int b = 0; b < n_blocks; ++b) {
    const Block &block = model.numbering->blocks()[b];
    const double *update_entries = dx.block(b).trilinos_vector()[0],
                 *update_load = update_loads.block(b).trilinos_vector()[0];
    for (unsigned int i = 0; i < block.owned.n_elements(); ++i)
      if (!system.is_constrained(block.begin + block.owned.nth_index_in_set(i))) {
        largest[b] = std::max(largest[b], std::abs(update_entries[i]));
        energies[b] += update_entries[i] * update_load[i];
      }
    sizes.smallest_value.push_back(std::min(smallest_at_start[b], x.block(b).min()));
    sizes.largest_value.push_back(std::max(largest_at_start[b], x.block(b).max()));
    sizes.n_unknowns.push_back(dx.block(b).size());
  }
  dealii::Utilities::MPI::max(largest, model.communicator, largest);
  dealii::Utilities::MPI::sum(energies, model.communicator, energies);
  for (double &energy : energies)
    energy = std::abs(energy);
  sizes.largest = largest;
  sizes.energies = energies;
  return criterion.is_small(sizes);
}

/// After an update. The first step of a run starts from a guess. Penalties that were frozen there may be
/// decades off where Newton's method ends, and next to far too large ones rounding drowns all fluxes: they
/// are frozen anew after its first full update. Only for scalars, of which a conductivity asks; a
/// displacement starts from rest, and one update of a slender body tells nothing.
template <int dim>
bool StepProblem<dim>::adapt(const Vector &x)
{
  bool has_changed = false;
  if (may_adapt_penalties) {
    may_adapt_penalties = false;
    Vector state = start;
    for (unsigned int b = 0; b < state.n_blocks(); ++b)
      if (is_scalar(b))
        state.block(b) = x.block(b);
    has_changed = system.update_penalties(t, state);
  }
  return system.adapt_ties(t, x) || has_changed;
}

/// Of some solid: only then limit points are looked for.
template <int dim>
bool StepProblem<dim>::has_large_strain() const
{
  return std::any_of(model.domains.begin(), model.domains.end(),
                     [](const auto &domain) { return domain->material.has_large_strain(); });
}

/// @return false if the laws are not defined at rest.
template <int dim>
bool StepProblem<dim>::stabilise(const Vector &x, const double share)
{
  if (tangent_at_rest.n_block_rows() == 0) {
    Vector rest = x;
    for (unsigned int b = 0; b < rest.n_blocks(); ++b)
      if (!is_scalar(b))
        rest.block(b) = 0;
    const bool is_defined = std::isfinite(residual_and_tangent(rest));
    if (is_defined)
      tangent_at_rest.copy_from(system.tangent());
    residual_and_tangent(x);
    if (!is_defined)
      return false;
  }
  system.add_to_tangent(share, tangent_at_rest);
  is_stabilised = true;
  return true;
}

/// Of a domain, not of multipliers.
template <int dim>
bool StepProblem<dim>::is_scalar(const unsigned int b) const
{
  const Block &block = model.numbering->blocks()[b];
  return !block.is_of_multipliers &&
         model.domains[block.domain_index]->fields()[block.field_index].n_components == 1;
}

template <int dim>
bool StepProblem<dim>::spread_prescribed_values(Vector &x)
{
  if (!std::isfinite(residual_and_tangent(x)))
    return false;
  linear_solver.set_matrix(system.tangent());
  has_new_tangent = false;
  update_loads = system.negative_residual();
  Vector dx = x;
  if (!linear_solver.solve(dx, find_moving_loads(x)))
    return false;
  system.distribute(dx);
  for (unsigned int b = 0; b < x.n_blocks(); ++b)
    if (is_scalar(b))
      x.block(b) += dx.block(b);
  return true;
}

template <int dim>
void StepProblem<dim>::iteration_ends(const unsigned int number, const double residual,
                                      const unsigned int linear_iterations, const double damping)
{
  log.newton_iteration(number, residual, linear_iterations, damping);
}

template class StepProblem<2>;
template class StepProblem<3>;

} // namespace dovetail
