// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Nitsche's method for any conjugate pair of flux A and trace B (Nitsche 1971; Burman and Zunino 2006 for the
// weights; Annavarapu, Hautefeuille and Dolbow, CMAME 225-228, 2012, for the penalty `volume`):
//
//     R(delta) = int_Gamma  - {A}.delta[B]  - theta delta{A}.[B]  + gamma [B].delta[B]  dGamma
//
// with the signs of pairing.h. theta = 1 is symmetric, 0 nonsymmetric (delta{A} is never evaluated), -1
// skew-symmetric. The tangent is exact: for theta != 0 and a nonlinear law it holds the second derivative of
// A, contracted with the jump. Weights and penalty are frozen at the beginning of a step.
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

#include <dovetail/interface/trace_eigenvalue.h>

#include <deal.II/base/symmetric_tensor.h>
#include <deal.II/base/utilities.h>

#include <cmath>

namespace dovetail {

namespace {

/// Which of the two sides' fluxes enter {A}, and how much.
enum class Weights { eigenvalue, volume, equal, source, destination };
enum class PenaltyRule { eigenvalue, volume, value };

template <int dim>
class Nitsche : public Tie<dim>
{
public:
  explicit Nitsche(const Section &section);

  std::array<bool, 2> integrates_on() const override { return sides_of_integration; }
  bool adds_terms() const override { return true; }
  bool is_symmetric() const override { return theta == 1. && !own_sides; }
  bool is_balanced() const override { return !own_sides; }
  void begin_step(const Interface<dim> &interface, double t, const typename Tie<dim>::Unknowns &unknowns,
                  const MPI_Comm &communicator) override;
  bool assemble(const Interface<dim> &interface, const typename Pairing<dim>::Group &group, double t,
                const std::vector<double> &unknowns, std::vector<double> &residual,
                dealii::FullMatrix<double> *tangent) override;
  void numerical_flux(const Interface<dim> &interface, const TiedField &field, unsigned int q,
                      const std::array<std::vector<double>, 2> &flux, const std::vector<double> &jump,
                      std::vector<double> &result) const override;
  typename Tie<dim>::Penalty penalty() const override { return range; }

private:
  /// w_src, w_dst and gamma of a field at a point.
  struct Parameters
  {
    std::array<double, 2> weight = {{0, 0}};
    double gamma = 0;
  };

  void reserve(const Interface<dim> &interface);
  double stiffness(const Interface<dim> &interface, const TiedField &field, unsigned int side,
                   const dealii::Tensor<1, dim> &N) const;
  Parameters choose_parameters(const Interface<dim> &interface, unsigned int field_index,
                               const typename Pairing<dim>::Group &group, unsigned int q, double t);
  bool evaluate_sides(const Interface<dim> &interface, unsigned int q, double t,
                      const std::vector<double> &unknowns, bool with_derivatives);
  void add_field(const Interface<dim> &interface, unsigned int field_index, unsigned int q,
                 const std::vector<double> &unknowns, std::vector<double> &residual,
                 dealii::FullMatrix<double> *tangent);
  void keep_own_rows(const Interface<dim> &interface, const typename Pairing<dim>::Group &group,
                     std::vector<double> &residual, dealii::FullMatrix<double> *tangent) const;
  void linearise_mean_flux(const Interface<dim> &interface, const TiedField &field,
                           const Parameters &parameters, unsigned int q);
  void add_tangent(const Interface<dim> &interface, const TiedField &field, const Parameters &parameters,
                   unsigned int q, dealii::FullMatrix<double> &tangent) const;
  void add_curvature(const Interface<dim> &interface, const TiedField &field, const Parameters &parameters,
                     unsigned int q, dealii::FullMatrix<double> &tangent) const;

  const double theta;
  std::array<bool, 2> sides_of_integration;
  bool own_sides;
  const Weights weights;
  const PenaltyRule penalty_rule;
  const double multiplier;
  const Expression value;

  std::vector<Parameters> parameters;        ///< at field * n_points + point
  std::vector<double> first_gamma;           ///< of the first step, likewise
  static constexpr double least_share = 0.1; ///< of it that a softened material keeps
  bool has_begun = false;
  /// By field and side, of the cells behind the points; empty if neither weights nor penalty need them.
  std::vector<std::array<std::vector<double>, 2>> lambda;
  typename Tie<dim>::Penalty range;

  // at the current point: states and responses of the two sides, the jump, and the derivative of the mean
  // flux
  std::array<std::unique_ptr<State<dim>>, 2> state;
  std::array<std::unique_ptr<Response<dim>>, 2> response;
  std::vector<double> jump, mean_flux;
  std::vector<double> mean_flux_of; ///< d{A}_c / dx_i at c * n_local + i
  std::vector<double> variation_of; ///< delta{A}_c for the test function i, likewise
};

/// 1 with a given penalty.
double read_multiplier(const Section &section, const PenaltyRule rule)
{
  if (rule == PenaltyRule::value && !section.documenting())
    return 1;
  const std::string text = section.read<std::string>(
      "Multiplier", "automatic",
      "a or c: multiplies the penalty; automatic: 2 for eigenvalue, 1 for volume [-]");
  if (text == "automatic" || section.documenting())
    return rule == PenaltyRule::eigenvalue ? 2 : 1;
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
      multiplier(read_multiplier(section, penalty_rule)),
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
void Nitsche<dim>::reserve(const Interface<dim> &interface)
{
  if (state[source])
    return;
  for (const unsigned int side : {source, destination}) {
    const unsigned int n = interface.sides[side].domain->n_components();
    state[side] = std::make_unique<State<dim>>(n);
    response[side] = std::make_unique<Response<dim>>(n);
  }
}

/// Largest eigenvalue of N.(dA/dgrad B).N, the acoustic tensor of a solid, the conductivity k_N of a scalar.
template <int dim>
double Nitsche<dim>::stiffness(const Interface<dim> &interface, const TiedField &field,
                               const unsigned int side, const dealii::Tensor<1, dim> &N) const
{
  const unsigned int first = field.first_component[side], n = interface.sides[side].domain->n_components();
  const auto entry = [&](const unsigned int c, const unsigned int d) {
    return N * (response[side]->by_gradient[(first + c) * n + first + d] * N);
  };
  if (field.n_components == 1)
    return entry(0, 0);
  dealii::SymmetricTensor<2, dim> acoustic;
  for (unsigned int c = 0; c < dim; ++c)
    for (unsigned int d = c; d < dim; ++d)
      acoustic[c][d] = (entry(c, d) + entry(d, c)) / 2;
  return dealii::eigenvalues(acoustic)[0];
}

template <int dim>
typename Nitsche<dim>::Parameters Nitsche<dim>::choose_parameters(const Interface<dim> &interface,
                                                                  const unsigned int field_index,
                                                                  const typename Pairing<dim>::Group &group,
                                                                  const unsigned int q, const double t)
{
  const TiedField &field = interface.fields[field_index];
  // V_i / (p_i^2 k_i): for a scalar the inverse of the trace constant is V_i / (p_i^2 k_i G_i)
  std::array<double, 2> compliance, area, trace_constant;
  for (const unsigned int side : {source, destination}) {
    const CellBehind &cell = interface.pairing().cells[side][group.cells[side]];
    const double k = stiffness(interface, field, side, interface.pairing().N(side, q));
    const double p = interface.sides[side].domain->degree;
    compliance[side] = cell.cell_measure / (p * p * k);
    area[side] = cell.face_measure;
    const double constant = field.n_components == 1 ? p * p : (p + 1) * (p + 1);
    trace_constant[side] = lambda.empty() ? constant * k * cell.face_measure / cell.cell_measure
                                          : lambda[field_index][side][group.cells[side]];
  }
  const double sum_of_constants = trace_constant[source] + trace_constant[destination];
  const double sum = compliance[source] + compliance[destination];

  Parameters chosen;
  switch (weights) {
  case Weights::eigenvalue: // a face that is hardly touched has no eigenvalue
    for (const unsigned int side : {source, destination})
      chosen.weight[side] = sum_of_constants > 0 ? trace_constant[1 - side] / sum_of_constants : 0.5;
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
  switch (penalty_rule) {
  case PenaltyRule::eigenvalue:
    chosen.gamma = sum_of_constants > 0
                       ? multiplier * trace_constant[source] * trace_constant[destination] / sum_of_constants
                       : 0;
    break;
  case PenaltyRule::volume:
    chosen.gamma = multiplier * (area[source] + area[destination]) / sum;
    break;
  case PenaltyRule::value:
    chosen.gamma = value.value(interface.pairing().X(source, q), t);
    break;
  }

  const double bound =
      (1 + theta) * (1 + theta) / 4 *
      (chosen.weight[source] * chosen.weight[source] * trace_constant[source] +
       chosen.weight[destination] * chosen.weight[destination] * trace_constant[destination]);
  range.smallest = std::min(range.smallest, chosen.gamma);
  range.largest = std::max(range.largest, chosen.gamma);
  if (bound > 0)
    range.coercivity_margin = std::min(range.coercivity_margin, chosen.gamma / bound);
  return chosen;
}

template <int dim>
void Nitsche<dim>::begin_step(const Interface<dim> &interface, const double t,
                              const typename Tie<dim>::Unknowns &values_of, const MPI_Comm &communicator)
{
  const Pairing<dim> &pairing = interface.pairing();
  const bool is_constant =
      interface.is_linear() && (penalty_rule != PenaltyRule::value || !value.depends_on_time());
  if (is_constant && has_begun)
    return;
  has_begun = true;
  reserve(interface);
  if (weights == Weights::eigenvalue || penalty_rule == PenaltyRule::eigenvalue) {
    lambda.resize(interface.fields.size());
    for (unsigned int f = 0; f < interface.fields.size(); ++f)
      lambda[f] = trace_eigenvalues(interface, interface.fields[f], t, values_of, communicator);
  }
  const std::vector<Parameters> old = parameters;
  parameters.resize(pairing.n_points() * interface.fields.size());
  range = {};
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns;
  for (const auto &group : pairing.groups) {
    interface.group_dofs(group, dofs);
    values_of(dofs, unknowns);
    for (unsigned int q = group.begin; q < group.end; ++q) {
      bool is_defined = true;
      for (const unsigned int side : {source, destination}) {
        interface.evaluate(side, q, unknowns, *state[side]);
        state[side]->X = pairing.X(side, q);
        state[side]->t = t;
        is_defined = is_defined &&
                     interface.sides[side].domain->material.evaluate(*state[side], true, *response[side]);
      }
      for (unsigned int f = 0; f < interface.fields.size(); ++f) {
        const unsigned int i = f * pairing.n_points() + q;
        const Parameters chosen = choose_parameters(interface, f, group, q, t);
        // a tangent that has lost its positivity says nothing about the stiffness: keep the last good one
        const bool is_good = is_defined && chosen.gamma >= 0 && std::isfinite(chosen.gamma) &&
                             chosen.weight[source] >= 0 && chosen.weight[destination] >= 0;
        parameters[i] = is_good || old.empty() ? chosen : old[i];
        if (!first_gamma.empty() && penalty_rule != PenaltyRule::value)
          parameters[i].gamma = std::max(parameters[i].gamma, least_share * first_gamma[i]);
      }
    }
  }
  if (first_gamma.empty())
    for (const Parameters &of_point : parameters)
      first_gamma.push_back(of_point.gamma);
}

/// {A} - gamma [B]: what the source gets from the destination.
template <int dim>
void Nitsche<dim>::numerical_flux(const Interface<dim> &interface, const TiedField &field,
                                  const unsigned int q, const std::array<std::vector<double>, 2> &flux,
                                  const std::vector<double> &jump, std::vector<double> &result) const
{
  if (parameters.empty()) // the tie has not been active yet
    return Tie<dim>::numerical_flux(interface, field, q, flux, jump, result);
  const Parameters &p = parameters[(&field - interface.fields.data()) * interface.pairing().n_points() + q];
  for (unsigned int c = 0; c < field.n_components; ++c)
    result[c] =
        p.weight[source] * flux[source][c] - p.weight[destination] * flux[destination][c] - p.gamma * jump[c];
}

template <int dim>
bool Nitsche<dim>::evaluate_sides(const Interface<dim> &interface, const unsigned int q, const double t,
                                  const std::vector<double> &unknowns, const bool with_derivatives)
{
  for (const unsigned int side : {source, destination}) {
    bool is_weighted = false;
    for (unsigned int f = 0; f < interface.fields.size(); ++f)
      is_weighted = is_weighted || parameters[f * interface.pairing().n_points() + q].weight[side] != 0;
    if (!is_weighted)
      continue;
    interface.evaluate(side, q, unknowns, *state[side]);
    state[side]->X = interface.pairing().X(side, q);
    state[side]->t = t;
    if (!interface.sides[side].domain->material.evaluate(*state[side], with_derivatives, *response[side]))
      return false;
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
    if (!evaluate_sides(interface, q, t, unknowns, with_derivatives))
      return false;
    for (unsigned int f = 0; f < interface.fields.size(); ++f)
      add_field(interface, f, q, unknowns, residual, tangent);
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
void Nitsche<dim>::add_field(const Interface<dim> &interface, const unsigned int field_index,
                             const unsigned int q, const std::vector<double> &unknowns,
                             std::vector<double> &residual, dealii::FullMatrix<double> *tangent)
{
  const Pairing<dim> &pairing = interface.pairing();
  const TiedField &field = interface.fields[field_index];
  const Parameters &p = parameters[field_index * pairing.n_points() + q];
  const unsigned int n_c = field.n_components,
                     n_local = interface.n_local(source) + interface.n_local(destination);

  interface.jump(field, q, unknowns, jump);
  mean_flux.assign(n_c, 0.);
  for (const unsigned int side : {source, destination})
    if (p.weight[side] != 0)
      for (unsigned int c = 0; c < n_c; ++c)
        mean_flux[c] += (side == source ? 1 : -1) * p.weight[side] *
                        (response[side]->flux[field.first_component[side] + c] * pairing.N(side, q));
  if (tangent != nullptr || theta != 0)
    linearise_mean_flux(interface, field, p, q);

  unsigned int i = 0;
  for (const unsigned int side : {source, destination}) {
    const double sign = side == source ? 1 : -1;
    const unsigned int n_nodes = interface.sides[side].domain->n_nodes();
    const double *test = pairing.test(side, q);
    for (const unsigned int component : interface.components[side]) {
      const unsigned int c = component - field.first_component[side]; // wraps if not of this field
      for (unsigned int a = 0; a < n_nodes; ++a, ++i)
        if (c < n_c) {
          double R = sign * test[a] * (p.gamma * jump[c] - mean_flux[c]);
          if (theta != 0)
            for (unsigned int d = 0; d < n_c; ++d)
              R -= theta * variation_of[d * n_local + i] * jump[d];
          residual[i] += pairing.weight(q) * R;
        }
    }
  }
  if (tangent == nullptr)
    return;
  add_tangent(interface, field, p, q, *tangent);
  if (theta != 0 && !interface.is_linear())
    add_curvature(interface, field, p, q, *tangent);
}

/// d{A}_c/dx_i = +-w N.(dA_c/dgrad B_d . grad phi_a + dA_c/dB_d phi_a) for the unknown i = (side, d, a), and
/// the first term of it alone, delta{A}: a test function varies the flux through its gradient only, so that a
/// constant one does not and the fluxes of both sides balance also for k(T).
template <int dim>
void Nitsche<dim>::linearise_mean_flux(const Interface<dim> &interface, const TiedField &field,
                                       const Parameters &p, const unsigned int q)
{
  const Pairing<dim> &pairing = interface.pairing();
  const unsigned int n_c = field.n_components;
  const unsigned int n_local = interface.n_local(source) + interface.n_local(destination);
  mean_flux_of.assign(n_c * n_local, 0.);
  variation_of.assign(n_c * n_local, 0.);
  unsigned int i = 0;
  for (const unsigned int side : {source, destination}) {
    const Domain<dim> &domain = *interface.sides[side].domain;
    const unsigned int n = domain.n_components(), n_nodes = domain.n_nodes();
    const double factor = (side == source ? 1 : -1) * p.weight[side];
    if (factor == 0) {
      i += interface.n_local(side);
      continue;
    }
    for (const unsigned int d : interface.components[side]) {
      for (unsigned int c = 0; c < n_c; ++c) {
        const unsigned int pair = (field.first_component[side] + c) * n + d;
        const dealii::Tensor<1, dim> by_gradient =
            factor * (pairing.N(side, q) * response[side]->by_gradient[pair]);
        const double by_value = factor * (pairing.N(side, q) * response[side]->by_value[pair]);
        double *variation = &variation_of[c * n_local + i], *mean = &mean_flux_of[c * n_local + i];
        for (unsigned int a = 0; a < n_nodes; ++a) {
          variation[a] = by_gradient * pairing.gradients(side, q)[a];
          mean[a] = variation[a] + by_value * pairing.values(side, q)[a];
        }
      }
      i += n_nodes;
    }
  }
}

template <int dim>
void Nitsche<dim>::add_tangent(const Interface<dim> &interface, const TiedField &field, const Parameters &p,
                               const unsigned int q, dealii::FullMatrix<double> &tangent) const
{
  // the unknowns that enter the jump: index, component, signed trial and test value
  struct InJump
  {
    unsigned int i, c;
    double trial, test;
  };
  static thread_local std::vector<InJump> in_jump;
  static thread_local std::vector<unsigned int> of_field;
  in_jump.clear();
  of_field.clear();
  const Pairing<dim> &pairing = interface.pairing();
  const unsigned int n_c = field.n_components;
  unsigned int i = 0;
  for (const unsigned int side : {source, destination}) {
    const double sign = side == source ? 1 : -1;
    for (const unsigned int component : interface.components[side]) {
      const unsigned int c = component - field.first_component[side];
      for (unsigned int a = 0; a < interface.sides[side].domain->n_nodes(); ++a, ++i)
        if (c < n_c) {
          of_field.push_back(i);
          const double trial = pairing.trial(side, q)[a], test = pairing.test(side, q)[a];
          if (std::abs(trial) > 1e-14 || std::abs(test) > 1e-14)
            in_jump.push_back({i, c, sign * trial, sign * test});
        }
    }
  }

  const double w = pairing.weight(q);
  const unsigned int n_local = tangent.n();
  for (const InJump &row : in_jump) {
    const double test = w * row.test;
    const double *mean = &mean_flux_of[row.c * n_local];
    double *entries = &tangent(row.i, 0);
    for (unsigned int j = 0; j < n_local; ++j)
      entries[j] -= test * mean[j];
    for (const InJump &column : in_jump)
      if (column.c == row.c)
        entries[column.i] += p.gamma * test * column.trial;
  }
  if (theta != 0)
    for (const unsigned int row : of_field) {
      std::array<double, dim> mean;
      for (unsigned int c = 0; c < n_c; ++c)
        mean[c] = theta * w * variation_of[c * n_local + row];
      double *entries = &tangent(row, 0);
      for (const InJump &column : in_jump)
        entries[column.i] -= mean[column.c] * column.trial;
    }
}

/// - theta [B]_c d2{A}_c(delta, d): the second derivative of the flux contracted with the jump.
template <int dim>
void Nitsche<dim>::add_curvature(const Interface<dim> &interface, const TiedField &field, const Parameters &p,
                                 const unsigned int q, dealii::FullMatrix<double> &tangent) const
{
  const Pairing<dim> &pairing = interface.pairing();
  unsigned int first = 0;
  for (const unsigned int side : {source, destination}) {
    const Domain<dim> &domain = *interface.sides[side].domain;
    const unsigned int n = domain.n_components(), n_nodes = domain.n_nodes();
    const auto &components = interface.components[side];
    if (p.weight[side] != 0 && !domain.material.is_linear(field.field[side])) {
      std::vector<dealii::Tensor<1, dim>> contraction(n);
      for (unsigned int c = 0; c < field.n_components; ++c)
        contraction[field.first_component[side] + c] = -theta * (side == source ? 1 : -1) * p.weight[side] *
                                                       pairing.weight(q) * jump[c] * pairing.N(side, q);
      dealii::FullMatrix<double> H(n * (1 + dim), n * (1 + dim));
      domain.material.curvature(*state[side], contraction, H);

      const double *values = pairing.values(side, q);
      const dealii::Tensor<1, dim> *gradients = pairing.gradients(side, q);
      for (unsigned int k = 0; k < components.size(); ++k) {
        // delta{A} varies the gradient of the tied field only
        if (components[k] - field.first_component[side] >= field.n_components)
          continue;
        for (unsigned int l = 0; l < components.size(); ++l)
          for (unsigned int a = 0; a < n_nodes; ++a) {
            const unsigned int row = components[k] * (1 + dim), column = components[l] * (1 + dim);
            dealii::Tensor<1, dim> g; // grad phi_a times H, by gradient and by value of the column
            double v = 0;
            for (unsigned int J = 0; J < dim; ++J) {
              v += gradients[a][J] * H(row + 1 + J, column);
              for (unsigned int L = 0; L < dim; ++L)
                g[L] += gradients[a][J] * H(row + 1 + J, column + 1 + L);
            }
            for (unsigned int b = 0; b < n_nodes; ++b)
              tangent(first + k * n_nodes + a, first + l * n_nodes + b) += g * gradients[b] + v * values[b];
          }
      }
    }
    first += interface.n_local(side);
  }
}

const bool registered =
    add_tie<Nitsche>("Nitsche", "Weak continuity by consistent flux terms and a penalty.");

} // namespace

} // namespace dovetail
