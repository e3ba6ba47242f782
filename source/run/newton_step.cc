// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/newton_step.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace dovetail {

namespace {

std::vector<bool> blocks_of_multipliers(const Numbering &numbering)
{
  std::vector<bool> are;
  for (const Block &block : numbering.blocks())
    are.push_back(block.is_of_multipliers);
  return are;
}

} // namespace

template <int dim>
NewtonStep<dim>::NewtonStep(const Model<dim> &model, BlockSystem<dim> &system, const Newton &newton,
                            LinearSolver &solver, Phases &phases, Log &log)
    : model(model), system(system), newton(newton), linear_solver(solver), phases(phases), log(log),
      criterion(system.fields_of_blocks(), blocks_of_multipliers(*model.numbering),
                newton.residual_tolerance(), newton.absolute_tolerance()),
      solution(system.owned_vector()), trial(solution), update(solution), correction(solution),
      scales(solution.n_blocks(), 0.)
{
}

template <int dim>
void NewtonStep<dim>::begin(const double t_of_step, const Vector &x)
{
  t = t_of_step;
  start = x;
  tangent_at_rest.clear(); // ties and conditions may have changed
  may_adapt = !has_converged;
  is_first_assembly = true;
  criterion.begin_step();
  smallest_at_start.clear();
  largest_at_start.clear();
  for (unsigned int b = 0; b < x.n_blocks(); ++b) {
    smallest_at_start.push_back(x.block(b).min());
    largest_at_start.push_back(x.block(b).max());
  }
  scales.assign(x.n_blocks(), 0.);
}

template <int dim>
double NewtonStep<dim>::assemble(const bool asks_for_tangent)
{
  const Phases::Scope scope(phases, "assembly");
  const bool with_tangent = asks_for_tangent && !system.keeps_tangent();
  has_new_tangent = has_new_tangent || with_tangent;
  const bool is_defined = system.assemble(trial, with_tangent);
  if (is_first_assembly)
    loads_at_start = {{system.negative_residual().l2_norm(), system.largest_move()}};
  is_first_assembly = false;
  last_residual = is_defined ? criterion.residual({system.residuals(), system.forces(), system.rounding()})
                             : std::numeric_limits<double>::quiet_NaN();
  return last_residual;
}

template <int dim>
const std::array<double, 2> &NewtonStep<dim>::loads_at(const Vector &x)
{
  trial = x;
  assemble(true); // moving prescribed values are loads by the tangent
  return loads_at_start;
}

template <int dim>
double NewtonStep<dim>::residual_at(const Vector &x)
{
  trial = x;
  return assemble(false);
}

template <int dim>
std::optional<unsigned int> NewtonStep<dim>::solve_for_update(const std::function<void()> &check_tangent)
{
  const Phases::Scope scope(phases, "solve");
  if (has_new_tangent) {
    linear_solver.set_matrix(system.tangent());
    if (model.is_linear())
      check_tangent();
  }
  has_new_tangent = false;
  const auto n_iterations = linear_solver.solve(update, system.negative_residual());
  if (model.is_linear() && n_iterations)
    linear_residual = refine_linear_solution();
  update_moves = system.moves_constraints();
  has_moving_loads = false;
  update_loads = system.negative_residual();
  system.distribute(update);
  if (!model.is_linear())
    learn_scales();
  return n_iterations;
}

/// The linear solver sees one norm for all bodies; a body that carries little beside one that carries much
/// may be left unsolved. The rest is solved for once more, then directly.
/// @return the relative residual of the update, the largest of all parts
template <int dim>
double NewtonStep<dim>::refine_linear_solution()
{
  const double usual = 1e-8;
  Vector rest = system.owned_vector();
  double relative = system.linear_residual_norm(update, rest);
  for (unsigned int pass = 0; pass < 2 && relative > usual; ++pass) {
    if (pass == 1)
      linear_solver.prefer_direct();
    if (!linear_solver.solve(correction, rest))
      break;
    trial = update;
    trial += correction;
    if (const double refined = system.linear_residual_norm(trial, rest); refined < relative) {
      update = trial;
      relative = refined;
    }
  }
  if (relative > usual) {
    std::ostringstream words;
    words.precision(2);
    words << "the linear system is solved to " << relative
          << " of the forces at work only, by the direct solver too: its matrix is close to singular. Check "
             "what "
             "holds the bodies, and how far their stiffnesses and penalties differ";
    all_notes.push_back(words.str());
  }
  return relative;
}

/// Updates of different fields are compared in the ranges of their values, which a step does not shrink.
template <int dim>
void NewtonStep<dim>::learn_scales()
{
  const unsigned int n_blocks = scales.size();
  const auto &field = system.fields_of_blocks();
  std::vector<double> smallest(n_blocks, std::numeric_limits<double>::infinity()),
      largest(n_blocks, -std::numeric_limits<double>::infinity()); // by field
  trial = solution;
  if (std::all_of(scales.begin(), scales.end(), [](const double scale) { return scale == 0; }))
    trial += update; // where prescribed values have not moved yet, all may be zero
  for (unsigned int b = 0; b < n_blocks; ++b) {
    const unsigned int f = field[b];
    smallest[f] = std::min({smallest[f], smallest_at_start[b], trial.block(b).min()});
    largest[f] = std::max({largest[f], largest_at_start[b], trial.block(b).max()});
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
double NewtonStep<dim>::norm(const Vector &of_update) const
{
  double square = 0;
  for (unsigned int b = 0; b < scales.size(); ++b)
    if (scales[b] > 0 && !model.numbering->blocks()[b].is_of_multipliers)
      square += std::pow(of_update.block(b).l2_norm() / scales[b], 2);
  return std::sqrt(square);
}

/// What the moving prescribed values do to the right-hand side, if they move by as much as in dx.
template <int dim>
void NewtonStep<dim>::find_moving_loads()
{
  if (has_moving_loads)
    return;
  const Vector accepted = trial;
  system.assemble(solution, false);
  moving_loads = update_loads;
  moving_loads -= system.negative_residual();
  has_moving_loads = true;
  system.assemble(accepted, false);
}

template <int dim>
std::optional<NewtonProblem::Correction> NewtonStep<dim>::correct(const double damping)
{
  if (update_moves && damping < 1) {
    const Phases::Scope scope(phases, "assembly");
    find_moving_loads();
  }
  const Phases::Scope scope(phases, "solve");
  Vector loads = system.negative_residual();
  if (update_moves && damping < 1)
    loads.add(1 - damping, moving_loads);
  if (!linear_solver.solve(correction, loads))
    return {};
  system.distribute(correction);
  Vector difference = correction;
  difference.add(damping - 1, update);
  return NewtonProblem::Correction{norm(correction), norm(difference)};
}

/// Of unknowns that are free; the others follow them or are prescribed.
template <int dim>
bool NewtonStep<dim>::is_update_small() const
{
  const unsigned int n_blocks = update.n_blocks();
  std::vector<double> largest(n_blocks, 0.), energies(n_blocks, 0.);
  WorkingUpdate sizes;
  for (unsigned int b = 0; b < n_blocks; ++b) {
    const Block &block = model.numbering->blocks()[b];
    const double *dx = update.block(b).trilinos_vector()[0], *R = update_loads.block(b).trilinos_vector()[0];
    for (unsigned int i = 0; i < block.owned.n_elements(); ++i)
      if (!system.is_constrained(block.begin + block.owned.nth_index_in_set(i))) {
        largest[b] = std::max(largest[b], std::abs(dx[i]));
        energies[b] += dx[i] * R[i];
      }
    sizes.smallest_value.push_back(std::min(smallest_at_start[b], trial.block(b).min()));
    sizes.largest_value.push_back(std::max(largest_at_start[b], trial.block(b).max()));
    sizes.n_unknowns.push_back(update.block(b).size());
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
bool NewtonStep<dim>::adapt_ties()
{
  bool has_changed = false;
  if (may_adapt) {
    may_adapt = false;
    Vector state = start;
    for (unsigned int b = 0; b < state.n_blocks(); ++b)
      if (is_scalar(b))
        state.block(b) = solution.block(b);
    has_changed = system.refreeze(t, state);
  }
  return system.adapt_ties(t, solution) || has_changed;
}

/// Of some solid: only then limit points are looked for.
template <int dim>
bool NewtonStep<dim>::has_large_strain() const
{
  const auto &blocks = model.numbering->blocks();
  for (unsigned int b = 0; b < blocks.size(); ++b)
    if (!blocks[b].is_of_multipliers && !is_scalar(b) &&
        !model.domains[blocks[b].domain_index]->material.is_linear(blocks[b].field_index))
      return true;
  return false;
}

/// @return false if the laws are not defined at rest.
template <int dim>
bool NewtonStep<dim>::stabilise(const double share)
{
  if (tangent_at_rest.n_block_rows() == 0) {
    const Vector accepted = trial;
    for (unsigned int b = 0; b < trial.n_blocks(); ++b)
      if (!is_scalar(b))
        trial.block(b) = 0;
    const bool is_defined = std::isfinite(assemble(true));
    if (is_defined)
      tangent_at_rest.copy_from(system.tangent());
    trial = accepted;
    assemble(true);
    if (!is_defined)
      return false;
  }
  system.add_to_tangent(share, tangent_at_rest);
  return true;
}

/// Of a domain, not of multipliers.
template <int dim>
bool NewtonStep<dim>::is_scalar(const unsigned int b) const
{
  const Block &block = model.numbering->blocks()[b];
  return !block.is_of_multipliers &&
         model.domains[block.domain_index]->fields()[block.field_index].n_components == 1;
}

template <int dim>
void NewtonStep<dim>::spread_prescribed_values(Vector &x)
{
  trial = x;
  if (!std::isfinite(assemble(true)))
    return;
  linear_solver.set_matrix(system.tangent());
  has_new_tangent = false;
  solution = x;
  update_loads = system.negative_residual();
  has_moving_loads = false;
  find_moving_loads();
  if (!linear_solver.solve(update, moving_loads))
    return;
  system.distribute(update);
  for (unsigned int b = 0; b < x.n_blocks(); ++b)
    if (is_scalar(b))
      x.block(b) += update.block(b);
  is_spread = true;
}

template <int dim>
std::string NewtonStep<dim>::what_failed() const
{
  if (found_no_damping && std::isfinite(last_residual))
    return "no share of the last update leads on; the largest residual is that";
  if (!std::isfinite(last_residual))
    return "the last state that was tried is not defined; the largest residual is that";
  std::ostringstream words;
  words.precision(2);
  words << "the largest residual, " << last_residual << " of the forces at work, is that";
  return words.str();
}

template <int dim>
std::string NewtonStep<dim>::suggestion() const
{
  if (needs_iterations)
    return "Raise Maximum iterations in the subsection Newton, or give an Initial that is nearer to the "
           "solution.";
  return "Let the load grow with t in more steps, or give an Initial that is nearer to the solution.";
}

template <int dim>
NewtonResult NewtonStep<dim>::solve(Vector &x, const std::function<void()> &check_tangent)
{
  solution = x;
  NewtonProblem problem;
  problem.is_linear = model.is_linear();
  problem.confirms_first_update = is_spread;
  is_spread = false;
  problem.assemble = [&](const bool with_tangent) { return assemble(with_tangent); };
  problem.solve = [&]() { return solve_for_update(check_tangent); };
  problem.try_update = [&](const double damping) {
    trial = solution;
    if (damping != 0)
      trial.add(damping, update);
  };
  problem.accept = [&]() {
    solution = trial;
    system.accept_state();
  };
  problem.moves_constraints = [&]() { return system.moves_constraints(); };
  problem.linear_residual = [&]() { return linear_residual; };
  problem.update_norm = [&]() { return norm(update); };
  problem.is_update_small = [&]() { return is_update_small(); };
  problem.correct = [&](const double damping) { return correct(damping); };
  problem.distance_of_correction = [&]() {
    Vector difference = correction;
    difference -= update;
    return norm(difference);
  };
  problem.adapt = [&]() { return adapt_ties(); };
  if (may_jump && has_large_strain())
    problem.stabilise = [&](const double share) { return stabilise(share); };
  problem.report = [&](const unsigned int iteration, const double size, const unsigned int linear_iterations,
                       const double damping) {
    log.newton_iteration(iteration, size, linear_iterations, damping);
  };
  const NewtonResult result = newton.solve(problem);
  if (result.has_jumped) {
    std::ostringstream words;
    words.precision(4);
    words << "in the step to t = " << t
          << " the solution jumps: the tangent became singular on the way, as where bodies or single cells "
             "snap "
             "through. What comes after depends on the path; compare with smaller steps and a finer mesh";
    all_notes.push_back(words.str());
  }
  found_no_damping = !std::isfinite(result.residuals.back());
  has_converged = has_converged || result.is_converged;
  needs_iterations = !result.is_converged && result.linear_iterations.size() == newton.largest_number();
  x = solution;
  return result;
}

template class NewtonStep<2>;
template class NewtonStep<3>;

} // namespace dovetail
