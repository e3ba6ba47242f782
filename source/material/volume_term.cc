// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/embedding.h>
#include <dovetail/material/hyperelastic_law.h>
#include <dovetail/material/volume_term.h>
#include <dovetail/scene/undefined.h>

#include <array>
#include <cmath>

namespace dovetail {

using dealii::Tensor;

namespace {

/// X_iJkL(A) = e_ikm e_JLN A_mN. The cofactor of F is X(F):F/2, and its derivative X(F).
Tensor<4, 3> derivative_of_cofactor(const Tensor<2, 3> &A)
{
  Tensor<4, 3> X;
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int k = 0; k < 3; ++k)
      for (unsigned int J = 0; J < 3 && k != i; ++J)
        for (unsigned int L = 0; L < 3; ++L)
          if (L != J) {
            const double sign = ((3 + k - i) % 3 == (3 + L - J) % 3) ? 1 : -1;
            X[i][J][k][L] = sign * A[3 - i - k][3 - J - L];
          }
  return X;
}

Tensor<2, 3> cofactor(const Tensor<2, 3> &F)
{
  return dealii::double_contract<2, 0, 3, 1>(derivative_of_cofactor(F), F) / 2.;
}

Tensor<2, 3> with_unit(Tensor<2, 3> H)
{
  for (unsigned int i = 0; i < 3; ++i)
    H[i][i] += 1;
  return H;
}

} // namespace

bool PressureStress::evaluate(const Tensor<2, 3> &H, const double p, const bool with_derivatives,
                              Response &response) const
{
  const Tensor<2, 3> F = with_unit(H);
  const Tensor<2, 3> direction = is_large ? cofactor(F) : Tensor<2, 3>(dealii::unit_symmetric_tensor<3>());
  response.P = p * direction;
  if (with_derivatives) {
    response.dP_dF = is_large ? p * derivative_of_cofactor(F) : Tensor<4, 3>();
    response.dP_de = direction;
  }
  return std::isfinite(response.P.norm_square()) || undefined("the pressure is not a finite number");
}

// w:cof F has the derivative X(w):F and the second one X(w).
SolidLaw::Curvature PressureStress::curvature(const Tensor<2, 3> &H, const double p, const Tensor<2, 3> &w,
                                              const Place &) const
{
  Curvature result;
  if (!is_large)
    return result;
  const Tensor<4, 3> X = derivative_of_cofactor(w);
  result.FF = p * X;
  result.Fe = dealii::double_contract<2, 0, 3, 1>(X, with_unit(H));
  return result;
}

template <int dim>
VolumeTerm<dim>::VolumeTerm(const Field &field, const SolidTerm<dim> &solid, const Volumetric &U,
                            const std::optional<unsigned int> &temperature, const ThermalStrain &strain,
                            const bool is_axisymmetric)
    : Term<dim>(field), solid(solid), U(U), temperature(temperature), strain(strain),
      is_axisymmetric(is_axisymmetric)
{
}

template <int dim>
SolidLaw::Place VolumeTerm<dim>::place(const State<dim> &state, const unsigned int derivative) const
{
  return {{}, embed(state.X), state.t, temperature ? state.value[*temperature] : 0, derivative};
}

template <int dim>
Coupling VolumeTerm<dim>::coupling(const unsigned int c, const unsigned int d) const
{
  const unsigned int radial = solid.field.first_component;
  Coupling result;
  result.source_by_gradient = d >= radial && d < radial + dim;
  result.source_by_value =
      (d == c && is_compressible()) || (temperature && d == *temperature) || (is_axisymmetric && d == radial);
  return result;
}

template <int dim>
bool VolumeTerm<dim>::find_volume(const State<dim> &state, Volume &volume) const
{
  const Tensor<2, 3> H = solid.full_displacement_gradient(state);
  if (!solid.has_large_strain()) {
    volume = {trace(H), dealii::unit_symmetric_tensor<3>()};
    return true;
  }
  const Deformation deformation(H);
  if (!(deformation.J > 0 && std::isfinite(deformation.J)))
    return undefined("the change of volume J = det F is " + in_words(deformation.J) +
                     ", but must be positive");
  volume = {deformation.J_minus_1, cofactor(deformation.F)};
  return true;
}

/// dJ_e/dp = 1/(kappa U'').
template <int dim>
typename VolumeTerm<dim>::VolumeOfPressure
VolumeTerm<dim>::find_volume_of_pressure(const State<dim> &state) const
{
  const SolidLaw::Place here = place(state, 0), change = place(state, 1);
  const double p = state.value[this->field.first_component], m = U.compressibility().at(here),
               e = strain.at(here);
  const double m_by_T = temperature ? U.compressibility().at(change) : 0,
               e_by_T = temperature ? strain.at(change) : 0;
  if (!solid.has_large_strain())
    return {3 * e + m * p, m, 3 * e_by_T + m_by_T * p, m * p};
  const double J_minus_1 = U.change_at(m * p), stiffness = U.per_bulk_modulus(J_minus_1).U_2;
  const double log_s = 3 * std::log1p(e), cube = std::exp(log_s);
  return {std::expm1(log_s) + cube * J_minus_1, cube * m / stiffness,
          3 * cube / (1 + e) * e_by_T * (1 + J_minus_1) + cube * m_by_T * p / stiffness, J_minus_1};
}

template <int dim>
bool VolumeTerm<dim>::add(const State<dim> &state, const bool with_derivatives, Response<dim> &response) const
{
  const unsigned int n = state.value.size(), p = this->field.first_component,
                     first = solid.field.first_component;
  Volume volume;
  if (!find_volume(state, volume))
    return false;
  const VolumeOfPressure of_pressure = find_volume_of_pressure(state);
  response.source[p] += volume.change - of_pressure.change;
  if (!std::isfinite(of_pressure.change))
    return undefined("no volume has the pressure " + in_words(state.value[p]));
  if (!with_derivatives)
    return true;
  for (unsigned int i = 0; i < dim; ++i)
    response.source_by_gradient[p * n + first + i] += restrict_to<dim>(volume.by_F[i]);
  if (of_pressure.by_pressure != 0)
    response.source_by_value[p * n + p] -= of_pressure.by_pressure;
  if (temperature)
    response.source_by_value[p * n + *temperature] -= of_pressure.by_temperature;
  if (is_axisymmetric) {
    const auto [by_value, by_gradient] = SolidTerm<dim>::hoop(state);
    response.source_by_value[p * n + first] += by_value * volume.by_F[2][2];
    response.source_by_gradient[p * n + first][0] += by_gradient * volume.by_F[2][2];
  }
  return true;
}

template <int dim>
double VolumeTerm<dim>::volume_of_pressure(const State<dim> &state) const
{
  return find_volume_of_pressure(state).change;
}

template <int dim>
double VolumeTerm<dim>::volume_of_displacement(const State<dim> &state) const
{
  const Tensor<2, 3> H = solid.full_displacement_gradient(state);
  return solid.has_large_strain() ? Deformation(H).J_minus_1 : trace(H);
}

template <int dim>
bool VolumeTerm<dim>::expansion_work(const State<dim> &state, const double volume_n,
                                     ExpansionWork &work) const
{
  if (!temperature)
    return true;
  std::array<double, 3> e, m; // with their derivatives by the temperature; m = 1/kappa
  for (const unsigned int order : {0, 1, 2}) {
    e[order] = strain.at(place(state, order));
    m[order] = U.compressibility().at(place(state, order));
  }
  const VolumeOfPressure volume = find_volume_of_pressure(state);
  const double p = state.value[this->field.first_component], change = volume.change - volume_n;
  double s = 1, J = 1, stiffness = 1, slope = 0; // of J_e U''(J_e) by J_e; stiffness: U''
  if (solid.has_large_strain()) {
    const VolumetricEnergy at = U.per_bulk_modulus(volume.elastic_change);
    s = 1 + e[0];
    J = 1 + volume.elastic_change;
    stiffness = at.U_2;
    slope = at.U_2 + J * at.U_3;
  }
  const double expansion = e[1] == 0 ? 0 : 3 * e[1] / (m[0] * s), softening = m[1] == 0 ? 0 : m[1] / m[0];
  const double log_strain_2 = solid.has_large_strain() ? e[2] / s - e[1] * e[1] / (s * s) : e[2]; // (ln s)''
  const double by_J = J * stiffness, J_by_p = m[0] / stiffness, J_by_T = m[1] * p / stiffness;
  const double slope_of_p = -softening * p - expansion * by_J; // dp/dT at fixed J
  const double expansion_by_T =
      (e[1] == 0 && e[2] == 0 ? 0 : 3 * log_strain_2 / m[0]) - expansion * softening;
  const double softening_by_T = m[1] == 0 && m[2] == 0 ? 0 : m[2] / m[0] - softening * softening;
  work.value = slope_of_p * change;
  work.by_pressure = (-softening - expansion * slope * J_by_p) * change + slope_of_p * volume.by_pressure;
  work.by_temperature = (-softening_by_T * p - expansion_by_T * by_J - expansion * slope * J_by_T) * change +
                        slope_of_p * volume.by_temperature;
  return std::isfinite(work.value) || undefined("the heat of a change of volume is not a finite number");
}

template <int dim>
double VolumeTerm<dim>::energy_density(const State<dim> &state) const
{
  const SolidLaw::Place here = place(state, 0);
  const double s = solid.has_large_strain() ? 1 + strain.at(here) : 1;
  return s * s * s * U.energy_at(state.value[this->field.first_component], here);
}

template class VolumeTerm<2>;
template class VolumeTerm<3>;

} // namespace dovetail
