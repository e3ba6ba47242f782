// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/embedding.h>
#include <dovetail/material/hyperelastic_law.h>
#include <dovetail/material/solid_term.h>
#include <dovetail/scene/undefined.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace dovetail {

using dealii::Tensor;

namespace {

unsigned int n_numbers(const std::vector<InternalVariable> &variables)
{
  unsigned int n = 0;
  for (const InternalVariable &variable : variables)
    n += variable.n_components;
  return n;
}

} // namespace

template <int dim>
SolidTerm<dim>::SolidTerm(const Field &field, std::unique_ptr<SolidLaw> law,
                          const std::optional<Expansion> &expansion, const bool is_axisymmetric,
                          const std::string &name_of_material, const std::string &name_of_law,
                          const double density)
    : Term<dim>(field), density(density), law(std::move(law)), expansion(expansion),
      is_axisymmetric(is_axisymmetric), name_of_material(name_of_material), name_of_law(name_of_law),
      n_internal_variables(n_numbers(this->law->internal_variables()))
{
}

template <int dim>
Coupling SolidTerm<dim>::coupling(const unsigned int c, const unsigned int d) const
{
  const unsigned int own = d - this->field.first_component; // wraps if of another field
  Coupling result;
  result.flux_by_gradient = own < this->field.n_components;
  result.flux_by_value = expansion && d == expansion->temperature;
  if (is_axisymmetric) {
    const unsigned int radial = this->field.first_component;
    result.flux_by_value = result.flux_by_value || d == radial;
    result.source_by_gradient = c == radial && result.flux_by_gradient;
    result.source_by_value = c == radial && result.flux_by_value;
  }
  return result;
}

template <int dim>
SolidLaw::Place SolidTerm<dim>::place(const State<dim> &state) const
{
  return {state.memory.slice(this->first_internal_variable, n_internal_variables), embed(state.X), state.t};
}

/// H = grad u, and u_r/r around an axis.
template <int dim>
Tensor<2, 3> SolidTerm<dim>::displacement_gradient(const State<dim> &state) const
{
  Tensor<2, 3> H;
  for (unsigned int i = 0; i < dim; ++i)
    H[i] = embed(state.gradient[this->field.first_component + i]);
  if (is_axisymmetric) {
    const auto [by_value, by_gradient] = hoop(state);
    H[2][2] = by_value * state.value[this->field.first_component] + by_gradient * H[0][0];
  }
  return H;
}

template <int dim>
bool SolidTerm<dim>::add(const State<dim> &state, const bool with_derivatives, Response<dim> &response) const
{
  const unsigned int n = state.value.size(), first = this->field.first_component;
  thread_local SolidLaw::Response local; // its tensor of fourth order is not cleared where nobody asks for it
  static_cast<SolidLaw::Place &>(local) = place(state);
  const bool predicts = with_derivatives && state.linearised_at != nullptr && law->has_large_strain();
  const std::optional<Tensor<2, 3>> predicted = predicts ? predict_stress(state) : std::nullopt;
  local.P = 0;
  local.needs_dP_de = expansion.has_value();
  if (with_derivatives) {
    local.dP_dF = 0;
    local.dP_de = 0;
  }
  if (!law->evaluate(displacement_gradient(state), thermal_strain(state), with_derivatives, local)) {
    explain_undefined();
    return false;
  }
  if (predicted)
    take_stress(state, *predicted, local);
  for (unsigned int i = 0; i < dim; ++i) {
    response.flux[first + i] += restrict_to<dim>(local.P[i]);
    if (!with_derivatives)
      continue;
    for (unsigned int k = 0; k < dim; ++k) {
      Tensor<2, dim> &by_gradient = response.by_gradient[(first + i) * n + first + k];
      for (unsigned int J = 0; J < dim; ++J)
        for (unsigned int L = 0; L < dim; ++L)
          by_gradient[J][L] += local.dP_dF[i][J][k][L];
    }
    if (expansion)
      response.by_value[(first + i) * n + expansion->temperature] +=
          expansion->coefficient * restrict_to<dim>(local.dP_de[i]);
  }
  if (is_axisymmetric)
    add_hoop(state, with_derivatives, local, response);
  return true;
}

/// What the tangent at F0, which has led here, says of the stress S = F^-1 P: S* = S(F0) + C(F0) : sym(F0^T
/// dF), F0 (C : sym(F0^T dF)) = dP/dF(F0) : dF - dF S(F0). What a law remembers on trial is that of F0 then.
template <int dim>
std::optional<Tensor<2, 3>> SolidTerm<dim>::predict_stress(const State<dim> &state) const
{
  thread_local SolidLaw::Response before;
  static_cast<SolidLaw::Place &>(before) = place(state);
  before.P = 0;
  before.dP_dF = 0;
  before.needs_dP_de = false;
  const Tensor<2, 3> H_0 = displacement_gradient(*state.linearised_at),
                     dF = displacement_gradient(state) - H_0;
  if (!law->evaluate(H_0, thermal_strain(state), true, before))
    return {};
  const Tensor<2, 3> inverse = invert(Deformation(H_0).F), S_0 = inverse * before.P,
                     dP = dealii::double_contract<2, 0, 3, 1>(before.dP_dF, dF);
  return S_0 + inverse * (dP - dF * S_0);
}

/// S* in place of S in the part of dP/dF that S has, I x S. Where a slender body turns, S has strains of
/// second order in dF that the next update takes away.
template <int dim>
void SolidTerm<dim>::take_stress(const State<dim> &state, const Tensor<2, 3> &predicted,
                                 SolidLaw::Response &local) const
{
  const Tensor<2, 3> more = predicted - invert(Deformation(displacement_gradient(state)).F) * local.P;
  for (unsigned int J = 0; J < 3; ++J)
    for (unsigned int L = 0; L < 3; ++L)
      for (unsigned int i = 0; i < 3; ++i)
        local.dP_dF[i][J][i][L] += (more[J][L] + more[L][J]) / 2;
}

/// Whose law it is.
template <int dim>
void SolidTerm<dim>::explain_undefined() const
{
  std::string &reason = last_undefined().reason;
  reason = "material " + name_of_material + ", " + name_of_law + ": " + reason;
}

/// What the strain H_33 adds: the dependence of the flux on u_r, and the source P_33/r.
template <int dim>
void SolidTerm<dim>::add_hoop(const State<dim> &state, const bool with_derivatives,
                              const SolidLaw::Response &local, Response<dim> &response) const
{
  const unsigned int n = state.value.size(), first = this->field.first_component;
  const auto [by_value, by_gradient] = hoop(state);
  response.source[first] += by_value * local.P[2][2];
  if (!with_derivatives)
    return;
  for (unsigned int i = 0; i < dim; ++i) {
    Tensor<1, dim> D_33; // dP_iJ/dH_33
    for (unsigned int J = 0; J < dim; ++J)
      D_33[J] = local.dP_dF[i][J][2][2];
    const unsigned int pair = (first + i) * n + first;
    response.by_value[pair] += by_value * D_33;
    for (unsigned int J = 0; J < dim; ++J)
      response.by_gradient[pair][J][0] += by_gradient * D_33[J];
    response.source_by_gradient[first * n + first + i] += by_value * restrict_to<dim>(local.dP_dF[2][2][i]);
  }
  response.source_by_value[first * n + first] += by_value * by_value * local.dP_dF[2][2][2][2];
  if (expansion)
    response.source_by_value[first * n + expansion->temperature] +=
        by_value * expansion->coefficient * local.dP_de[2][2];
}

template <int dim>
void SolidTerm<dim>::add_curvature(const State<dim> &state, const std::vector<Tensor<1, dim>> &w,
                                   dealii::FullMatrix<double> &result) const
{
  const unsigned int first = this->field.first_component;
  Tensor<2, 3> w_3d;
  for (unsigned int i = 0; i < dim; ++i)
    w_3d[i] = embed(w[first + i]);
  const SolidLaw::Curvature local =
      law->curvature(displacement_gradient(state), thermal_strain(state), w_3d, place(state));
  struct Dependence // of H_iJ, its derivative by a row
  {
    unsigned int i, J, row;
    double derivative;
  };
  std::array<Dependence, dim * dim + 2> dependences{}; // the last two around an axis only
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int J = 0; J < dim; ++J)
      dependences[i * dim + J] = {i, J, this->gradient_row(first + i, J), 1};
  if (is_axisymmetric) {
    const auto [by_value, by_gradient] = hoop(state);
    dependences[dim * dim] = {2, 2, this->value_row(first), by_value};
    dependences[dim * dim + 1] = {2, 2, this->gradient_row(first, 0), by_gradient};
  }
  const unsigned int n = dim * dim + (is_axisymmetric ? 2 : 0);
  for (unsigned int p = 0; p < n; ++p) {
    const auto &[i, J, row, derivative] = dependences[p];
    for (unsigned int q = 0; q < n; ++q) {
      const auto &[k, L, column, other] = dependences[q];
      result(row, column) += derivative * other * local.FF[i][J][k][L];
    }
    if (expansion)
      this->add_symmetric(result, row, this->value_row(expansion->temperature),
                          derivative * expansion->coefficient * local.Fe[i][J]);
  }
  if (expansion) {
    const unsigned int row = this->value_row(expansion->temperature);
    result(row, row) += expansion->coefficient * expansion->coefficient * local.ee;
  }
}

namespace {

/// The work of flow in all three dimensions.
struct Flow
{
  double value = 0, by_strain = 0; ///< by the thermal strain
  Tensor<2, 3> by_F;
};

Tensor<2, 3> deviator(const Tensor<2, 3> &T)
{
  return T - trace(T) / 3 * Tensor<2, 3>(dealii::unit_symmetric_tensor<3>());
}

/// dW = (eps_p - eps_p,n - dev P/(2 mu)) : dP + dev P : d eps.
Flow flow_of_small_strains(const SolidLaw::Response &response, const double mu)
{
  const Tensor<2, 3> stress = deviator(response.P);
  Tensor<2, 3> flow;
  for (unsigned int i = 0; i < 9; ++i)
    flow[i / 3][i % 3] = response.memory.trial[i] - response.memory.accepted[i];
  const Tensor<2, 3> by_stress = flow - stress / (2 * mu);
  return {scalar_product(response.P, flow), scalar_product(by_stress, response.dP_de),
          stress + dealii::double_contract<0, 0, 1, 1>(by_stress, response.dP_dF)};
}

/// With the Kirchhoff stress tau = P F^T, n = dev tau/|dev tau|, d gamma = (3/2)^1/2 (a - a_n) and the
/// thermal stretch s: W = |dev tau| d gamma, where 2 mu d gamma = |dev tau_trial| - |dev tau|/s^3. The trial
/// stress has the axes of tau and changes by d|dev tau_trial| = 2 mu n : dF F^-1.
Flow flow_of_large_strains(const SolidLaw::Response &response, const Tensor<2, 3> &H, const double s,
                           const double mu)
{
  const unsigned int last = response.memory.accepted.size() - 1;
  const double flow = std::sqrt(1.5) * (response.memory.trial[last] - response.memory.accepted[last]);
  const Tensor<2, 3> F = Deformation(H).F, stress = deviator(response.P * transpose(F));
  const double norm = stress.norm(), volume = s * s * s;
  const Tensor<2, 3> n = stress / norm,
                     norm_by_F = dealii::double_contract<0, 0, 1, 1>(n * F, response.dP_dF) + n * response.P;
  const double norm_by_e = scalar_product(n * F, response.dP_de);
  const double by_norm = flow - norm / (2 * mu * volume);
  return {norm * flow, by_norm * norm_by_e + 3 * norm * norm / (2 * mu * volume * s),
          by_norm * norm_by_F + norm * n * transpose(invert(F))};
}

} // namespace

template <int dim>
bool SolidTerm<dim>::flow_work(const State<dim> &state, Work &work) const
{
  SolidLaw::Response local;
  static_cast<SolidLaw::Place &>(local) = place(state);
  const Tensor<2, 3> H = displacement_gradient(state);
  const double e = thermal_strain(state), mu = *law->shear_of_flow();
  if (!law->evaluate(H, e, true, local))
    return false;
  if (std::equal(local.memory.trial.begin(), local.memory.trial.begin() + 9, local.memory.accepted.begin()))
    return true; // nothing flows: no rounding in place of zeros
  const Flow flow =
      law->has_large_strain() ? flow_of_large_strains(local, H, 1 + e, mu) : flow_of_small_strains(local, mu);
  work.value = flow.value;
  set_derivatives(state, flow.by_strain, flow.by_F, work);
  return true;
}

template <int dim>
bool SolidTerm<dim>::expansion_work(const State<dim> &state, const Tensor<2, 3> &H_n, Work &work) const
{
  SolidLaw::ExpansionWork of_law;
  if (!expansion)
    return true;
  if (!law->expansion_work(displacement_gradient(state), thermal_strain(state), H_n, place(state), of_law)) {
    explain_undefined();
    return false;
  }
  work.value = expansion->coefficient * of_law.value;
  set_derivatives(state, expansion->coefficient * of_law.by_e, expansion->coefficient * of_law.by_F, work);
  return true;
}

/// By the unknowns, from those by the thermal strain and by F.
template <int dim>
void SolidTerm<dim>::set_derivatives(const State<dim> &state, const double by_strain,
                                     const Tensor<2, 3> &by_F, Work &work) const
{
  work.by_temperature = expansion ? expansion->coefficient * by_strain : 0;
  for (unsigned int i = 0; i < dim; ++i)
    work.by_gradient[i] = restrict_to<dim>(by_F[i]);
  if (is_axisymmetric) {
    const auto [by_value, by_gradient] = hoop(state);
    work.by_radius = by_value * by_F[2][2];
    work.by_gradient[0][0] += by_gradient * by_F[2][2];
  }
}

template <int dim>
double SolidTerm<dim>::energy_density(const State<dim> &state) const
{
  return law->energy(displacement_gradient(state), thermal_strain(state), place(state));
}

template <int dim>
Tensor<2, 3> SolidTerm<dim>::cauchy_stress(const State<dim> &state) const
{
  const Tensor<2, 3> H = displacement_gradient(state);
  const auto full = law->full_gradient(H, thermal_strain(state), place(state));
  SolidLaw::Response local;
  static_cast<SolidLaw::Place &>(local) = place(state);
  if (!full || !law->evaluate(H, thermal_strain(state), false, local))
    return std::numeric_limits<double>::quiet_NaN() * dealii::unit_symmetric_tensor<3>();
  const Deformation deformation(*full);
  return law->has_large_strain() ? local.P * transpose(deformation.F) / deformation.J : local.P;
}

template <int dim>
Tensor<2, 3> SolidTerm<dim>::full_displacement_gradient(const State<dim> &state) const
{
  const auto full = law->full_gradient(displacement_gradient(state), thermal_strain(state), place(state));
  return full ? *full : std::numeric_limits<double>::quiet_NaN() * dealii::unit_symmetric_tensor<3>();
}

template class SolidTerm<2>;
template class SolidTerm<3>;

} // namespace dovetail
