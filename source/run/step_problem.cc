// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/step_problem.h>

#include <dovetail/domain/cell_terms.h>
#include <dovetail/solve/iterative_refinement.h>
#include <dovetail/system/mean_gradient.h>

#include <deal.II/base/mpi.h>

#include <boost/scope_exit.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <sstream>
#include <utility>

namespace dovetail {

namespace {

const NoteName of_singular_matrix("singular matrix", "a linear system cannot be solved to its tolerance");
const NoteName of_free_pressure("free pressure",
                                "a pressure is known but for a constant, because nothing lets the volume of "
                                "its incompressible body change");

/// Of a linear scene, relative to the forces at work. The balance of forces is asked for to 1e-10 of what is
/// put in, which is less.
const double exact_linear_residual = 1e-11;
const double usual_linear_residual = 1e-8; ///< more is told
const std::string of_unbalanced = "the iteration leaves equations of some body unbalanced";
const double share_of_exact = 0.1; ///< that the solver is asked for
/// Relative to the forces at work. A first update that leaves more has bent a slender body: the strains of
/// second order in its rotation are membrane strains, which have far more force than those of bending.
const double raised_residual = 3;
const double far_residual = 100;      ///< likewise: it may lead much too far
const double largest_gradient = 0.35; ///< of a share of such an update: a turn by 1/4, about

std::vector<bool> blocks_of_constraints(const Numbering &numbering)
{
  std::vector<bool> are;
  for (const Block &block : numbering.blocks())
    are.push_back(block.is_constraint);
  return are;
}

} // namespace

template <int dim>
StepProblem<dim>::StepProblem(const Model<dim> &model, BlockSystem<dim> &system, const Newton &newton,
                              LinearSolver &solver, Phases &phases, Log &log)
    : model(model), system(system), linear_solver(solver), phases(phases), log(log),
      criterion(system.fields_of_blocks(), blocks_of_constraints(*model.numbering),
                newton.residual_tolerance(), newton.absolute_tolerance()),
      stages(make_stages()), sizes(model.numbering->blocks(), system.fields_of_blocks()),
      may_predict_stress(!model.is_linear() &&
                         std::any_of(model.domains.begin(), model.domains.end(),
                                     [](const auto &domain) { return domain->material.has_large_strain(); })),
      residuals_of_solution(model.numbering->blocks().size(), 0.)
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

template <int dim>
std::vector<typename StepProblem<dim>::Stage> StepProblem<dim>::make_stages() const
{
  const auto groups = model.field_groups();
  const std::vector<unsigned int> number = model.stages();
  std::vector<Stage> result;
  std::vector<std::string> fields; // of the last stage
  for (unsigned int g = 0; g < groups.size(); ++g) {
    if (g == 0 || number[g] != number[g - 1]) {
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
  if (stages.size() > 1)
    rounding_of_tangent.reset();
  forget_updates();
  present_stage = number;
  residual_of_update = 0;
  tangent_at_rest.clear(); // it has the rows of one stage
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
bool StepProblem<dim>::next_stage(const Vector &x)
{
  if (present_stage + 1 < stages.size()) {
    enter_stage(present_stage + 1);
    return true;
  }
  enter_all_stages();
  if (stages.size() == 1 || (has_all_residuals ? measure(true) : residual(x)) <= criterion.tolerance())
    return false;
  stages = {{0, stages.back().end_group, has_block, false}};
  enter_stage(0);
  if (system.leaves_out_couplings()) {
    system.leave_out_couplings(false);
    make_other_matrix();
  }
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
bool StepProblem<dim>::has_hidden_load() const
{
  const double growth = 2; // of what rounding has left
  if (!criterion.is_hidden())
    return false;
  for (unsigned int b = 0; b < last_residuals.size(); ++b)
    if (last_residuals[b] > growth * residuals_of_solution[b])
      return true;
  return false;
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
  if (std::exchange(has_solved, false) && residual_of_last <= criterion.tolerance())
    residuals_of_solution = last_residuals;
  criterion.begin_step();
  forget_updates();
  present_stage = 0; // whose tangent is assembled
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
  const std::vector<bool> asked = blocks_of_residual(false);
  has_all_residuals = asked.empty();
  return measure(system.assemble(x, false, {}, asked));
}

/// Those of the present stage; where a step begins, and where its last stage ends, all are measured (empty).
template <int dim>
std::vector<bool> StepProblem<dim>::blocks_of_residual(const bool with_tangent) const
{
  const bool may_be_last = !with_tangent && present_stage + 1 == stages.size();
  const bool is_within_stage = std::find(has_block.begin(), has_block.end(), false) != has_block.end();
  return is_first_assembly || may_be_last || !is_within_stage ? std::vector<bool>() : has_block;
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
  const std::vector<bool> asked = blocks_of_residual(with_tangent);
  has_all_residuals = asked.empty();
  const auto assemble = [&](const Vector &before) { // empty: the stress is that of the state
    BOOST_SCOPE_EXIT_ALL(this)
    {
      system.linearise_at(nullptr);
    };
    if (before.size() > 0)
      system.linearise_at(&before);
    if (with_tangent)
      predicted_from = Vector(before);
    return measure(system.assemble(x, with_tangent, stages[present_stage].has_block, asked));
  };
  if (!with_tangent || linearised_at.size() == 0)
    return assemble({});
  const double share = share_of_update(x);
  if (share == 0) { // the update is not taken as a whole: if it is the first one, it was no bending
    predicts_stress = predicts_stress && n_updates > 1;
    return assemble(came_from);
  }
  if (predicts_stress)
    return assemble(linearised_at);
  const double norm = assemble({});
  if (n_updates != 1 || !(share > 0.99 && has_residual_above(raised_residual)))
    return norm;
  log.detail("  the first update bends slender bodies: tangents have the stress that updates predict");
  predicts_stress = true;
  return assemble(linearised_at);
}

/// Of a solid, at the state of the last assembly. A state that is not defined has none.
template <int dim>
bool StepProblem<dim>::has_residual_above(const double size) const
{
  const unsigned int worst = criterion.worst_part();
  return residual_of_last > size && (is_vector(worst) || model.numbering->blocks()[worst].is_constraint);
}

template <int dim>
bool StepProblem<dim>::is_unstable() const
{
  const auto groups = model.field_groups();
  const auto &blocks = model.numbering->blocks();
  bool is_unstable = false;
  for (unsigned int g = 0; g < groups.size() && has_solved; ++g)
    for (unsigned int b = 0; b < blocks.size() && linear_solver.has_met_negative(g); ++b)
      is_unstable = is_unstable || (is_vector(b) && std::find(groups[g].begin(), groups[g].end(),
                                                              blocks[b].field) != groups[g].end());
  return is_unstable;
}

template <int dim>
bool StepProblem<dim>::may_overshoot() const
{
  return linearised_at.size() > 0 && predicts_stress && has_residual_above(far_residual);
}

/// As far as bodies turn by about 1/4 in the mean: a linear turn by an angle strains them by half of its
/// square.
template <int dim>
double StepProblem<dim>::sensible_share(const Vector &dx)
{
  const double gradient = largest_mean_gradient(model, system.ghosted(dx));
  return gradient > largest_gradient ? largest_gradient / gradient : 1;
}

/// Of the last update, the share that leads to @p x.
template <int dim>
double StepProblem<dim>::share_of_update(const Vector &x) const
{
  Vector way = x;
  way -= linearised_at;
  return size_of_update > 0 ? way.l2_norm() / size_of_update : 0;
}

/// The next tangent is no longer one that an update leads to. (A copy of an empty vector is moved: deal.II
/// does not assign one with fewer blocks.)
template <int dim>
void StepProblem<dim>::forget_updates()
{
  n_updates = 0;
  linearised_at = Vector();
  came_from = Vector();
  predicted_from = Vector();
}

/// What has been assembled.
template <int dim>
double StepProblem<dim>::measure(const bool is_defined)
{
  if (is_first_assembly)
    loads_at_start = {{system.negative_residual().l2_norm(), system.largest_move()}};
  is_first_assembly = false;
  last_residuals = system.residuals();
  residual_of_last = is_defined ? criterion.residual({last_residuals, system.forces(), system.rounding()})
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
    give_matrix();
    if (model.is_linear())
      check_is_held();
  }
}

template <int dim>
void StepProblem<dim>::give_matrix()
{
  std::vector<FreePressure<dim>> found = system.find_free_pressures();
  found.erase(std::remove_if(found.begin(), found.end(),
                             [this](const auto &pressure) { return !has_block[pressure.block]; }),
              found.end()); // the tangent of other stages is not that of this state
  if (found.empty() && !free_pressures.empty() && has_block[free_pressures[0].block])
    all_notes.push_back(of_free_pressure(
        "the constant in the pressure of " + free_pressures[0].in_words() +
        " is no longer set to zero: if nothing else can move now, it follows from the errors of ties and "
        "quadrature alone, and says nothing"));
  free_pressures = std::move(found);
  if (!free_pressures.empty() || tangent_of_held.n_block_rows() > 0)
    linear_solver.forget_matrix(); // it gets another one than before
  tangent_of_held.clear();
  if (!free_pressures.empty()) {
    tangent_of_held.copy_from(system.tangent());
    hold(free_pressures, tangent_of_held);
  }
  rounding_of_tangent.reset();
  linear_solver.set_matrix(free_pressures.empty() ? system.tangent() : tangent_of_held);
  has_new_tangent = false;
  for (const auto &pressure : free_pressures)
    all_notes.push_back(of_free_pressure(
        "the pressure of " + pressure.in_words() +
        " is known but for a constant, since these bodies are incompressible and no part of their boundary "
        "can move such that the volume changes. Its mean is set to zero"));
}

/// A constant that no equation sees is what rounding makes of it.
template <int dim>
void StepProblem<dim>::centre_pressures(const Vector &x, Vector &dx) const
{
  for (const auto &pressure : free_pressures)
    dx.add(-(pressure.mean(x) + pressure.mean(dx)), pressure.mode);
}

/// Whether what the last update has to move keeps the volumes of bodies whose pressure has a free constant:
/// with K z = 0, K dx = b needs z.b = 0. Else the laws leave some of b whatever dx is, and a small correction
/// means nothing.
template <int dim>
bool StepProblem<dim>::are_volumes_kept() const
{
  return std::all_of(free_pressures.begin(), free_pressures.end(), [this](const auto &pressure) {
    Vector parts = pressure.mode;
    parts.scale(update_loads);
    double size = 0;
    for (unsigned int b = 0; b < parts.n_blocks(); ++b)
      size += parts.block(b).l1_norm();
    return std::abs(pressure.mode * update_loads) <= usual_linear_residual * size;
  });
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
  const double forces = std::max(1., residual_of_last), // membranes may have far more than what is at work
      gain = residual_of_update > residual_of_last ? residual_of_last / residual_of_update : 0;
  return std::min(largest, share * (gain > 0 ? gain * gain : residual_of_last)) / forces;
}

/// The last iteration does not have to solve far below the tolerance; if the residual is remembered, it does.
template <int dim>
LinearSolver::Demand StepProblem<dim>::demand() const
{
  const double largest = 1e-2, rest = 1e-3; // of the tolerance
  const Stage &stage = stages[present_stage];
  const bool is_exact = model.is_linear() || is_remembered() || !(residual_of_last > 0);
  LinearSolver::Demand result{stage.first_group, stage.end_group};
  result.enough = is_exact ? 0 : std::min(largest, rest * criterion.tolerance() / residual_of_last);
  result.ends_at_rounding = model.is_linear();
  return result;
}

/// Of what another residual measures.
template <int dim>
LinearSolver::Demand StepProblem<dim>::rough_demand(const double share) const
{
  LinearSolver::Demand result = demand();
  result.enough = std::max(result.enough, share);
  result.ends_at_rounding = false;
  return result;
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

/// Whether rounding of K may change the energy of an update by more than is allowed. Where strains of stiff
/// bodies have most of that energy (by heat, or where prescribed displacements have moved and dx brings the
/// rest after them), it says nothing of motions that cost little. Therefore y is looked at, too, which K y =
/// f gives very roughly, with f as dx and random in equal parts: it is as smooth as such a motion, and serves
/// as long as K does.
template <int dim>
bool StepProblem<dim>::is_rounded(const Vector &x, const Vector &dx)
{
  const double largest = BlockSystem<dim>::largest_rounding_of_energy, rough = 0.99;
  if (sizes.rounding_of_energy(system.tangent(), dx) > largest)
    return true;
  if (rounding_of_tangent)
    return *rounding_of_tangent > largest;
  Vector force = dx, y = dx;
  force = 0;
  std::minstd_rand numbers; // the same in each run
  std::uniform_real_distribution<double> random(-1, 1);
  for (unsigned int b = 0; b < has_block.size(); ++b) {
    if (!has_block[b] || !is_vector(b))
      continue;
    force.block(b) = dx.block(b);
    const Block &block = model.numbering->blocks()[b];
    const double size = dx.block(b).l2_norm() / std::sqrt(double(dx.block(b).size()));
    for (unsigned int i = 0; i < block.owned.n_elements(); ++i)
      if (!system.is_constrained(block.begin + block.owned.nth_index_in_set(i)))
        force.block(b).trilinos_vector()[0][i] += size * random(numbers);
  }
  if (force.linfty_norm() == 0)
    return false;
  const bool is_solved = solve_with_any_matrix(x, y, force, rough_demand(rough)).has_value();
  keep_stage(y);
  rounding_of_tangent =
      is_solved ? sizes.rounding_of_energy(system.tangent(), y) : std::numeric_limits<double>::infinity();
  return *rounding_of_tangent > largest;
}

template <int dim>
std::optional<unsigned int> StepProblem<dim>::solve(const Vector &x, Vector &dx)
{
  const Phases::Scope scope(phases, "solve");
  const bool is_in_time = model.is_linear() && is_remembered(),
             may_be_refined =
                 has_linear_stage() && (!is_in_time || has_new_tangent || !system.takes_products());
  give_tangent();
  ++n_updates;
  has_solved = true;
  linearised_at = may_predict_stress && !is_stabilised ? x : Vector();
  came_from = Vector(predicted_from);
  LinearSolver::Demand needed = demand_of_update();
  if (model.is_linear() || has_linear_stage())
    needed.excess = [this](const Vector &update, const auto &blocks) { return excess(update, blocks); };
  auto n_iterations =
      guess ? solve_from_guess(x, dx) : solve_with_any_matrix(x, dx, system.negative_residual(), needed);
  guess.reset();
  const bool is_left = n_iterations && is_left_to_laws();
  if (model.is_linear() && n_iterations)
    residual_of_solver = refine_linear_solution(x, dx, is_left ? 0 : 2);
  update_moves = moves_constraints();
  update_loads = system.negative_residual();
  moving_loads.reset();
  keep_stage(dx);
  bool leaves_much = n_iterations && model.is_linear() && residual_of_solver > usual_linear_residual;
  const bool of_all = leaves_much || (n_iterations && may_be_refined && is_rounded(x, dx)),
             is_refined = n_iterations && may_be_refined && (of_all || !is_in_time);
  system.distribute(dx);
  centre_pressures(x, dx);
  keep_stage(dx);
  std::optional<double> inexact; // a share
  if (is_refined) {
    if (is_in_time)
      system.give_up_products(); // which are rounded as K is
    *n_iterations += refine_by_laws(x, dx, of_all, inexact);
    if (is_left && leaves_much && inexact != 0. && !leaves_rounding) {
      linear_solver.prefer_direct(of_unbalanced);
      *n_iterations += refine_by_laws(x, dx, of_all, inexact);
    }
    if (is_left) {
      residual_of_solver = residual_without_constrained(dx);
      leaves_much = residual_of_solver > usual_linear_residual;
    }
  }
  if (leaves_much && !(inexact == 0. && are_volumes_kept()))
    explain_linear_residual();
  else if (leaves_much) // what the laws leave is less than what K dx shows
    residual_of_solver = usual_linear_residual;
  else if (model.is_linear() && inexact.value_or(0) > 0)
    explain_share(*inexact * sizes.part_of_solution(x, dx));
  if (!model.is_linear())
    learn_scales(x, dx);
  if (linearised_at.size() > 0)
    size_of_update = dx.l2_norm();
  return n_iterations;
}

/// Of a linear stage. What rounding leaves of K dx in a stiff body that soft ones hold, or a soft spring, has
/// a resultant, which moves it: the entries of K are rounded. Forces by the laws have none, whatever the
/// rounding of strains: the gradients of the functions of a cell add up to zero. So dx is refined by the
/// residual of the laws, from the first group on that has stiff and soft bodies, or of all groups if @p
/// of_all.
/// @param of_all where rounding leaves more of K dx than is allowed, or may change much of its energy
/// @param inexact the share of dx that may be wrong, where that is more than is asked for, or 0
/// @return the number of linear iterations
template <int dim>
unsigned int StepProblem<dim>::refine_by_laws(const Vector &x, Vector &dx, const bool of_all,
                                              std::optional<double> &inexact)
{
  const double two_digits = 1e-2;
  LinearSolver::Demand needed = rough_demand(two_digits);
  const unsigned int end = needed.end_group,
                     first = of_all ? needed.first_group
                                    : linear_solver.first_with_stiff_and_soft(needed.first_group, end);
  if (first == end)
    return 0;
  const auto residual = [&](const Vector &update, Vector &rest) {
    Vector state = x;
    state += update;
    const bool is_defined = system.assemble(state, false, {}, blocks_of_residual(true));
    rest = system.negative_residual();
    return is_defined;
  };
  const auto inverse = [&](const Vector &rest, Vector &correction) {
    const auto n_iterations = solve_with_any_matrix(x, correction, rest, needed);
    has_solver_failed = has_solver_failed || !n_iterations;
    system.distribute(correction);
    keep_stage(correction);
    return n_iterations;
  };
  const auto share = [&](const Vector &step, const Vector &update) {
    return sizes.share_of(step, x, update);
  };
  unsigned int n_iterations = 0;
  inexact = 0;
  for (unsigned int g = first; g < end; ++g) {
    needed.first_group = g;
    needed.end_group = g + 1;
    IterativeRefinement refinement(residual, inverse, share, linear_solver.is_symmetric(g));
    refinement.refine(dx);
    n_iterations += refinement.n_iterations();
    if (!refinement.is_exact())
      inexact = std::max(*inexact, refinement.share_of_last_step());
  }
  centre_pressures(x, dx);
  return n_iterations;
}

/// Of a linear scene, the largest one of all parts; @p rest is what @p dx leaves.
template <int dim>
double StepProblem<dim>::linear_residual(const Vector &dx, Vector &rest) const
{
  const std::vector<double> residuals = system.linear_residuals(dx, rest);
  const bool are_finite = std::all_of(residuals.begin(), residuals.end(),
                                      [](const double residual) { return std::isfinite(residual); });
  return are_finite ? *std::max_element(residuals.begin(), residuals.end())
                    : std::numeric_limits<double>::quiet_NaN();
}

template <int dim>
double StepProblem<dim>::residual_without_constrained(const Vector &dx) const
{
  Vector unknowns = system.owned_vector(), rest = unknowns;
  copy_unconstrained(dx, unknowns);
  return linear_residual(unknowns, rest);
}

template <int dim>
void StepProblem<dim>::copy_unconstrained(const Vector &from, Vector &to) const
{
  for (unsigned int b = 0; b < to.n_blocks(); ++b) {
    const Block &block = model.numbering->blocks()[b];
    for (unsigned int i = 0; i < block.owned.n_elements(); ++i)
      if (!system.is_constrained(block.begin + block.owned.nth_index_in_set(i)))
        to.block(b).trilinos_vector()[0][i] = from.block(b).trilinos_vector()[0][i];
  }
}

/// Of a linear scene. The solver only has to find what the guess leaves, unless that is no less than what
/// there is without it.
template <int dim>
std::optional<unsigned int> StepProblem<dim>::solve_from_guess(const Vector &x, Vector &dx)
{
  Vector start = system.owned_vector(), rest = start;
  const double without = linear_residual(start, rest);
  copy_unconstrained(*guess, start);
  const double with = linear_residual(start, rest);
  LinearSolver::Demand needed = demand();
  if (!(with < without))
    return solve_with_any_matrix(x, dx, system.negative_residual(), needed);
  ++n_guesses;
  if (with > 0)
    needed.enough = share_of_exact * exact_linear_residual / with;
  needed.excess = [&](const Vector &beyond, const auto &blocks) {
    Vector all = start;
    all += beyond;
    return excess(all, blocks);
  };
  const auto n_iterations = solve_with_any_matrix(x, dx, rest, needed);
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

/// K dx = b with the tangent K at @p x, which is made anew where another solver takes over that needs another
/// kind of matrix.
template <int dim>
std::optional<unsigned int> StepProblem<dim>::solve_with_any_matrix(const Vector &x, Vector &dx,
                                                                    const Vector &b,
                                                                    const LinearSolver::Demand &needed)
{
  auto n_iterations = linear_solver.solve(dx, b, needed);
  while (!n_iterations && linear_solver.lacks_operator()) {
    make_other_tangent(x);
    n_iterations = linear_solver.solve(dx, b, needed);
  }
  return n_iterations;
}

/// How much larger the residual of @p dx is than an exact one. A linear stage is measured by Newton's method,
/// by what its cells have after the update: about what they had before, or less.
template <int dim>
double StepProblem<dim>::excess(const Vector &dx, const std::vector<unsigned int> &blocks) const
{
  Vector rest = system.owned_vector();
  const std::vector<double> relative = system.linear_residuals(dx, rest), forces = system.forces();
  double largest = 0;
  for (const unsigned int b : blocks)
    largest = std::max(largest, model.is_linear() ? relative[b] : rest.block(b).l2_norm() / forces[b]);
  return largest / exact_linear_residual;
}

namespace {

/// Whether what @p dx leaves too much of is in each part what rounding may leave of K dx, as in a stiff body
/// that moves with soft ones: then nothing can be solved for.
template <int dim>
bool is_rounding(BlockSystem<dim> &system, const BlockMatrix::Vector &dx)
{
  BlockMatrix::Vector rest = system.owned_vector();
  const std::vector<double> residuals = system.linear_residuals(dx, rest),
                            sizes = system.tangent().sizes_of_products(dx);
  for (unsigned int b = 0; b < residuals.size(); ++b)
    if (!(residuals[b] <= exact_linear_residual) &&
        !(rest.block(b).l2_norm() <= std::numeric_limits<double>::epsilon() * sizes[b]))
      return false;
  return true;
}

} // namespace

/// Of a linear scene, whether its solution is refined by the laws in any case, which is more than by its
/// matrix.
template <int dim>
bool StepProblem<dim>::is_left_to_laws() const
{
  const Stage &stage = stages[present_stage];
  return model.is_linear() && !is_remembered() && has_linear_stage() && linear_solver.iterates() &&
         linear_solver.first_with_stiff_and_soft(stage.first_group, stage.end_group) == stage.first_group;
}

/// The linear solver sees one norm for all bodies; a body that carries little beside one that carries much
/// may be left unsolved. The rest is solved for once more, then directly.
/// @param most_passes 0: it is only measured
/// @return the relative residual of dx, the largest of all parts
template <int dim>
double StepProblem<dim>::refine_linear_solution(const Vector &x, Vector &dx, const unsigned int most_passes)
{
  has_solver_failed = false;
  Vector rest = system.owned_vector(), correction;
  double relative = linear_residual(dx, rest);
  leaves_rounding = relative > exact_linear_residual && is_rounding(system, dx);
  for (unsigned int pass = 0; pass < most_passes && !leaves_rounding &&
                              relative > (pass == 0 ? exact_linear_residual : usual_linear_residual);
       ++pass) {
    if (pass == 1)
      linear_solver.prefer_direct(of_unbalanced);
    LinearSolver::Demand needed = demand();
    needed.enough = share_of_exact * exact_linear_residual / relative;
    correction.reinit(rest);
    has_solver_failed = !solve_with_any_matrix(x, correction, rest, needed);
    if (has_solver_failed)
      break;
    Vector trial = dx;
    trial += correction;
    if (const double refined = linear_residual(trial, rest); refined < relative) {
      dx = trial;
      relative = refined;
    }
  }
  return relative;
}

template <int dim>
void StepProblem<dim>::explain_linear_residual()
{
  std::ostringstream words;
  words.precision(2);
  words
      << "the linear system is solved to " << residual_of_solver << " of the forces at work only, because "
      << (has_solver_failed ? "the linear solver failed for what is left: its matrix may be "
                            : "rounding leaves no less: its matrix is ")
      << "close to singular. Check what holds the bodies, and how far their stiffnesses and penalties differ";
  all_notes.push_back(of_singular_matrix(words.str()));
}

/// @param share that the last step of a refinement had, which did not get to its end, 1 if it took none
template <int dim>
void StepProblem<dim>::explain_share(const double share)
{
  if (share < std::max(IterativeRefinement::exact_share, 2 * told_share)) // each step may have one
    return;
  told_share = share;
  std::ostringstream words;
  words.precision(1);
  words << "rounding of the matrix ";
  if (share < 1)
    words << "leaves an error of about " << share << " of the solution";
  else
    words << "may change the solution";
  words << ", where soft or slender bodies hold stiff ones: it is close to singular. Check what holds "
           "them, and how far their stiffnesses and penalties differ";
  all_notes.push_back(of_singular_matrix(words.str()));
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
/// Leaves R(x) of the present stage assembled.
template <int dim>
Vector StepProblem<dim>::find_moving_loads(const Vector &x)
{
  system.assemble(x, false, {}, blocks_of_residual(true));
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

/// @return false if the laws are not defined at rest.
template <int dim>
bool StepProblem<dim>::stabilise(const Vector &x, const double share)
{
  forget_updates();
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
  if (!std::isfinite(measure(system.assemble(x, true))))
    return false;
  give_matrix();
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
