// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/symmetric_eigenvalues.h>
#include <dovetail/tie/penalty.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/utilities.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace dovetail {

double eigenvalue_penalty(const double one, const double other)
{
  const double sum = one + other;
  return sum != 0 ? one * (other / sum) : 0;
}

namespace {

const NoteName of_coercivity("coercivity", "a penalty is too small for its tie to be coercive");
const NoteName of_large_penalty("large penalty", "a penalty locks the sides of a tie to each other");

constexpr double not_defined = std::numeric_limits<double>::quiet_NaN();

const char *const multiplier_help =
    "a or c: multiplies the penalty; automatic: for eigenvalue the larger of 2 and (1+Theta)^2/2, at large "
    "strain twice that and at degree 1 five times, for volume 1 [-]";

/// Measured to be the best compromise between flux, jump and error (prm/benchmarks/nitsche), and twice what
/// coercivity asks for, (1 + theta)^2/4, where that is more.
double automatic_multiplier(const double theta)
{
  return std::max(2., (1 + theta) * (1 + theta) / 2);
}

} // namespace

/// Nothing if it is automatic; 1 with a given penalty.
template <int dim>
std::optional<double> Penalty<dim>::read_multiplier(const Section &section, const Rule rule)
{
  if (rule == Rule::value && !section.documenting())
    return 1;
  const std::string text = section.read<std::string>("Multiplier", "automatic", multiplier_help);
  if (text == "automatic" || section.documenting())
    return {};
  section.check(Patterns::Double(0).match(text), "Multiplier",
                "is '" + text + "', but must be automatic or a number that is not negative.");
  return dealii::Utilities::string_to_double(text);
}

template <int dim>
Penalty<dim>::Penalty(const Section &section, const double theta)
    : theta(theta), weights(static_cast<Weights>(section.choose(
                        "Weights", {"eigenvalue", "volume", "equal", "source", "destination"}, 0,
                        "Weights of the two fluxes in their mean: by the trace eigenvalues of the cells, by "
                        "cell volume over "
                        "stiffness, one half each, or one side only [-]"))),
      rule(static_cast<Rule>(section.choose(
          "Penalty", {"eigenvalue", "volume", "value"}, 0,
          "eigenvalue: a L1 L2/(L1+L2) with the trace eigenvalues L of the cells, coercive for a > "
          "(1+Theta)^2/4; volume: c (G1+G2)/(V1/k1+V2/k2) with face areas G, cell volumes V and stiffnesses "
          "k "
          "(times p^2 for degree p); value: given [-]"))),
      given_multiplier(read_multiplier(section, rule)),
      has_automatic_multiplier(rule == Rule::eigenvalue && !given_multiplier),
      multiplier(given_multiplier.value_or(has_automatic_multiplier ? automatic_multiplier(theta) : 1.)),
      value(rule != Rule::value && !section.documenting()
                ? Expression()
                : section.require_expression("Value", {1},
                                             "The penalty gamma, with Penalty = value [Pa/m or W/(m^2 K)]"))
{
}

template <int dim>
void Penalty<dim>::set_fields(const Section &section, const std::vector<TiedField> &fields) const
{
  if (rule != Rule::value)
    return;
  std::string names;
  for (const TiedField &field : fields)
    names += (names.empty() ? "the " : " and the ") + field.name +
             (field.n_components == 1 ? " [W/(m^2 K)]" : " [Pa/m]");
  section.check(fields.size() == 1, "Value",
                "is one number, but the interface ties " + names +
                    ". Set Fields to one of them, and tie the other by an interface of its own.");
  if (!value.depends_on_position() && !value.depends_on_time())
    check_value(section, value.value(dealii::Point<dim>(), 0));
}

template <int dim>
std::string Penalty<dim>::description() const
{
  const std::array<const char *, 5> weights_by = {
      {"by eigenvalue", "by volume", "equal", "all on the source", "all on the destination"}};
  const std::array<const char *, 3> penalty_by = {{"by eigenvalue", "by volume", "given"}};
  const std::string weight = weights_by[static_cast<int>(weights)],
                    penalty = penalty_by[static_cast<int>(rule)];
  return weight == penalty ? "weights and penalty " + penalty : "weights " + weight + ", penalty " + penalty;
}

template <int dim>
void Penalty<dim>::check_value(const Section &section, const double gamma)
{
  std::ostringstream number;
  number << gamma;
  section.check(gamma >= 0 && std::isfinite(gamma), "Value",
                "is " + number.str() + " on the interface, but a penalty must be finite and not negative.");
}

/// Where it depends on place or time, at all points.
template <int dim>
void Penalty<dim>::check_value(const Interface<dim> &interface, const double t,
                               const MPI_Comm &communicator) const
{
  if (rule != Rule::value || (!value.depends_on_position() && !value.depends_on_time()))
    return;
  double smallest = 0, largest = 0;
  int is_number = 1;
  for (unsigned int q = 0; q < interface.pairing().n_points(); ++q) {
    const double gamma = value.value(interface.pairing().X(source, q), t);
    smallest = std::min(smallest, gamma);
    largest = std::max(largest, gamma);
    is_number = std::isnan(gamma) ? 0 : is_number;
  }
  smallest = dealii::Utilities::MPI::min(smallest, communicator);
  largest = dealii::Utilities::MPI::max(largest, communicator);
  is_number = dealii::Utilities::MPI::min(is_number, communicator);
  check_value(interface.section, is_number == 0 ? not_defined : smallest < 0 ? smallest : largest);
}

/// Whether weights and penalty are the same in all steps.
template <int dim>
bool Penalty<dim>::is_constant(const Interface<dim> &interface) const
{
  return interface.has_constant_fluxes() && (rule != Rule::value || !value.depends_on_time());
}

/// For weights, penalty and the coercivity margin, which is infinite for theta = -1.
template <int dim>
bool Penalty<dim>::needs_eigenvalues() const
{
  return weights == Weights::eigenvalue || rule == Rule::eigenvalue || theta != -1.;
}

template <int dim>
void Penalty<dim>::find_eigenvalues(const Interface<dim> &interface, const double t,
                                    const ValuesOf &values_of, const MPI_Comm &communicator)
{
  if (!needs_eigenvalues())
    return;
  const bool is_first = lambda.empty();
  lambda.resize(interface.fields.size());
  for (unsigned int f = 0; f < interface.fields.size(); ++f)
    if (is_first || !lambda[f].is_defined || !interface.has_constant_flux(interface.fields[f]))
      lambda[f] = trace_eigenvalues(interface, interface.fields[f], t, values_of, communicator);
}

/// The responses of both sides at a point, with derivatives; NaN if not defined.
template <int dim>
void Penalty<dim>::evaluate_stiffness(const Interface<dim> &interface,
                                      const typename Pairing<dim>::Group &group, const unsigned int q,
                                      const double t, const std::vector<double> &unknowns,
                                      SideStates<dim> &sides) const
{
  for (const unsigned int side : {source, destination})
    if (!sides.evaluate(interface, group, side, q, t, unknowns, true)) {
      const Material<dim> &material = interface.sides[side].domain->material;
      const unsigned int n = material.n_components();
      for (unsigned int c = 0; c < n; ++c) // the others are not touched by the next evaluation
        for (unsigned int d = 0; d < n; ++d)
          if (material.coupling(c, d).in_flux())
            sides.response[side].by_gradient[c * n + d][0][0] = not_defined;
    }
}

/// Largest eigenvalue of N.(dA/dgrad B).N, the acoustic tensor of a solid, the conductivity k_N of a scalar.
template <int dim>
double Penalty<dim>::stiffness(const Interface<dim> &interface, const TiedField &field,
                               const unsigned int side, const dealii::Tensor<1, dim> &N,
                               const SideStates<dim> &sides) const
{
  const unsigned int first = field.first_component[side], n = interface.sides[side].domain->n_components();
  const auto entry = [&](const unsigned int c, const unsigned int d) {
    return N * (sides.response[side].by_gradient[(first + c) * n + first + d] * N);
  };
  if (field.n_components == 1)
    return entry(0, 0);
  dealii::SymmetricTensor<2, dim> acoustic;
  for (unsigned int c = 0; c < dim; ++c)
    for (unsigned int d = c; d < dim; ++d)
      acoustic[c][d] = (entry(c, d) + entry(d, c)) / 2;
  return symmetric_eigenvalues(acoustic)[0];
}

/// @return the penalty per unit of the multiplier.
template <int dim>
double Penalty<dim>::choose(const Interface<dim> &interface, const unsigned int field_index,
                            const typename Pairing<dim>::Group &group, const unsigned int q, const double t,
                            const SideStates<dim> &sides, AtPoint &chosen) const
{
  const TiedField &field = interface.fields[field_index];
  std::array<double, 2> compliance = {{0, 0}}, area = {{0, 0}}, cell_eigenvalue = {{0, 0}};
  for (const unsigned int side : {source, destination}) {
    if (!lambda.empty())
      cell_eigenvalue[side] = lambda[field_index].penalty_values[side][group.cells[side]];
    if (weights != Weights::volume && rule != Rule::volume)
      continue;
    // V_i / (p_i^2 k_i): for a scalar the inverse of the trace constant is V_i / (p_i^2 k_i G_i)
    const CellBehind<dim> &cell = interface.pairing().cells[side][group.cells[side]];
    const double k =
        stiffness(interface, field, side, interface.pairing().N(side, q), sides) / field.in_jump(side);
    const double p = interface.sides[side].domain->layout().element(field.first_component[side]).degree;
    compliance[side] = cell.cell_measure / (p * p * k);
    area[side] = cell.face_measure;
  }
  const double sum_of_lambdas = cell_eigenvalue[source] + cell_eigenvalue[destination];
  const double sum = compliance[source] + compliance[destination];

  switch (weights) {
  case Weights::eigenvalue: // a face that is hardly touched has no eigenvalue
    for (const unsigned int side : {source, destination})
      chosen.weight[side] = sum_of_lambdas != 0 ? cell_eigenvalue[1 - side] / sum_of_lambdas : 0.5;
    break;
  case Weights::volume:
    chosen.weight = {{compliance[source] / sum, compliance[destination] / sum}};
    break;
  case Weights::equal:
    chosen.weight = {{0.5, 0.5}};
    break;
  case Weights::source:
    chosen.weight = {{1, 0}};
    break;
  case Weights::destination:
    chosen.weight = {{0, 1}};
    break;
  }
  double unit = 0;
  switch (rule) {
  case Rule::eigenvalue:
    unit = eigenvalue_penalty(cell_eigenvalue[source], cell_eigenvalue[destination]);
    break;
  case Rule::volume:
    unit = (area[source] + area[destination]) / sum;
    break;
  case Rule::value:
    unit = value.value(interface.pairing().X(source, q), t);
    break;
  }
  chosen.gamma = multiplier_of(interface, field) * unit;
  return unit;
}

/// At large strain the tangent grows while the penalty is frozen; and the flux of degree 1 says little about
/// that on the face of a cell in which the strain varies, so that the penalty carries more (measured on a
/// seal: doc/theory/nitsche.md).
template <int dim>
double Penalty<dim>::multiplier_of(const Interface<dim> &interface, const TiedField &field) const
{
  if (!has_automatic_multiplier || !has_large_strain(interface, field))
    return multiplier;
  const bool has_degree_1 =
      interface.sides[source].domain->degree == 1 || interface.sides[destination].domain->degree == 1;
  return (has_degree_1 ? 5 : 2) * multiplier;
}

template <int dim>
void Penalty<dim>::freeze(const Interface<dim> &interface, const double t, const ValuesOf &values_of,
                          SideStates<dim> &sides, const MPI_Comm &communicator)
{
  check_value(interface, t, communicator);
  find_eigenvalues(interface, t, values_of, communicator);

  const Pairing<dim> &pairing = interface.pairing();
  const bool needs_stiffness = weights == Weights::volume || rule == Rule::volume;
  const std::vector<AtPoint> old = points;
  points.resize(pairing.n_points() * interface.fields.size());
  present_range = {};
  least_multiplier = excess = 0;
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns;
  for (const auto &group : pairing.groups) {
    if (needs_stiffness) {
      interface.group_dofs(group, dofs);
      values_of(dofs, unknowns);
    }
    for (unsigned int q = group.begin; q < group.end; ++q) {
      if (needs_stiffness)
        evaluate_stiffness(interface, group, q, t, unknowns, sides);
      for (unsigned int f = 0; f < interface.fields.size(); ++f) {
        const unsigned int i = f * pairing.n_points() + q;
        AtPoint chosen;
        const double unit = choose(interface, f, group, q, t, sides, chosen);
        // a tangent that has lost its positivity says nothing about the stiffness: keep the last good one
        const bool is_good = chosen.gamma >= 0 && std::isfinite(chosen.gamma) && chosen.weight[source] >= 0 &&
                             chosen.weight[destination] >= 0;
        points[i] = is_good ? chosen : old.empty() ? AtPoint{{{0.5, 0.5}}, not_defined} : old[i];
        if (!first_gamma.empty() && rule != Rule::value &&
            interface.fields[f].n_components > 1) // a conductivity is positive, whatever it was
          points[i].gamma = std::max(points[i].gamma, first_gamma[i]);
        if (may_turn_skew(interface, interface.fields[f]))
          note_bound(f, group, points[i]);
        note_margin(f, group, points[i], unit);
      }
    }
  }
  if (first_gamma.empty())
    for (const AtPoint &at_point : points)
      first_gamma.push_back(at_point.gamma);
  note_if_not_coercive(interface, communicator);
}

/// The penalty of the beginning of a step may be far too small at its end, where a conductivity k(T) has
/// grown by decades: then the form is not coercive, and Newton may find a spurious solution. The margin
/// of the report is that of the penalty that was used, with the eigenvalues of the solution.
template <int dim>
bool Penalty<dim>::update(const Interface<dim> &interface, const double t, const ValuesOf &values_of,
                          SideStates<dim> &sides, const MPI_Comm &communicator)
{
  const std::vector<AtPoint> used = points;
  freeze(interface, t, values_of, sides, communicator);
  const std::vector<AtPoint> solution_points = points;
  const PenaltyRange range_of_solution = present_range;
  points = used;
  present_range = {};
  const Pairing<dim> &pairing = interface.pairing();
  for (const auto &group : pairing.groups)
    for (unsigned int q = group.begin; q < group.end; ++q)
      for (unsigned int f = 0; f < interface.fields.size(); ++f)
        note_margin(f, group, points[f * pairing.n_points() + q], 1.);
  bool is_outdated = false;
  for (unsigned int f = 0; f < interface.fields.size(); ++f) {
    const Change change = change_to(solution_points, interface, f, communicator);
    const bool needs_bound = !may_turn_skew(interface, interface.fields[f]);
    is_outdated = is_outdated || change.growth > (needs_bound ? largest_growth : largest_mean_growth) ||
                  change.decrease > largest_decrease ||
                  (needs_bound && present_range.coercivity_margin < 0 && change.growth > small_growth);
  }
  if (dealii::Utilities::MPI::max(static_cast<int>(is_outdated), communicator) == 0)
    return false;
  points = solution_points;
  present_range = range_of_solution;
  return true;
}

/// At a point of this rank, and of the mean over all points where a form that may turn skew-symmetric asks
/// for no bound at any point.
template <int dim>
typename Penalty<dim>::Change
Penalty<dim>::change_to(const std::vector<AtPoint> &solution_points, const Interface<dim> &interface,
                        const unsigned int field_index, const MPI_Comm &communicator) const
{
  const unsigned int n_points = interface.pairing().n_points(), begin = field_index * n_points;
  Change change;
  double sum = 0, sum_of_solution = 0;
  for (unsigned int i = begin; i < begin + n_points; ++i) {
    change.growth = std::max(change.growth, solution_points[i].gamma / points[i].gamma);
    change.decrease = std::max(change.decrease, points[i].gamma / solution_points[i].gamma);
    sum += points[i].gamma;
    sum_of_solution += solution_points[i].gamma;
  }
  if (!may_turn_skew(interface, interface.fields[field_index]))
    return change;
  sum = dealii::Utilities::MPI::sum(sum, communicator);
  sum_of_solution = dealii::Utilities::MPI::sum(sum_of_solution, communicator);
  if (sum > 0)
    change = {sum_of_solution / sum, sum / sum_of_solution};
  return change;
}

template <int dim>
void Penalty<dim>::begin_prediction(const Interface<dim> &interface)
{
  before_prediction = points;
  for (unsigned int f = 0; f < interface.fields.size(); ++f)
    if (has_large_strain(interface, interface.fields[f]))
      for (unsigned int q = 0; q < interface.pairing().n_points(); ++q)
        points[f * interface.pairing().n_points() + q].weight = {{0, 0}};
}

/// A conductivity is positive in every state. The tangent of a solid at large strain is not: then no penalty
/// makes theta = 1 coercive.
template <int dim>
bool Penalty<dim>::may_turn_skew(const Interface<dim> &interface, const TiedField &field) const
{
  return theta > 0 && has_large_strain(interface, field) && !lambda.empty();
}

template <int dim>
void Penalty<dim>::note_bound(const unsigned int field_index, const typename Pairing<dim>::Group &group,
                              AtPoint &chosen) const
{
  for (const unsigned int side : {source, destination})
    if (const double w = chosen.weight[side]; w != 0)
      chosen.bound[side] =
          (1 + theta) * (1 + theta) / 4 * w * w * lambda[field_index].tangent_values[side][group.cells[side]];
  chosen.stiffness = {{0, 0}};
  chosen.is_skew = chosen.gamma < chosen.bound[source] + chosen.bound[destination];
}

/// The least penalty grows with the stiffness at the point.
template <int dim>
double Penalty<dim>::theta_at(const Interface<dim> &interface, const TiedField &field, const unsigned int q,
                              const SideStates<dim> &sides, const unsigned int i)
{
  if (!may_turn_skew(interface, field))
    return theta;
  AtPoint &p = points[i];
  double least = 0;
  for (const unsigned int side : {source, destination}) {
    if (p.bound[side] == 0 || p.is_skew)
      continue;
    const double now = sides.normal_stiffness(interface, field, side, q);
    if (p.stiffness[side] == 0)
      p.stiffness[side] = now;
    least += p.bound[side] * now / p.stiffness[side];
  }
  p.is_skew = p.is_skew || p.gamma < least;
  return p.is_skew ? -1 : theta;
}

/// Each point has the range of this rank, too: over all points that is the range of all ranks.
template <int dim>
std::vector<double> Penalty<dim>::pack(const unsigned int n_points) const
{
  std::vector<double> numbers;
  for (unsigned int q = 0; q < n_points; ++q) {
    numbers.insert(numbers.end(),
                   {present_range.smallest, present_range.largest, present_range.coercivity_margin});
    for (unsigned int i = q; i < points.size(); i += n_points) { // the fields
      const AtPoint &at = points[i];
      numbers.insert(numbers.end(), {first_gamma[i], at.gamma, at.weight[0], at.weight[1], at.bound[0],
                                     at.bound[1], at.stiffness[0], at.stiffness[1], at.is_skew ? 1. : 0.});
    }
  }
  return numbers;
}

template <int dim>
void Penalty<dim>::unpack(const unsigned int n_points, const std::vector<double> &numbers)
{
  const unsigned int size_of_range = 3, size = 9;
  points.resize((numbers.size() - size_of_range * n_points) / size);
  first_gamma.resize(points.size());
  present_range = {};
  const double *n = numbers.data();
  for (unsigned int q = 0; q < n_points; ++q) {
    present_range.smallest = std::min(present_range.smallest, n[0]);
    present_range.largest = std::max(present_range.largest, n[1]);
    present_range.coercivity_margin = std::min(present_range.coercivity_margin, n[2]);
    n += size_of_range;
    for (unsigned int i = q; i < points.size(); i += n_points, n += size) {
      first_gamma[i] = n[0];
      points[i] = {{{n[2], n[3]}}, n[1], {{n[4], n[5]}}, {{n[6], n[7]}}, n[8] != 0};
    }
  }
}

template <int dim>
bool Penalty<dim>::is_skew_somewhere() const
{
  return std::any_of(points.begin(), points.end(), [](const AtPoint &p) { return p.is_skew; });
}

/// gamma > (1+theta)^2/4 (w_src^2 L_src + w_dst^2 L_dst) makes the form coercive, with a joint, too; with the
/// eigenvalues of the tangent in the matrix, infinite where that is not positive on a cell.
template <int dim>
void Penalty<dim>::note_margin(const unsigned int field_index, const typename Pairing<dim>::Group &group,
                               const AtPoint &chosen, const double unit)
{
  present_range.smallest = std::min(present_range.smallest, chosen.gamma);
  present_range.largest = std::max(present_range.largest, chosen.gamma);
  if (lambda.empty())
    return;
  double symmetric_part = 0;
  for (const unsigned int side : {source, destination})
    if (const double w = chosen.weight[side]; w != 0)
      symmetric_part += w * w * lambda[field_index].tangent_values[side][group.cells[side]];
  if (symmetric_part > 0)
    excess = std::max(excess, chosen.gamma / symmetric_part);
  const double bound = (1 + theta) * (1 + theta) / 4 * symmetric_part;
  if (!(bound > 0) || chosen.is_skew)
    return;
  present_range.coercivity_margin = std::min(present_range.coercivity_margin, chosen.gamma / bound - 1);
  if (std::isfinite(bound))
    least_multiplier = std::max(least_multiplier, rule == Rule::value ? bound : bound / unit);
}

template <int dim>
void Penalty<dim>::note_if_not_coercive(const Interface<dim> &interface, const MPI_Comm &communicator)
{
  if (has_warned || lambda.empty())
    return;
  const double margin = dealii::Utilities::MPI::min(present_range.coercivity_margin, communicator);
  const double least = dealii::Utilities::MPI::max(least_multiplier, communicator);
  if (margin > -1e-12) // on the bound but for rounding
    return;
  has_warned = true;
  std::ostringstream message;
  message.precision(3);
  if (margin <= -1)
    message << "there are cells at the interface on which the tangent of a law is not positive, as in a body "
               "that is about to "
               "buckle: no penalty makes the tie coercive there. If the steps do not converge, make them "
               "smaller, or use Theta = "
               "-1 or a mortar.";
  else {
    message << "with Theta = " << theta << " its penalty is " << 1 + margin
            << " times the least one for which the tie is coercive. Set "
            << (rule == Rule::value ? "Value" : "Multiplier") << " = " << 2 * least << " (twice the least)";
    if (rule != Rule::value)
      message << " instead of " << multiplier_of(interface, interface.fields[0]);
    message << ", or Theta = -1, which needs none.";
  }
  all_notes.push_back(of_coercivity(message.str()));
}

/// Measured (prm/benchmarks/stability): ten times the automatic penalty costs a digit of the flux, a hundred
/// times the whole of it, with every theta.
template <int dim>
void Penalty<dim>::note_if_large(const MPI_Comm &communicator)
{
  const double largest_excess = 18;
  const double global_excess = dealii::Utilities::MPI::max(excess, communicator);
  if (has_automatic_multiplier || !all_notes.empty() || global_excess < largest_excess)
    return;
  std::ostringstream message;
  message.precision(2);
  message << "the penalty is " << global_excess
          << " times the least one: it locks the sides to each other, and the flux between them oscillates. "
          << (rule == Rule::value ? "Remove Penalty and Value" : "Remove Multiplier");
  all_notes.push_back(of_large_penalty(message.str()));
}

template class Penalty<2>;
template class Penalty<3>;

} // namespace dovetail
