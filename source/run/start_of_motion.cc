// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/start_of_motion.h>

#include <dovetail/system/place.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <array>
#include <limits>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_start("jump at the start",
                        "a motion begins elsewhere than where a condition prescribes it");

/// Of the first step, and of the smallest cell, for differences.
const double small_share = 1e-5;
/// Of Newton's method for positions and pressures.
const double smallest_damping = 1e-4;
const unsigned int most_passes = 50;

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

void copy_rows(const std::vector<std::vector<unsigned int>> &rows, const Vector &from, Vector &to)
{
  for (unsigned int b = 0; b < rows.size(); ++b)
    for (const unsigned int i : rows[b])
      to.block(b).trilinos_vector()[0][i] = from.block(b).trilinos_vector()[0][i];
}

} // namespace

template <int dim>
StartOfMotion<dim>::StartOfMotion(const Model<dim> &model, BlockSystem<dim> &system,
                                  StepProblem<dim> &equations, LinearSolver &solver, Phases &phases,
                                  const double end)
    : model(model), system(system), equations(equations), linear_solver(solver), phases(phases), end(end)
{
}

/// @return whether it is defined at @p x: the tangent for second rates mass_alone x.
template <int dim>
bool StartOfMotion<dim>::assemble_mass(const Vector &x)
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
  equations.give_matrix();
  return true;
}

/// Solved again for what the solver leaves.
template <int dim>
Vector StartOfMotion<dim>::solve_mass(const Vector &x, const Vector &right_hand_side)
{
  const double exact = 1e-14;
  Vector solution = system.owned_vector(), rest = right_hand_side, correction = rest;
  for (unsigned int pass = 0; pass < 3 && rest.l2_norm() > exact * right_hand_side.l2_norm(); ++pass) {
    bool is_solved = linear_solver.solve(correction, rest).has_value();
    for (bool is_assembled = true; is_assembled && !is_solved && linear_solver.lacks_operator();) {
      equations.make_other_matrix();
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
void StartOfMotion<dim>::set_rates_alone(const Vector &x, const Vector &rate, const Vector &second_rate)
{
  Rates rates;
  rates.rest = rate;
  rates.second_rest = second_rate;
  rates.weights = {0};
  rates.past = {x};
  system.set_rates(rates);
}

template <int dim>
bool StartOfMotion<dim>::has_pressures() const
{
  for (unsigned int b = 0; b < model.numbering->blocks().size(); ++b)
    if (is_of_pressure(b))
      return true;
  return false;
}

/// Whose equation knows displacements alone by the tangent at hand, since the body is incompressible where
/// the pressure acts: it says nothing of the pressure, but limits how the body moves. By block.
template <int dim>
typename StartOfMotion<dim>::Rows StartOfMotion<dim>::incompressible_rows() const
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
bool StartOfMotion<dim>::is_any(const Rows &rows) const
{
  const bool is_here = std::any_of(rows.begin(), rows.end(), [](const auto &list) { return !list.empty(); });
  return dealii::Utilities::MPI::max(is_here ? 1 : 0, model.communicator) == 1;
}

/// With the matrix c M + K, where c is as large as can be, an update is a/c of what has a mass; the forces of
/// multipliers and pressures, and other fields, are found with it. Where a body is incompressible, this
/// update must not close what its volume is off by now, which is rounding. Accelerations, constant until the
/// end of the step, have to keep the volume until then: B a = -2/h^2 of what @p without is off by there.
template <int dim>
std::optional<Vector> StartOfMotion<dim>::second_rates(const double now, const Vector &x, const Vector &rate,
                                                       const Vector &of_constrained, const double h,
                                                       Vector &forces)
{
  const Phases::Scope scope(phases, "solve");
  if (!assemble_mass(x))
    return {};
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
void StartOfMotion<dim>::keep_volume(const double now, const Vector &x, Vector &rate)
{
  if (!assemble_mass(x))
    return;
  const Rows of_volume = incompressible_rows();
  if (!is_any(of_volume))
    return;
  Vector none = rate;
  none = 0;
  Vector limited = none;
  find_rates_of_volume(now, x, rate, of_volume, limited);
  rate += projection(x, none, limited);
  system.set_time(end);
}

template <int dim>
void StartOfMotion<dim>::satisfy_ties(Vector &x, Vector &rate)
{
  const double begin = 0;
  if (!system.is_outdated(begin)) {
    system.set_time(begin);
    compare_start(x);
  }
  project_start(x, rate);
  system.set_time(end);
}

/// What moves comes to where it is prescribed within the first step, and brings the energy of that.
template <int dim>
void StartOfMotion<dim>::compare_start(const Vector &x)
{
  const double rounding = 1e-8; // of the displacements
  Vector difference = x, others = x;
  system.constrain(difference);
  system.follow(others);
  const Vector given = difference;
  difference -= others;
  for (unsigned int b = 0; b < x.n_blocks(); ++b) {
    const double largest = has_inertia(b) ? difference.block(b).linfty_norm() : 0.;
    if (largest <= rounding * std::max(x.block(b).linfty_norm(), given.block(b).linfty_norm()))
      continue;
    const Block &block = model.numbering->blocks()[b];
    std::ostringstream words;
    words.precision(3);
    words << "the " << block.field << " of " << block.name << " begins up to " << largest
          << " away from what its conditions prescribe at t = 0" << in_cell_of_largest(model, difference, b)
          << ". The first step closes this at once, the faster the smaller it is, and the waves of it stay. "
             "Give an Initial displacement that agrees with the conditions";
    all_notes.push_back(of_start(words.str()));
  }
}

template <int dim>
bool StartOfMotion<dim>::has_inertia(const unsigned int b) const
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
void StartOfMotion<dim>::follow_rates(Vector &rate)
{
  const double later = small_share * end;
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
void StartOfMotion<dim>::project_start(Vector &x, Vector &rate)
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
void StartOfMotion<dim>::assemble_mass_of_start(const Vector &x)
{
  if (assemble_mass(x))
    return;
  Undefined why = system.why_undefined();
  why.reason = "the initial state is not defined: " + why.reason;
  refuse_undefined(why, model.communicator);
}

/// The rows of what limits motions.
template <int dim>
Vector StartOfMotion<dim>::limits(const Rows &of_volume, const Vector &residual) const
{
  Vector result = only([this](const unsigned int b) { return is_of_multipliers(b); }, residual);
  copy_rows(of_volume, residual, result);
  return result;
}

/// What moves with @p change of constrained unknowns, by the mass of the last assembly at @p x, such that
/// the motion is @p limited.
template <int dim>
Vector StartOfMotion<dim>::projection(const Vector &x, const Vector &change, const Vector &limited)
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
bool StartOfMotion<dim>::assemble_at_rest(const Vector &x)
{
  Vector none = x;
  none = 0;
  set_rates_alone(x, none, none);
  return system.assemble(x, false);
}

/// Newton's method, damped such that what is to be closed shrinks. The mass is that of @p x.
template <int dim>
void StartOfMotion<dim>::project_positions(const Rows &of_volume, const Vector &x_change, Vector &x)
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
  const bool is_nonlinear = is_any(of_volume) && model.has_large_strain();
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
void StartOfMotion<dim>::refuse_positions(const Vector &limited) const
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
void StartOfMotion<dim>::find_pressures(const Rows &of_volume, Vector &x)
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
void StartOfMotion<dim>::find_rates_of_volume(const double begin, const Vector &x, const Vector &rate,
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
  const double later = small_share * (end - begin);
  const std::array<double, 3> factors = {{-1.5, 2, -0.5}};
  for (unsigned int k = 0; k < 3 && !system.is_outdated(begin) && !system.is_outdated(begin + 2 * later);
       ++k) {
    system.set_time(begin + k * later);
    add(factors[k] / later);
  }
  copy_rows(rows, change, negative_rates);
}

template class StartOfMotion<2>;
template class StartOfMotion<3>;

} // namespace dovetail
