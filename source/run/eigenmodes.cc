// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/eigenmodes.h>

#include <dovetail/material/transient.h>
#include <dovetail/run/initial_values.h>
#include <dovetail/run/start_of_motion.h>
#include <dovetail/scene/units.h>
#include <dovetail/solve/iterative_refinement.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <sstream>
#include <stdexcept>

namespace dovetail {

namespace {

const unsigned int n_guides = 8;
const unsigned int usual_number = 10; ///< of modes; used.prm has it in every scene

const NoteName of_modes("eigenmodes", "eigenmodes are missing or have not converged");
const NoteName of_rounded_modes("rounded eigenmodes", "rounding of the matrix shows in frequencies");
const NoteName of_unstable_state("unstable state", "modes of a state grow");

template <int dim>
bool has_mass(const Domain<dim> &domain, const Field &field)
{
  return domain.material.order_in_time(field.first_component) > 1;
}

/// Of no symmetry, so that no mode is orthogonal to it.
template <int dim>
double guide(const unsigned int number, const dealii::Tensor<1, dim> &X, const unsigned int component)
{
  double angle = 0.4 + 1.1 * number + 2.3 * component, other = 0.9 + 0.7 * number + 1.7 * component;
  for (unsigned int d = 0; d < dim; ++d) {
    angle += (1.3 + 0.53 * d + 0.61 * number) * X[d];
    other += (2.9 - 0.83 * d + 0.37 * number) * X[d];
  }
  return std::sin(angle) + 0.4 * std::cos(other);
}

std::string in_hertz(const double frequency)
{
  char text[40];
  std::snprintf(text, sizeof(text), "%.6g", frequency);
  return text;
}

} // namespace

template <int dim>
Eigenmodes<dim>::Eigenmodes(const Section &scene, const Model<dim> &model, NonlinearStep<dim> &step,
                            Results<dim> &results, Phases &phases, Notes &notes, Log &log)
    : model(model), step(step), results(results), phases(phases), notes(notes), log(log),
      section(scene.subsection("Steps")),
      n_modes(section.read<unsigned int>("Number of modes", usual_number, "With Kind = eigenmodes [-]",
                                         Patterns::Integer(1))),
      given_frequency(section.read<double>(
          "Near frequency", 0,
          "With Kind = eigenmodes: the modes next to this frequency; 0: the lowest ones [Hz]",
          Patterns::Double(0)))
{
  const bool is_on = finds_eigenmodes(scene);
  section.check(is_on || n_modes == usual_number, "Number of modes", "needs Kind = eigenmodes.");
  section.check(is_on || given_frequency == 0, "Near frequency", "needs Kind = eigenmodes.");
  if (is_on && !scene.documenting())
    check_scene(scene);
}

template <int dim>
void Eigenmodes<dim>::check_scene(const Section &scene) const
{
  const auto groups = model.field_groups();
  for (const auto &fields : groups) {
    bool is_mixed = false, is_massive = false;
    for (const auto &domain : model.domains)
      for (const Field &field : domain->fields())
        if (std::find(fields.begin(), fields.end(), field.name) != fields.end()) {
          is_massive = is_massive || has_mass(*domain, field);
          is_mixed = is_mixed || !(has_mass(*domain, field) || field.is_multiplier);
        }
    section.check(
        !(is_massive && is_mixed), "Kind",
        "cannot be eigenmodes where " + comma_separated(fields) +
            " depend on each other: only solids vibrate here. Remove what makes them depend, or the "
            "other laws of the material.");
  }
  section.check(std::any_of(model.domains.begin(), model.domains.end(),
                            [](const auto &domain) { return domain->material.order_in_time() > 1; }),
                "Kind", "is eigenmodes, but no material has a subsection Solid.");
  check_symmetry();
  const std::string shown = scene.peek("Output", "Fields");
  const Section output = scene.subsection("Output");
  const bool is_of_bodies_at_rest = model.is_linear() && groups.size() == 1;
  output.check(shown.empty() || shown == "solution" || is_of_bodies_at_rest, "Fields",
               "asks for " + shown +
                   ", but what laws make of a mode is known of linear scenes without other "
                   "fields only. Set Fields = solution.");
  output.check(shown.find("reactions") == std::string::npos, "Fields",
               "asks for reactions, which modes do not have. Remove it from the list.");
}

template <int dim>
void Eigenmodes<dim>::check_symmetry() const
{
  const std::string why = " eigenmodes need a symmetric matrix. ";
  for (const auto &domain : model.domains)
    for (unsigned int f = 0; f < domain->fields().size(); ++f)
      if (const Field &field = domain->fields()[f]; has_mass(*domain, field)) {
        section.check(domain->material.is_symmetric(f), "Kind",
                      "cannot be eigenmodes: the law of the material " + domain->material.name +
                          " has no symmetric tangent, but" + why + "Choose another law.");
        for (const auto &condition : domain->conditions())
          if (condition->field.name == field.name)
            condition->section.check(
                condition->is_symmetric(), "Type",
                "makes the matrix nonsymmetric, but" + why +
                    "With Follower = false a pressure keeps its direction; or remove the "
                    "condition.");
        for (const auto &interface : model.interfaces)
          for (const auto &tied : interface->fields)
            if (tied.name == field.name && !interface->is_symmetric())
              interface->section.fail("Type",
                                      "makes the matrix nonsymmetric, but" + why +
                                          "A Nitsche tie is symmetric with Theta = 1, Integrate on = "
                                          "source, destination or both, and Gap extension = symmetric "
                                          "or none; a Joint with one Strength, one Fracture energy and "
                                          "one Joint stiffness.");
      }
}

template <int dim>
void Eigenmodes<dim>::add_to(Plan &plan) const
{
  const std::string which =
      given_frequency > 0 ? "next to " + in_hertz(given_frequency) + " Hz" : "the lowest";
  plan.needed.push_back("eigenmodes: " + std::to_string(n_modes) + ", " + which +
                        ", by the Lanczos method with the matrix inverted");
  if (model.is_linear())
    plan.left_out.push_back("loads and steps: the modes of a linear scene do not depend on them");
  if (!model.interfaces.empty())
    plan.left_out.push_back("interfaces in the pictures: what they transmit is known of solutions only");
  if (results.has_probes())
    plan.left_out.push_back("probes of the modes: the files for ParaView show them");
}

template <int dim>
double Eigenmodes<dim>::frequency(const double value) const
{
  const double rounding = 1e-8; // of a rigid motion, relative to the shift
  if (!is_held && given_frequency == 0 && std::abs(value) <= rounding * std::abs(problem.shift))
    return 0;
  return std::copysign(std::sqrt(std::abs(value)), value) / (2 * dealii::numbers::PI);
}

/// Of the fields that have a mass, with their multipliers.
template <int dim>
void Eigenmodes<dim>::find_free_unknowns()
{
  const auto groups = model.field_groups();
  const auto is_massive = [&](const std::string &name) {
    return std::any_of(model.domains.begin(), model.domains.end(), [&](const auto &domain) {
      const Field *field = domain->material.find_field(name);
      return field != nullptr && has_mass(*domain, *field);
    });
  };
  while (std::none_of(groups[group].begin(), groups[group].end(), is_massive))
    ++group;
  free.clear();
  constrained.clear();
  const auto &blocks = model.numbering->blocks();
  for (unsigned int b = 0; b < blocks.size(); ++b)
    if (std::find(groups[group].begin(), groups[group].end(), blocks[b].field) != groups[group].end())
      for (unsigned int i = 0; i < blocks[b].owned.n_elements(); ++i) {
        const auto unknown = blocks[b].begin + blocks[b].owned.nth_index_in_set(i);
        if (step.system().is_constrained(unknown))
          constrained[b].push_back(i);
        else if (!(blocks[b].is_of_multipliers && step.system().is_dropped(unknown)))
          free.emplace_back(b, i);
      }
}

template <int dim>
typename Eigenmodes<dim>::Column Eigenmodes<dim>::gather(const Vector &x) const
{
  Column column;
  column.reserve(free.size());
  for (const auto &[block, i] : free)
    column.push_back(x.block(block).trilinos_vector()[0][i]);
  return column;
}

template <int dim>
Vector Eigenmodes<dim>::scatter(const Column &column) const
{
  Vector x = step.system().owned_vector();
  auto entry = column.begin();
  for (const auto &[block, i] : free)
    x.block(block).trilinos_vector()[0][i] = *entry++;
  return x;
}

template <int dim>
typename Eigenmodes<dim>::Column Eigenmodes<dim>::product(const BlockMatrix &matrix, const double factor,
                                                          const Column &x) const
{
  Vector y = step.system().owned_vector();
  matrix.vmult(y, scatter(x));
  y *= factor;
  return gather(y);
}

template <int dim>
double Eigenmodes<dim>::product(const Column &x, const Column &y) const
{
  return dealii::Utilities::MPI::sum(std::inner_product(x.begin(), x.end(), y.begin(), 0.),
                                     model.communicator);
}

template <int dim>
void Eigenmodes<dim>::make_guides()
{
  problem.guides.clear();
  const Domain<dim> &reference = *model.domains[0];
  for (unsigned int number = 0; number < n_guides; ++number) {
    Vector x = step.system().owned_vector();
    for (const auto &domain : model.domains)
      for (const Field &field : domain->fields())
        if (has_mass(*domain, field))
          set_nodes<dim>(
              model, *domain, field,
              [&](const dealii::Point<dim> &X, const unsigned int c) {
                return guide<dim>(number, (X - reference.centre()) * (2. / reference.typical_length()), c);
              },
              x);
    x.compress(dealii::VectorOperation::insert);
    problem.guides.push_back(gather(x));
  }
}

/// The forces of the laws at state + factor x, where x satisfies the constraints.
template <int dim>
typename Eigenmodes<dim>::Column Eigenmodes<dim>::forces(const double factor, const Column &x)
{
  Vector moved = scatter(x);
  step.system().distribute_rate(moved, true);
  moved *= factor;
  moved += state;
  step.system().set_rates({});
  if (!step.system().assemble(moved, false))
    throw std::runtime_error("a law is not defined in a vibration: " + step.system().why_undefined().reason);
  moved = step.system().negative_residual();
  moved *= -1;
  return gather(moved);
}

/// K x. By the laws, x is so large that loads are small beside it.
template <int dim>
typename Eigenmodes<dim>::Column Eigenmodes<dim>::stiffness_product(const Column &x)
{
  const double large = 1e6;
  Column Kx = product(stiffness, 1, x);
  if (!asks_laws)
    return Kx;
  const double ratio = std::sqrt(product(forces_at_rest, forces_at_rest) / product(Kx, Kx)),
               factor =
                   ratio > 0 && std::isfinite(ratio) ? std::exp2(std::ceil(std::log2(large * ratio))) : 1;
  Kx = forces(factor, x);
  for (std::size_t i = 0; i < Kx.size(); ++i)
    Kx[i] = (Kx[i] - forces_at_rest[i]) / factor;
  return Kx;
}

/// What rounding of the entries of K may change of x.Kx, a standard deviation relative to @p size.
template <int dim>
double Eigenmodes<dim>::rounding(const Column &x, const double size) const
{
  const Vector v = scatter(x);
  const std::vector<double> sizes = stiffness.sizes_of_products(v);
  double sum = 0;
  for (unsigned int b = 0; b < v.n_blocks(); ++b)
    sum += sizes[b] * v.block(b).linfty_norm();
  return std::numeric_limits<double>::epsilon() * sum / std::abs(size);
}

/// Where rounding shows in a smooth motion, as in a stiff body that a soft one holds or in a thin plate, K x
/// is what the laws give: a motion without strains has no forces then. Laws are asked in linear scenes.
template <int dim>
void Eigenmodes<dim>::look_for_rounding()
{
  const double allowed = 1e-11;
  if (!model.is_linear())
    return;
  const Column b = problem.mass(problem.guides[0]), x = inverse(b);
  const double size = product(x, b), by_matrix = product(x, problem.stiffness(x));
  forces_at_rest = forces(0, x);
  asks_laws = true;
  const double difference = product(x, problem.stiffness(x)) - by_matrix;
  asks_laws = std::max(rounding(x, size), std::abs(difference / size)) > allowed;
}

/// The tangent K + c M at the state.
template <int dim>
void Eigenmodes<dim>::assemble(const double c)
{
  Rates rates;
  if (c != 0) {
    rates.second_by_value = c;
    rates.rest = rates.second_rest = step.system().owned_vector();
    rates.second_rest.add(-c, state); // it is at rest
  }
  step.system().set_rates(rates);
  if (!step.system().assemble(state, true))
    throw std::runtime_error("a law is not defined at the state whose modes are wanted: " +
                             step.system().why_undefined().reason);
}

/// So that K - shift M is regular and, unless a frequency is given, definite: zero if nothing is free to
/// move, else well below what a smooth vibration has.
template <int dim>
void Eigenmodes<dim>::choose_shift()
{
  const double share = 1e-2;
  const Column &smooth = problem.guides[0];
  const double smooth_value =
      product(problem.stiffness(smooth), smooth) / product(problem.mass(smooth), smooth);
  problem.shift = given_frequency > 0 ? std::pow(2 * dealii::numbers::PI * given_frequency, 2)
                  : is_held           ? 0
                                      : -share * std::abs(smooth_value);
}

template <int dim>
void Eigenmodes<dim>::prepare_inverse(const double shift)
{
  LinearSolver &solver = step.solver();
  shift_of_inverse = shift;
  const auto make = [&]() {
    assemble(-shift);
    solver.set_matrix(step.system().tangent());
  };
  make();
  if (shift > 0)
    solver.prefer_direct(); // not definite
  if (!solver.lacks_operator())
    return;
  solver.forget_matrix();
  step.system().choose_entries(solver.needs_entries());
  step.system().make_matrix();
  make();
}

/// Once. @p enough: as LinearSolver::Demand has it.
template <int dim>
typename Eigenmodes<dim>::Column Eigenmodes<dim>::solve(const Column &b, const double enough)
{
  LinearSolver &solver = step.solver();
  LinearSolver::Demand needed{group, group + 1};
  needed.enough = enough;
  const Vector right_hand_side = scatter(b);
  Vector x = step.system().owned_vector();
  bool is_solved = solver.solve(x, right_hand_side, needed).has_value();
  for (unsigned int n = 0; n < 2 && !is_solved && solver.lacks_operator(); ++n) {
    prepare_inverse(shift_of_inverse);
    is_solved = solver.solve(x, right_hand_side, needed).has_value();
  }
  if (!is_solved)
    throw std::runtime_error("the linear solver failed");
  return gather(x);
}

/// b - (K - shift M) x
template <int dim>
typename Eigenmodes<dim>::Column Eigenmodes<dim>::rest(const Column &b, const Column &x)
{
  const Column Kx = problem.stiffness(x), Mx = problem.mass(x);
  Column result = b;
  for (std::size_t i = 0; i < b.size(); ++i)
    result[i] += shift_of_inverse * Mx[i] - Kx[i];
  return result;
}

/// What rounding, or the tolerance of an iteration, leaves is solved for, too.
template <int dim>
typename Eigenmodes<dim>::Column Eigenmodes<dim>::inverse(const Column &b)
{
  const double exact = 1e-11, rough = 1e-3;
  const Column first = solve(b), left = rest(b, first);
  if (product(left, left) <= exact * exact * product(b, b))
    return first;
  const auto residual = [&](const Vector &x, Vector &r) {
    r = scatter(rest(b, gather(x)));
    return true;
  };
  const auto solved = [&](const Vector &r, Vector &x) {
    x = scatter(solve(gather(r), rough));
    return std::optional<unsigned int>(0);
  };
  const auto share = [&](const Vector &step, const Vector &x) {
    const Column change = gather(step), all = gather(x);
    return std::sqrt(product(problem.mass(change), change) / product(problem.mass(all), all));
  };
  IterativeRefinement refinement(residual, solved, share, true);
  Vector x = scatter(first);
  refinement.refine(x);
  return gather(x);
}

/// By what the matrix makes of two vectors without any order. Ties and conditions have said so before, but
/// laws may lose it in a step.
template <int dim>
bool Eigenmodes<dim>::is_symmetric() const
{
  std::array<Column, 2> x = {{problem.guides[0], problem.guides[1]}};
  for (Column &column : x)
    for (std::size_t i = 0; i < column.size(); ++i) // multipliers have no guides
      column[i] = std::sin(1e4 * column[i] + i);
  const std::array<Column, 2> Kx = {{problem.stiffness(x[0]), problem.stiffness(x[1])}};
  const double size = std::sqrt(product(Kx[0], Kx[0]) * product(x[1], x[1]));
  return std::abs(product(Kx[0], x[1]) - product(Kx[1], x[0])) <= 1e-9 * size;
}

template <int dim>
bool Eigenmodes<dim>::run(const double t, const Vector &x)
{
  const Phases::Scope scope(phases, "solve");
  state = x;
  if (model.is_linear()) {
    state = 0;
    step.begin(t, state);
    step.system().constrain(state);
  }
  try {
    assemble(0);
    stiffness.copy_from(step.system().tangent());
    is_held = !step.system().find_unrestrained_mode(BlockSystem<dim>::Unless::held_at_rest);
    assemble(mass_alone);
    mass.copy_from(step.system().tangent());
    find_free_unknowns();
    if (dealii::Utilities::MPI::sum<unsigned long>(free.size(), model.communicator) == 0)
      throw std::runtime_error("no unknown is free to move.");
    problem.communicator = model.communicator;
    problem.stiffness = [this](const Column &column) { return stiffness_product(column); };
    problem.mass = [this](const Column &column) { return product(mass, 1 / mass_alone, column); };
    problem.inverse = [this](const Column &column) { return inverse(column); };
    make_guides();
    asks_laws = false;
    section.check(
        is_symmetric(), "Kind",
        "cannot be eigenmodes: the tangent at the state whose modes are wanted is not symmetric. A law "
        "or a tie has lost its symmetry.");
    choose_shift();
    prepare_inverse(problem.shift);
    look_for_rounding();
    const EigenPairs pairs = nearest_eigenpairs(problem, n_modes);
    write(pairs);
    count(pairs);
    return pairs.has_converged && why_not_counted.empty();
  } catch (const UserError &) {
    throw;
  } catch (const std::runtime_error &error) {
    notes.add(of_modes("no eigenmodes: " + std::string(error.what())));
    return false;
  }
}

/// The positions of the wanted pairs, in increasing order.
template <int dim>
std::vector<unsigned int> Eigenmodes<dim>::nearest(const EigenPairs &pairs) const
{
  std::vector<unsigned int> order(pairs.values.size());
  std::iota(order.begin(), order.end(), 0);
  if (given_frequency > 0) // else the lowest ones are the nearest
    std::stable_sort(order.begin(), order.end(), [&](const unsigned int i, const unsigned int j) {
      return std::abs(pairs.values[i] - problem.shift) < std::abs(pairs.values[j] - problem.shift);
    });
  order.resize(std::min<std::size_t>(order.size(), n_modes));
  std::sort(order.begin(), order.end());
  return order;
}

template <int dim>
void Eigenmodes<dim>::write(const EigenPairs &pairs)
{
  nlohmann::ordered_json frequencies = nlohmann::ordered_json::array(), residuals = frequencies;
  log.tell();
  const std::string units = section.top().peek("Units"),
                    title = "frequency [" + (units.empty() ? "Hz" : Units(units).of("Hz")) + "]";
  char row[80];
  std::snprintf(row, sizeof(row), "  mode  %14s  residual", title.c_str());
  log.tell(row);
  unsigned int number = 0, n_unstable = 0;
  for (const unsigned int k : nearest(pairs)) {
    const double hertz = frequency(pairs.values[k]);
    n_unstable += hertz < 0;
    frequencies.push_back(hertz);
    residuals.push_back(pairs.residuals[k]);
    std::snprintf(row, sizeof(row), "  %4u  %14.6g  %8.1e", ++number, hertz, pairs.residuals[k]);
    log.tell(row);
    Vector mode = scatter(pairs.vectors[k]);
    step.system().distribute_rate(mode, true);
    double largest = 0;
    const auto &blocks = model.numbering->blocks();
    for (unsigned int b = 0; b < blocks.size(); ++b)
      if (!blocks[b].is_constraint)
        largest = std::max(largest, mode.block(b).linfty_norm());
    mode *= 1 / largest;
    results.write_mode(step.system(), mode, number);
  }
  results.report().add("eigenfrequencies", frequencies);
  results.report().add("eigenmode residuals", residuals);
  note_rounding(pairs);
  if (number < n_modes)
    notes.add(of_modes("there are " + std::to_string(number) +
                       " modes only: the scene has no more unknowns that move"));
  if (n_unstable > 0)
    notes.add(
        of_unstable_state("the state is not stable: " + std::to_string(n_unstable) +
                          " of the modes grow; what stands with a minus is their rate divided by 2 pi"));
  if (!pairs.has_converged)
    notes.add(of_modes("not all eigenmodes have converged: their residuals tell which"));
}

/// Where the laws have not been asked.
template <int dim>
void Eigenmodes<dim>::note_rounding(const EigenPairs &pairs)
{
  if (asks_laws)
    return;
  const double allowed = 1e-7;
  double largest = 0;
  for (const unsigned int k : nearest(pairs))
    if (frequency(pairs.values[k]) != 0)
      largest = std::max(largest, rounding(pairs.vectors[k], pairs.values[k]) / 2);
  if (largest > allowed) {
    char size[40];
    std::snprintf(size, sizeof(size), "%.1e", largest);
    notes.add(of_rounded_modes("rounding of the entries of the matrix may change frequencies by " +
                               std::string(size) +
                               " of their values: stiff parts move with soft ones, or are thin"));
  }
}

/// How many eigenvalues lie below the shift, by the pivots of K - shift M. Rows of constrained unknowns have
/// a pivot of their own.
template <int dim>
bool Eigenmodes<dim>::has_counted(const double shift, unsigned long &n)
{
  prepare_inverse(shift);
  solve(problem.mass(problem.guides[0]));
  const auto n_negative = step.solver().n_negative_eigenvalues(group);
  unsigned long n_of_constrained = 0;
  for (const auto &[block, rows] : constrained) {
    const std::vector<double> diagonal = step.system().tangent().diagonal(block);
    n_of_constrained +=
        std::count_if(rows.begin(), rows.end(), [&](const unsigned int i) { return diagonal[i] < 0; });
  }
  n = n_negative.value_or(0) - dealii::Utilities::MPI::sum(n_of_constrained, model.communicator);
  return n_negative.has_value();
}

/// Whether as many eigenvalues as have been found lie next to the shift (Sylvester's law of inertia).
template <int dim>
void Eigenmodes<dim>::count(const EigenPairs &pairs)
{
  const double gap = 1e-5;
  const auto wanted = nearest(pairs);
  const auto &values = pairs.values;
  const auto is_gap = [&](const unsigned int k) { // before the k-th
    return values[k] - values[k - 1] > gap * std::abs(values[k] - problem.shift);
  };
  unsigned int end = wanted.back() + 1, begin = given_frequency > 0 ? wanted.front() : 0;
  while (end < values.size() && !is_gap(end))
    ++end;
  while (begin > 0 && !is_gap(begin))
    --begin;
  const bool knows_pivots = step.solver().n_negative_eigenvalues(group).has_value();
  const std::string what = "the count of eigenmodes by pivots: ";
  if (!knows_pivots || end == values.size() || (given_frequency > 0 && begin == 0)) {
    results.report().leave_out(what + (knows_pivots ? "no gap follows the frequencies that were found"
                                                    : "the matrix is not factorised as L D L^T"));
    return;
  }
  unsigned long below = 0, above = 0;
  if (!has_counted((values[end] + values[end - 1]) / 2, above) ||
      (begin > 0 && !has_counted((values[begin] + values[begin - 1]) / 2, below)))
    return;
  results.report().add("eigenmodes counted", above - below);
  if (above - below == end - begin)
    return;
  why_not_counted = std::to_string(above - below) + " eigenfrequencies lie where " +
                    std::to_string(end - begin) + " were found (below " +
                    in_hertz(frequency((values[end] + values[end - 1]) / 2)) + " Hz)";
  notes.add(of_modes("eigenmodes are missing: " + why_not_counted));
}

template class Eigenmodes<2>;
template class Eigenmodes<3>;

} // namespace dovetail
