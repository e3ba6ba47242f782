// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Nitsche's method for any conjugate pair of flux A and trace B (Nitsche 1971; Burman and Zunino 2006 for the
// weights; Annavarapu, Hautefeuille and Dolbow, CMAME 225-228, 2012, for the penalty `volume`):
//
//     R(delta) = int_Gamma  - {A}.delta[B]  - theta delta{A}.[B]  + gamma [B].delta[B]  dGamma
//
// with the signs of pairing.h; nitsche.h has the form with a joint in series.
//
// Own sides: each side's test functions are integrated on its own faces, so a constant flux becomes exactly
// its consistent nodal forces also with mapped points. The price is a matrix that is not symmetric.
//
//     subsection Interface seam
//       set Type        = Nitsche
//       set Source      = left : 1
//       set Destination = right : 0
//       set Theta       = 1
//     end

#include <dovetail/interface/nitsche.h>
#include <dovetail/interface/trace_eigenvalue.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/symmetric_tensor.h>
#include <deal.II/base/utilities.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <sstream>

namespace dovetail {

namespace {
constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

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
std::optional<double> Nitsche<dim>::read_multiplier(const Section &section, const PenaltyRule rule)
{
  if (rule == PenaltyRule::value && !section.documenting())
    return 1;
  const std::string text = section.read<std::string>("Multiplier", "automatic", multiplier_help);
  if (text == "automatic" || section.documenting())
    return {};
  section.check(Patterns::Double(0).match(text), "Multiplier",
                "is '" + text + "', but must be automatic or a number that is not negative.");
  return dealii::Utilities::string_to_double(text);
}

template <int dim>
Nitsche<dim>::Nitsche(const Section &section)
    : theta(section.read<double>("Theta", 1.,
                                 "1 symmetric, 0 nonsymmetric, -1 skew-symmetric; any number [-]")),
      weights(static_cast<Weights>(
          section.choose("Weights", {"eigenvalue", "volume", "equal", "source", "destination"}, 0,
                         "Weights of the two fluxes in their mean: by the trace eigenvalues of the cells, by "
                         "cell volume over "
                         "stiffness, one half each, or one side only [-]"))),
      penalty_rule(static_cast<PenaltyRule>(section.choose(
          "Penalty", {"eigenvalue", "volume", "value"}, 0,
          "eigenvalue: a L1 L2/(L1+L2) with the trace eigenvalues L of the cells, coercive for a > "
          "(1+Theta)^2/4; volume: c (G1+G2)/(V1/k1+V2/k2) with face areas G, cell volumes V and stiffnesses "
          "k "
          "(times p^2 for degree p); value: given [-]"))),
      given_multiplier(read_multiplier(section, penalty_rule)),
      is_automatic(penalty_rule == PenaltyRule::eigenvalue && !given_multiplier),
      multiplier(given_multiplier.value_or(is_automatic ? automatic_multiplier(theta) : 1.)),
      value(penalty_rule != PenaltyRule::value && !section.documenting()
                ? Expression()
                : section.require_expression("Value", {1},
                                             "The penalty gamma, with Penalty = value [Pa/m or W/(m^2 K)]"))
{
  const unsigned int integrate_on = section.choose(
      "Integrate on", {"source", "destination", "both", "own sides"}, 0,
      "Whose faces hold the points; both: with half the weight each; own sides: the test functions of each "
      "side on its own faces, patch-exact also with mapped points, but not symmetric [-]");
  sides_of_integration = {{integrate_on != 1, integrate_on != 0}};
  own_sides = integrate_on == 3;
}

template <int dim>
void Nitsche<dim>::set_fields(const Section &section, const std::vector<TiedField> &fields)
{
  if (penalty_rule != PenaltyRule::value)
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
void Nitsche<dim>::check_value(const Section &section, const double gamma)
{
  std::ostringstream number;
  number << gamma;
  section.check(gamma >= 0 && std::isfinite(gamma), "Value",
                "is " + number.str() + " on the interface, but a penalty must be finite and not negative.");
}

/// Where it depends on place or time, at all points.
template <int dim>
void Nitsche<dim>::check_value(const Interface<dim> &interface, const double t,
                               const MPI_Comm &communicator) const
{
  if (penalty_rule != PenaltyRule::value || (!value.depends_on_position() && !value.depends_on_time()))
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
  check_value(interface.section, is_number == 0 ? undefined : smallest < 0 ? smallest : largest);
}

/// Whether weights and penalty are the same in all steps.
template <int dim>
bool Nitsche<dim>::has_constant_penalty(const Interface<dim> &interface) const
{
  return interface.has_constant_fluxes() && (penalty_rule != PenaltyRule::value || !value.depends_on_time());
}

/// For weights, penalty and the coercivity margin, which is infinite for theta = -1.
template <int dim>
bool Nitsche<dim>::needs_eigenvalues() const
{
  return weights == Weights::eigenvalue || penalty_rule == PenaltyRule::eigenvalue || theta != -1.;
}

template <int dim>
std::string Nitsche<dim>::description() const
{
  const std::array<const char *, 5> weights_by = {
      {"by eigenvalue", "by volume", "equal", "all on the source", "all on the destination"}};
  const std::array<const char *, 3> penalty_by = {{"by eigenvalue", "by volume", "given"}};
  const std::string weight = weights_by[static_cast<int>(weights)],
                    penalty = penalty_by[static_cast<int>(penalty_rule)];
  std::ostringstream words;
  words << "Theta = " << theta << ", "
        << (weight == penalty ? "weights and penalty " + penalty
                              : "weights " + weight + ", penalty " + penalty)
        << (own_sides ? ", each side's test functions on it" : "");
  return words.str();
}

template <int dim>
std::vector<std::string> Nitsche<dim>::left_out(const Interface<dim> &interface) const
{
  std::vector<std::string> sentences;
  if (theta == 0)
    sentences.push_back("derivative of the mean flux on " + interface.name + ": Theta = 0");
  else if (interface.is_linear())
    sentences.push_back("second derivatives of the laws on " + interface.name + ": they are linear");
  if (!needs_eigenvalues())
    sentences.push_back("trace eigenvalues on " + interface.name +
                        ": neither weights nor penalty ask for them, and Theta = -1 has no bound");
  return sentences;
}

template <int dim>
void Nitsche<dim>::find_eigenvalues(const Interface<dim> &interface, const double t,
                                    const typename Tie<dim>::Unknowns &values_of,
                                    const MPI_Comm &communicator)
{
  if (!needs_eigenvalues())
    return;
  lambda.resize(interface.fields.size());
  for (unsigned int f = 0; f < interface.fields.size(); ++f)
    lambda[f] = trace_eigenvalues(interface, interface.fields[f], t, values_of, communicator);
}

/// The responses of both sides at a point, with derivatives; NaN if not defined.
template <int dim>
void Nitsche<dim>::evaluate_stiffness(const Interface<dim> &interface,
                                      const typename Pairing<dim>::Group &group, const unsigned int q,
                                      const double t, const std::vector<double> &unknowns)
{
  for (const unsigned int side : {source, destination})
    if (!sides.evaluate(interface, group, side, q, t, unknowns, true)) {
      const Material<dim> &material = interface.sides[side].domain->material;
      const unsigned int n = material.n_components();
      for (unsigned int c = 0; c < n; ++c) // the others are not touched by the next evaluation
        for (unsigned int d = 0; d < n; ++d)
          if (material.coupling(c, d).of_flux())
            sides.response[side].by_gradient[c * n + d][0][0] = undefined;
    }
}

/// Largest eigenvalue of N.(dA/dgrad B).N, the acoustic tensor of a solid, the conductivity k_N of a scalar.
template <int dim>
double Nitsche<dim>::stiffness(const Interface<dim> &interface, const TiedField &field,
                               const unsigned int side, const dealii::Tensor<1, dim> &N) const
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
  return dealii::eigenvalues(acoustic)[0];
}

/// @return the penalty per unit of the multiplier.
template <int dim>
double Nitsche<dim>::choose(const Interface<dim> &interface, const unsigned int field_index,
                            const typename Pairing<dim>::Group &group, const unsigned int q, const double t,
                            Parameters &chosen) const
{
  const TiedField &field = interface.fields[field_index];
  std::array<double, 2> compliance = {{0, 0}}, area = {{0, 0}}, of_cell = {{0, 0}};
  for (const unsigned int side : {source, destination}) {
    if (!lambda.empty())
      of_cell[side] = lambda[field_index].of_penalty[side][group.cells[side]];
    if (weights != Weights::volume && penalty_rule != PenaltyRule::volume)
      continue;
    // V_i / (p_i^2 k_i): for a scalar the inverse of the trace constant is V_i / (p_i^2 k_i G_i)
    const CellBehind<dim> &cell = interface.pairing().cells[side][group.cells[side]];
    const double k = stiffness(interface, field, side, interface.pairing().N(side, q));
    const double p = interface.sides[side].domain->degree;
    compliance[side] = cell.cell_measure / (p * p * k);
    area[side] = cell.face_measure;
  }
  const double sum_of_lambdas = of_cell[source] + of_cell[destination];
  const double sum = compliance[source] + compliance[destination];

  switch (weights) {
  case Weights::eigenvalue: // a face that is hardly touched has no eigenvalue
    for (const unsigned int side : {source, destination})
      chosen.weight[side] = sum_of_lambdas != 0 ? of_cell[1 - side] / sum_of_lambdas : 0.5;
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
  switch (penalty_rule) {
  case PenaltyRule::eigenvalue:
    unit = sum_of_lambdas != 0 ? of_cell[source] * (of_cell[destination] / sum_of_lambdas) : 0;
    break;
  case PenaltyRule::volume:
    unit = (area[source] + area[destination]) / sum;
    break;
  case PenaltyRule::value:
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
double Nitsche<dim>::multiplier_of(const Interface<dim> &interface, const TiedField &field) const
{
  if (!is_automatic || !has_large_strain(interface, field))
    return multiplier;
  const bool has_degree_1 =
      interface.sides[source].domain->degree == 1 || interface.sides[destination].domain->degree == 1;
  return (has_degree_1 ? 5 : 2) * multiplier;
}

/// A conductivity is positive in every state. The tangent of a solid at large strain is not: then no penalty
/// makes theta = 1 coercive.
template <int dim>
bool Nitsche<dim>::may_turn_skew(const Interface<dim> &interface, const TiedField &field) const
{
  return theta > 0 && has_large_strain(interface, field) && !lambda.empty();
}

template <int dim>
void Nitsche<dim>::note_bound(const unsigned int field_index, const typename Pairing<dim>::Group &group,
                              Parameters &chosen) const
{
  for (const unsigned int side : {source, destination})
    if (const double w = chosen.weight[side]; w != 0)
      chosen.bound[side] =
          (1 + theta) * (1 + theta) / 4 * w * w * lambda[field_index].of_tangent[side][group.cells[side]];
  chosen.stiffness = {{0, 0}};
  chosen.is_skew = chosen.gamma < chosen.bound[source] + chosen.bound[destination];
}

/// The least penalty grows with the stiffness at the point.
template <int dim>
double Nitsche<dim>::theta_at(const Interface<dim> &interface, const TiedField &field, const unsigned int q,
                              Parameters &p) const
{
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

/// gamma > (1+theta)^2/4 (w_src^2 L_src + w_dst^2 L_dst) makes the form coercive, with a joint, too; with the
/// eigenvalues of the tangent in the matrix, infinite where that is not positive on a cell.
template <int dim>
void Nitsche<dim>::note_margin(const unsigned int field_index, const typename Pairing<dim>::Group &group,
                               const Parameters &chosen, const double unit)
{
  range.smallest = std::min(range.smallest, chosen.gamma);
  range.largest = std::max(range.largest, chosen.gamma);
  if (lambda.empty())
    return;
  double of_symmetric = 0;
  for (const unsigned int side : {source, destination})
    if (const double w = chosen.weight[side]; w != 0)
      of_symmetric += w * w * lambda[field_index].of_tangent[side][group.cells[side]];
  if (of_symmetric > 0)
    excess = std::max(excess, chosen.gamma / of_symmetric);
  const double bound = (1 + theta) * (1 + theta) / 4 * of_symmetric;
  if (!(bound > 0) || chosen.is_skew)
    return;
  range.coercivity_margin = std::min(range.coercivity_margin, chosen.gamma / bound - 1);
  if (std::isfinite(bound))
    least_multiplier = std::max(least_multiplier, penalty_rule == PenaltyRule::value ? bound : bound / unit);
}

template <int dim>
void Nitsche<dim>::warn_if_not_coercive(const Interface<dim> &interface, const MPI_Comm &communicator)
{
  if (has_warned || lambda.empty())
    return;
  const double margin = dealii::Utilities::MPI::min(range.coercivity_margin, communicator);
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
            << (penalty_rule == PenaltyRule::value ? "Value" : "Multiplier") << " = " << 2 * least
            << " (twice the least)";
    if (penalty_rule != PenaltyRule::value)
      message << " instead of " << multiplier_of(interface, interface.fields[0]);
    message << ", or Theta = -1, which needs none.";
  }
  sentences.push_back(message.str());
  if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
    std::cerr << "Warning: interface " << interface.name << ": " << message.str() << std::endl;
}

/// Measured (prm/benchmarks/stability): ten times the automatic penalty costs a digit of the flux, a hundred
/// times the whole of it, with every theta.
template <int dim>
void Nitsche<dim>::note_large_penalty(const MPI_Comm &communicator)
{
  const double largest_excess = 18;
  const double of_all = dealii::Utilities::MPI::max(excess, communicator);
  if (is_automatic || has_joint() || !sentences.empty() || of_all < largest_excess)
    return;
  std::ostringstream message;
  message.precision(2);
  message << "the penalty is " << of_all
          << " times the least one: it locks the sides to each other, and the flux between them oscillates. "
          << (penalty_rule == PenaltyRule::value ? "Remove Penalty and Value" : "Remove Multiplier");
  sentences.push_back(message.str());
}

template <int dim>
void Nitsche<dim>::note_central_gradients(const MPI_Comm &communicator)
{
  if (has_noted_centres)
    return;
  const unsigned int n = dealii::Utilities::MPI::sum(sides.n_central(), communicator);
  if (n == 0)
    return;
  has_noted_centres = true;
  sentences.push_back(
      "at " + std::to_string(n) +
      " of its points a law is not defined on the face or soon will not be, as beside corners "
      "where cells turn over: the flux at the centre of the cell takes its place there, and "
      "ten times the penalty. Refine the mesh there, and see what changes.");
}

template <int dim>
void Nitsche<dim>::begin_step(const Interface<dim> &interface, const double t,
                              const typename Tie<dim>::Unknowns &values_of, const MPI_Comm &communicator)
{
  freeze(interface, t, values_of, communicator);
  may_predict = is_automatic && has_large_strain(interface);
  is_predicting = false;
  if (may_predict)
    change.start(interface, values_of);
}

/// The first update of a step moves the bodies along straight lines. If it moves them far, the fluxes there
/// say little and the frozen penalty does not bound their tangents. Until the updates are small the penalty
/// joins the sides alone: its form is positive in every state, and asks no law at the interface.
template <int dim>
bool Nitsche<dim>::adapt(const Interface<dim> &interface, const double t,
                         const typename Tie<dim>::Unknowns &values_of, const MPI_Comm &communicator)
{
  if (!may_predict && !is_predicting)
    return false;
  const double update = change.advance(interface, values_of, communicator);
  if (is_predicting) {
    if (update < small_update)
      end_prediction(interface, t, values_of, communicator);
    return !is_predicting;
  }
  may_predict = false;
  is_predicting = update > large_update;
  if (!is_predicting)
    return false;
  before_prediction = parameters;
  for (unsigned int f = 0; f < interface.fields.size(); ++f)
    if (has_large_strain(interface, interface.fields[f]))
      for (unsigned int q = 0; q < interface.pairing().n_points(); ++q)
        parameters[f * interface.pairing().n_points() + q].weight = {{0, 0}};
  return true;
}

template <int dim>
void Nitsche<dim>::end_prediction(const Interface<dim> &interface, const double t,
                                  const typename Tie<dim>::Unknowns &values_of, const MPI_Comm &communicator)
{
  is_predicting = false;
  parameters = before_prediction; // which stay where no better ones are found
  freeze(interface, t, values_of, communicator);
}

template <int dim>
void Nitsche<dim>::freeze(const Interface<dim> &interface, const double t,
                          const typename Tie<dim>::Unknowns &values_of, const MPI_Comm &communicator)
{
  if (has_begun && has_constant_penalty(interface))
    return;
  check_value(interface, t, communicator);
  has_begun = true;
  sides.begin_step(interface, t, values_of);
  note_central_gradients(communicator);
  find_eigenvalues(interface, t, values_of, communicator);

  const Pairing<dim> &pairing = interface.pairing();
  const bool needs_stiffness = weights == Weights::volume || penalty_rule == PenaltyRule::volume;
  const std::vector<Parameters> old = parameters;
  parameters.resize(pairing.n_points() * interface.fields.size());
  range = {};
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
        evaluate_stiffness(interface, group, q, t, unknowns);
      for (unsigned int f = 0; f < interface.fields.size(); ++f) {
        const unsigned int i = f * pairing.n_points() + q;
        Parameters chosen;
        const double unit = choose(interface, f, group, q, t, chosen);
        // a tangent that has lost its positivity says nothing about the stiffness: keep the last good one
        const bool is_good = chosen.gamma >= 0 && std::isfinite(chosen.gamma) && chosen.weight[source] >= 0 &&
                             chosen.weight[destination] >= 0;
        parameters[i] = is_good ? chosen : old.empty() ? Parameters{{{0.5, 0.5}}, undefined} : old[i];
        if (!first_gamma.empty() && penalty_rule != PenaltyRule::value &&
            interface.fields[f].n_components > 1) // a conductivity is positive, whatever it was
          parameters[i].gamma = std::max(parameters[i].gamma, first_gamma[i]);
        if (may_turn_skew(interface, interface.fields[f]))
          note_bound(f, group, parameters[i]);
        note_margin(f, group, parameters[i], unit);
      }
    }
  }
  if (first_gamma.empty())
    for (const Parameters &of_point : parameters)
      first_gamma.push_back(of_point.gamma);
  warn_if_not_coercive(interface, communicator);
  note_large_penalty(communicator);
}

/// The penalty of the beginning of a step may be far too small at its end, where a conductivity k(T) has
/// grown by decades: then the form is not coercive, and Newton may find a solution that is none. The margin
/// of the report is that of the penalty that was used, with the eigenvalues of the solution.
template <int dim>
bool Nitsche<dim>::refreeze(const Interface<dim> &interface, const double t,
                            const typename Tie<dim>::Unknowns &values_of, const MPI_Comm &communicator)
{
  if (has_constant_penalty(interface))
    return false;
  if (is_predicting) {
    end_prediction(interface, t, values_of, communicator);
    return true;
  }
  std::vector<Parameters> used = parameters;
  SideStates<dim> used_sides = sides;
  freeze(interface, t, values_of, communicator);
  std::swap(parameters, used);
  std::swap(sides, used_sides);
  const std::vector<Parameters> &of_solution = used;
  const auto range_of_solution = range;
  range = {};
  const Pairing<dim> &pairing = interface.pairing();
  for (const auto &group : pairing.groups)
    for (unsigned int q = group.begin; q < group.end; ++q)
      for (unsigned int f = 0; f < interface.fields.size(); ++f)
        note_margin(f, group, parameters[f * pairing.n_points() + q], 1.);
  bool is_outdated = false;
  for (unsigned int f = 0; f < interface.fields.size(); ++f) {
    const Change change = change_to(of_solution, interface, f, communicator);
    const bool needs_bound = !may_turn_skew(interface, interface.fields[f]);
    is_outdated = is_outdated || change.growth > (needs_bound ? largest_growth : largest_mean_growth) ||
                  change.decrease > largest_decrease ||
                  (needs_bound && range.coercivity_margin < 0 && change.growth > small_growth);
  }
  if (dealii::Utilities::MPI::max(static_cast<int>(is_outdated), communicator) == 0)
    return false;
  parameters = of_solution;
  sides = used_sides;
  range = range_of_solution;
  return true;
}

/// At a point of this rank, and of the mean over all points where a form that may turn skew-symmetric asks
/// for no bound at any point.
template <int dim>
typename Nitsche<dim>::Change
Nitsche<dim>::change_to(const std::vector<Parameters> &of_solution, const Interface<dim> &interface,
                        const unsigned int field_index, const MPI_Comm &communicator) const
{
  const unsigned int n_points = interface.pairing().n_points(), begin = field_index * n_points;
  Change change;
  double sum = 0, sum_of_solution = 0;
  for (unsigned int i = begin; i < begin + n_points; ++i) {
    change.growth = std::max(change.growth, of_solution[i].gamma / parameters[i].gamma);
    change.decrease = std::max(change.decrease, parameters[i].gamma / of_solution[i].gamma);
    sum += parameters[i].gamma;
    sum_of_solution += of_solution[i].gamma;
  }
  if (!may_turn_skew(interface, interface.fields[field_index]))
    return change;
  sum = dealii::Utilities::MPI::sum(sum, communicator);
  sum_of_solution = dealii::Utilities::MPI::sum(sum_of_solution, communicator);
  if (sum > 0)
    change = {sum_of_solution / sum, sum / sum_of_solution};
  return change;
}

/// a and b at a point.
template <int dim>
bool Nitsche<dim>::join(const Interface<dim> &interface, const TiedField &field, const unsigned int q,
                        const double gamma, const std::array<State<dim>, 2> &of_sides, Series &series) const
{
  if (!has_joint())
    return true;
  Joint joint;
  if (!find_joint(field, of_sides, joint))
    return false;
  series.is_rigid = false;
  const std::array<double, 2> h = {{joint.along_normal, joint.along_tangents}};
  for (const unsigned int i : {0, 1}) {
    series.b[i] = h[i] + gamma > 0 ? 1 / (h[i] + gamma) : 0;
    series.a[i] = std::isfinite(h[i]) ? h[i] * series.b[i] : 1;
  }
  if (field.n_components == 1) { // along N whatever N is
    series.N[0] = 1;
    series.b_by_mean = std::isfinite(h[0]) ? series.b[0] * series.b[0] * joint.derivative_by_mean : 0;
    return true;
  }
  series.N = interface.pairing().N(source, q) - interface.pairing().N(destination, q);
  series.N /= series.N.norm();
  return true;
}

/// s, what the source gets from the destination.
template <int dim>
void Nitsche<dim>::numerical_flux(const Interface<dim> &interface, const TiedField &field,
                                  const unsigned int q, const std::array<State<dim>, 2> &of_sides,
                                  const std::array<std::vector<double>, 2> &flux,
                                  const std::vector<double> &jump, std::vector<double> &result) const
{
  if (parameters.empty()) // the tie has not been active yet
    return Tie<dim>::numerical_flux(interface, field, q, of_sides, flux, jump, result);
  const Parameters &p = parameters[field.index * interface.pairing().n_points() + q];
  for (const unsigned int side : {source, destination})
    if (const auto known = central_flux.find(&p - parameters.data());
        p.weight[side] != 0 && sides.is_central(side, q) && known != central_flux.end()) {
      result = known->second; // that of the last assembly
      return;
    }
  Series series;
  const bool is_defined = join(interface, field, q, p.gamma, of_sides, series);
  std::array<double, dim> rigid;
  for (unsigned int c = 0; c < field.n_components; ++c)
    rigid[c] = is_defined ? p.weight[source] * flux[source][c] -
                                p.weight[destination] * flux[destination][c] - p.gamma * jump[c]
                          : std::numeric_limits<double>::quiet_NaN();
  for (unsigned int c = 0; c < field.n_components; ++c) {
    result[c] = series.is_rigid ? rigid[c] : 0;
    for (unsigned int d = 0; d < field.n_components && !series.is_rigid; ++d)
      result[c] += series.entry(series.a, c, d) * rigid[d];
  }
}

/// @return false where a law is not defined, or no penalty was found at the beginning of the step.
template <int dim>
bool Nitsche<dim>::evaluate_sides(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                                  const unsigned int q, const double t, const std::vector<double> &unknowns,
                                  const bool with_derivatives)
{
  for (const unsigned int side : {source, destination}) {
    bool is_weighted = false;
    for (unsigned int f = 0; f < interface.fields.size(); ++f) {
      const Parameters &p = parameters[f * interface.pairing().n_points() + q];
      if (std::isnan(p.gamma))
        return false;
      is_weighted = is_weighted || p.weight[side] != 0;
    }
    if (is_weighted) {
      if (!sides.evaluate(interface, group, side, q, t, unknowns, with_derivatives))
        return false;
    } else if (has_joint()) {
      sides.state[side].t = t;
      sides.reinit(side, q, unknowns);
    }
  }
  return true;
}

template <int dim>
bool Nitsche<dim>::assemble(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                            const double t, const std::vector<double> &unknowns,
                            std::vector<double> &residual, dealii::FullMatrix<double> *tangent)
{
  const bool with_derivatives = tangent != nullptr || theta != 0;
  for (unsigned int q = group.begin; q < group.end; ++q) {
    if (!evaluate_sides(interface, group, q, t, unknowns, with_derivatives))
      return false;
    for (unsigned int f = 0; f < interface.fields.size(); ++f)
      if (!add_field(interface, f, q, unknowns, residual, tangent))
        return false;
  }
  if (own_sides)
    keep_own_rows(interface, group, residual, tangent);
  return true;
}

/// The test functions of the side on whose faces the points lie, with the whole weight.
template <int dim>
void Nitsche<dim>::keep_own_rows(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                                 std::vector<double> &residual, dealii::FullMatrix<double> *tangent) const
{
  for (unsigned int i = 0; i < residual.size(); ++i) {
    const double factor = (i < interface.n_local(source)) == (group.side == source) ? 2 : 0;
    residual[i] *= factor;
    if (tangent != nullptr)
      for (unsigned int j = 0; j < residual.size(); ++j)
        (*tangent)(i, j) *= factor;
  }
}

template <int dim>
bool Nitsche<dim>::add_field(const Interface<dim> &interface, const unsigned int field_index,
                             const unsigned int q, const std::vector<double> &unknowns,
                             std::vector<double> &residual, dealii::FullMatrix<double> *tangent)
{
  const Pairing<dim> &pairing = interface.pairing();
  const TiedField &field = interface.fields[field_index];
  Parameters &p_at = parameters[field_index * pairing.n_points() + q];
  const unsigned int n_c = field.n_components, n_local = residual.size();
  theta_here = may_turn_skew(interface, field) ? theta_at(interface, field, q, p_at) : theta;
  Parameters p = p_at;
  bool is_central = false;
  for (const unsigned int side : {source, destination})
    is_central = is_central || (p.weight[side] != 0 && sides.is_central(side, q));
  if (is_central && has_large_strain(interface, field))
    p.gamma *= central_factor;

  Series series;
  if (!join(interface, field, q, p.gamma, sides.state, series))
    return false;
  interface.jump(field, q, unknowns, jump);
  mean_flux.assign(n_c, 0.);
  for (const unsigned int side : {source, destination})
    if (p.weight[side] != 0)
      for (unsigned int c = 0; c < n_c; ++c)
        mean_flux[c] += (side == source ? 1 : -1) * p.weight[side] *
                        (sides.response[side].flux[field.first_component[side] + c] * pairing.N(side, q));
  transmitted.assign(n_c, 0.);
  mismatch = series.is_rigid ? jump : transmitted;
  for (unsigned int c = 0; c < n_c; ++c) {
    if (series.is_rigid)
      transmitted[c] = mean_flux[c] - p.gamma * jump[c];
    else
      for (unsigned int d = 0; d < n_c; ++d) {
        const double a = series.entry(series.a, c, d);
        transmitted[c] += a * (mean_flux[d] - p.gamma * jump[d]);
        mismatch[c] += a * jump[d] + series.entry(series.b, c, d) * mean_flux[d];
      }
  }
  if (is_central)
    central_flux[&p_at - parameters.data()] = transmitted;
  if (tangent != nullptr || theta != 0)
    linearise_mean_flux(interface, field, p, q);

  find_jump_unknowns(interface, field, q);
  for (const InJump &row : in_jump)
    residual[row.i] -= pairing.weight(q) * row.test * transmitted[row.component];
  if (theta != 0)
    for (const unsigned int i : of_field)
      for (unsigned int c = 0; c < n_c; ++c)
        residual[i] -= theta_here * pairing.weight(q) * variation_of[c * n_local + i] * mismatch[c];
  if (tangent == nullptr)
    return true;
  add_tangent(interface, field, p, series, q, *tangent);
  if (theta != 0 && !interface.is_linear())
    add_curvature(interface, field, p, q, *tangent);
  return true;
}

/// d{A}_c/dx_i = +-w N.(dA_c/dgrad B_d . grad phi_a + dA_c/dB_d phi_a) for the unknown i = (side, d, a), and
/// delta{A}. A test function of a scalar varies the flux through its gradient only, so that a constant one
/// does not and the fluxes of both sides balance also for k(T); that of a vector by its value, too, which is
/// the strain around an axis.
template <int dim>
void Nitsche<dim>::linearise_mean_flux(const Interface<dim> &interface, const TiedField &field,
                                       const Parameters &p, const unsigned int q)
{
  const Pairing<dim> &pairing = interface.pairing();
  const unsigned int n_c = field.n_components;
  const unsigned int n_local = interface.n_local(source) + interface.n_local(destination);
  mean_flux_of.assign(n_c * n_local, 0.);
  if (theta != 0) {
    variation_of.assign(n_c * n_local, 0.);
    ++variations.first;
  }
  unsigned int i = 0;
  for (const unsigned int side : {source, destination}) {
    const Domain<dim> &domain = *interface.sides[side].domain;
    const unsigned int n = domain.n_components(), n_nodes = domain.n_nodes();
    const double factor = (side == source ? 1 : -1) * p.weight[side];
    if (factor == 0) {
      i += interface.n_local(side);
      continue;
    }
    const dealii::Tensor<1, dim> *gradients = sides.shape_gradients[side];
    const double *values = pairing.values(side, q);
    for (const unsigned int d : interface.components[side]) {
      for (unsigned int c = 0; c < n_c; ++c) {
        const unsigned int pair = (field.first_component[side] + c) * n + d;
        const dealii::Tensor<1, dim> by_gradient =
            factor * (pairing.N(side, q) * sides.response[side].by_gradient[pair]);
        const double by_value = factor * (pairing.N(side, q) * sides.response[side].by_value[pair]);
        double *mean = &mean_flux_of[c * n_local + i];
        for (unsigned int a = 0; a < n_nodes; ++a)
          mean[a] = by_gradient * gradients[a];
        const bool varies_by_value = field.varies_by_value(side, d);
        if (theta != 0 && !varies_by_value)
          std::copy(mean, mean + n_nodes, &variation_of[c * n_local + i]);
        if (by_value != 0)
          for (unsigned int a = 0; a < n_nodes; ++a)
            mean[a] += by_value * values[a];
        if (theta != 0 && varies_by_value)
          std::copy(mean, mean + n_nodes, &variation_of[c * n_local + i]);
      }
      i += n_nodes;
    }
  }
}

template <int dim>
void Nitsche<dim>::find_jump_unknowns(const Interface<dim> &interface, const TiedField &field,
                                      const unsigned int q)
{
  in_jump.clear();
  of_field.clear();
  unsigned int i = 0;
  for (const unsigned int side : {source, destination}) {
    const double sign = side == source ? 1 : -1;
    const unsigned int n_nodes = interface.sides[side].domain->n_nodes();
    const double *trial = interface.pairing().trial(side, q, field.index),
                 *test = interface.pairing().test(side, q, field.index);
    for (const unsigned int component : interface.components[side]) {
      const unsigned int c = component - field.first_component[side]; // wraps if not of this field
      for (unsigned int a = 0; a < n_nodes; ++a, ++i)
        if (c < field.n_components) {
          of_field.push_back(i);
          if (std::abs(trial[a]) > interface.least_in_jump || std::abs(test[a]) > interface.least_in_jump)
            in_jump.push_back({i, c, sign * trial[a], sign * test[a]});
        }
    }
  }
}

/// - ds.delta[B] - theta delta{A}.de
template <int dim>
void Nitsche<dim>::add_tangent(const Interface<dim> &interface, const TiedField &field, const Parameters &p,
                               const Series &series, const unsigned int q,
                               dealii::FullMatrix<double> &tangent)
{
  const double w = interface.pairing().weight(q);
  const unsigned int n_local = tangent.n(), n_c = field.n_components;
  if (!series.is_rigid) {
    transmitted_of.assign(n_c * n_local, 0.);
    for (unsigned int c = 0; c < n_c; ++c)
      for (unsigned int d = 0; d < n_c; ++d) {
        const double a = series.entry(series.a, c, d);
        for (unsigned int j = 0; j < n_local; ++j)
          transmitted_of[c * n_local + j] += a * mean_flux_of[d * n_local + j];
      }
  }
  for (const InJump &row : in_jump) {
    const double test = w * row.test;
    const double *of_row = &(series.is_rigid ? mean_flux_of : transmitted_of)[row.component * n_local];
    double *entries = &tangent(row.i, 0);
    for (unsigned int j = 0; j < n_local; ++j)
      entries[j] -= test * of_row[j];
    const double penalty = p.gamma * test;
    if (series.is_rigid) {
      for (const InJump &column : in_jump)
        if (column.component == row.component)
          entries[column.i] += penalty * column.trial;
    } else
      for (const InJump &column : in_jump)
        entries[column.i] += series.entry(series.a, row.component, column.component) * penalty * column.trial;
  }
  if (theta != 0)
    add_variation_rows(field, series, w, tangent);
  if (series.b_by_mean != 0)
    add_change_of_joint(interface, field, p, series, q, tangent);
}

/// - theta delta{A}.(a.d[B] + b.d{A})
template <int dim>
void Nitsche<dim>::add_variation_rows(const TiedField &field, const Series &series, const double weight,
                                      dealii::FullMatrix<double> &tangent) const
{
  const unsigned int n_local = tangent.n(), n_c = field.n_components;
  for (const unsigned int row : of_field) {
    std::array<double, dim> variation, of_jump;
    for (unsigned int c = 0; c < n_c; ++c)
      variation[c] = of_jump[c] = theta_here * weight * variation_of[c * n_local + row];
    double *entries = &tangent(row, 0);
    if (!series.is_rigid)
      for (unsigned int c = 0; c < n_c; ++c) {
        double of_flux = 0;
        of_jump[c] = 0;
        for (unsigned int d = 0; d < n_c; ++d) {
          of_jump[c] += series.entry(series.a, c, d) * variation[d];
          of_flux += series.entry(series.b, c, d) * variation[d];
        }
        const double *mean = &mean_flux_of[c * n_local];
        for (unsigned int j = 0; j < n_local; ++j)
          entries[j] -= of_flux * mean[j];
      }
    for (const InJump *column = in_jump.data(), *end = column + in_jump.size(); column != end;) {
      const unsigned int c = column->component;
      const double factor = of_jump[c];
      for (; column != end && column->component == c; ++column)
        entries[column->i] -= factor * column->trial;
    }
  }
}

/// Of a scalar, with h' = dh/dB and dB the mean of both sides': b^2 h' (gamma [B] - {A}) (gamma delta[B] -
/// theta delta{A}) dB.
template <int dim>
void Nitsche<dim>::add_change_of_joint(const Interface<dim> &interface, const TiedField &field,
                                       const Parameters &p, const Series &series, const unsigned int q,
                                       dealii::FullMatrix<double> &tangent) const
{
  const Pairing<dim> &pairing = interface.pairing();
  const double factor = pairing.weight(q) * series.b_by_mean * (p.gamma * jump[0] - mean_flux[0]) / 2;
  const auto add_row = [&](const unsigned int row, const double test) {
    unsigned int first = 0;
    for (const unsigned int side : {source, destination}) {
      const unsigned int n_nodes = interface.sides[side].domain->n_nodes();
      const unsigned int column = first + interface.position(side, field.first_component[side]) * n_nodes;
      for (unsigned int b = 0; b < n_nodes; ++b)
        tangent(row, column + b) += factor * test * pairing.values(side, q)[b];
      first += interface.n_local(side);
    }
  };
  for (const InJump &row : in_jump)
    add_row(row.i, p.gamma * row.test);
  if (theta != 0)
    for (const unsigned int row : of_field)
      add_row(row, -theta_here * variation_of[row]);
}

/// - theta e_c d2{A}_c(delta, d): the second derivative of the flux contracted with e.
template <int dim>
void Nitsche<dim>::add_curvature(const Interface<dim> &interface, const TiedField &field, const Parameters &p,
                                 const unsigned int q, dealii::FullMatrix<double> &tangent)
{
  const Pairing<dim> &pairing = interface.pairing();
  unsigned int first = 0;
  for (const unsigned int side : {source, destination}) {
    const Domain<dim> &domain = *interface.sides[side].domain;
    const unsigned int n = domain.n_components(), n_nodes = domain.n_nodes();
    const auto &components = interface.components[side];
    if (p.weight[side] != 0 && !domain.material.has_linear_flux(field.field[side])) {
      ++variations.second;
      contraction.assign(n, dealii::Tensor<1, dim>());
      for (unsigned int c = 0; c < field.n_components; ++c)
        contraction[field.first_component[side] + c] = -theta_here * (side == source ? 1 : -1) *
                                                       p.weight[side] * pairing.weight(q) * mismatch[c] *
                                                       pairing.N(side, q);
      dealii::FullMatrix<double> &H = second_derivative;
      domain.material.curvature(sides.state[side], contraction, H);

      const double *values = pairing.values(side, q);
      const dealii::Tensor<1, dim> *gradients = sides.shape_gradients[side];
      for (unsigned int k = 0; k < components.size(); ++k) {
        // delta{A} varies the tied field only
        if (components[k] - field.first_component[side] >= field.n_components)
          continue;
        const bool varies_by_value = field.varies_by_value(side, components[k]);
        for (unsigned int l = 0; l < components.size(); ++l)
          for (unsigned int a = 0; a < n_nodes; ++a) {
            const unsigned int row = components[k] * (1 + dim), column = components[l] * (1 + dim);
            dealii::Tensor<1, dim>
                g; // grad phi_a (and phi_a) times H, by gradient and by value of the column
            double v = varies_by_value ? values[a] * H(row, column) : 0;
            for (unsigned int L = 0; varies_by_value && L < dim; ++L)
              g[L] = values[a] * H(row, column + 1 + L);
            for (unsigned int J = 0; J < dim; ++J) {
              v += gradients[a][J] * H(row + 1 + J, column);
              for (unsigned int L = 0; L < dim; ++L)
                g[L] += gradients[a][J] * H(row + 1 + J, column + 1 + L);
            }
            double *entries = &tangent(first + k * n_nodes + a, first + l * n_nodes);
            for (unsigned int b = 0; b < n_nodes; ++b)
              entries[b] += g * gradients[b];
            for (unsigned int b = 0; v != 0 && b < n_nodes; ++b)
              entries[b] += v * values[b];
          }
      }
    }
    first += interface.n_local(side);
  }
}

template class Nitsche<2>;
template class Nitsche<3>;

namespace {

const bool registered =
    add_tie<Nitsche>("Nitsche", "Weak continuity by consistent flux terms and a penalty.");

} // namespace

} // namespace dovetail
