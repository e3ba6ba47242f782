// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/deformation_heat.h>

namespace dovetail {

using dealii::Tensor;

template <int dim>
DeformationHeat<dim>::DeformationHeat(const Field &temperature, const SolidTerm<dim> &solid,
                                      const bool with_compression, const double share, const double offset)
    : Term<dim>(temperature), solid(solid), with_compression(with_compression), share(share), offset(offset)
{
}

template <int dim>
std::vector<InternalVariable> DeformationHeat<dim>::internal_variables() const
{
  return {{"heat of deformation"}, {"time of the heat"}, {"gradient of the step", dim * dim}};
}

template <int dim>
Coupling DeformationHeat<dim>::coupling(const unsigned int c, const unsigned int d) const
{
  Coupling result;
  result.source_by_gradient = solid.field.has_component(d);
  result.source_by_value = c == d || (solid.is_around_axis() && d == solid.field.first_component);
  return result;
}

/// (T + offset) dP/dT : (H - H_n)/(t - t_n).
template <int dim>
bool DeformationHeat<dim>::add_compression(const State<dim> &state, const double duration,
                                           const double *const accepted, double &heat,
                                           Response<dim> *const response) const
{
  const unsigned int T = this->field.first_component, n = state.value.size(),
                     first = solid.field.first_component;
  Response<dim> stress(n);
  if (!solid.add(state, true, stress))
    return false;
  std::vector<Tensor<1, dim>> rate(n);
  double power = 0; // dP/dT : dF/dt
  for (unsigned int i = 0; i < dim; ++i) {
    for (unsigned int J = 0; J < dim; ++J)
      rate[first + i][J] =
          (state.gradient[first + i][J] - accepted[gradient_of_step + i * dim + J]) / duration;
    power += stress.by_value[(first + i) * n + T] * rate[first + i];
  }
  const double absolute = state.value[T] + offset;
  heat += absolute * power;
  if (response == nullptr)
    return true;
  dealii::FullMatrix<double> second(n * (1 + dim), n * (1 + dim));
  if (!solid.is_linear() && solid.has_curvature())
    solid.add_curvature(state, rate, second);
  const unsigned int row = this->value_row(T);
  response->source_by_value[T * n + T] -= power + absolute * second(row, row);
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int J = 0; J < dim; ++J)
      response->source_by_gradient[T * n + first + i][J] -=
          absolute * (stress.by_value[(first + i) * n + T][J] / duration +
                      second(row, this->gradient_row(first + i, J)));
  return true;
}

template <int dim>
bool DeformationHeat<dim>::add_flow(const State<dim> &state, const double duration, double &heat,
                                    Response<dim> *const response) const
{
  const unsigned int T = this->field.first_component, n = state.value.size(),
                     first = solid.field.first_component;
  typename SolidTerm<dim>::FlowWork work;
  if (!solid.flow_work(state, work))
    return false;
  const double factor = share / duration;
  heat += factor * work.value;
  if (response == nullptr)
    return true;
  response->source_by_value[T * n + T] -= factor * work.by_temperature;
  if (solid.is_around_axis())
    response->source_by_value[T * n + first] -= factor * work.by_radius;
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int J = 0; J < dim; ++J)
      response->source_by_gradient[T * n + first + i][J] -= factor * work.by_gradient[i][J];
  return true;
}

template <int dim>
void DeformationHeat<dim>::remember(const State<dim> &state, const double heat) const
{
  double *const trial = state.memory.trial.data() + this->first_internal_variable;
  trial[heat_of_step] = heat;
  trial[time_of_step] = state.t;
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int J = 0; J < dim; ++J)
      trial[gradient_of_step + i * dim + J] = state.gradient[solid.field.first_component + i][J];
}

template <int dim>
void DeformationHeat<dim>::pass(const State<dim> &state) const
{
  const double *const accepted = state.memory.accepted.data() + this->first_internal_variable;
  remember(state, state.t > accepted[time_of_step] ? 0 : accepted[heat_of_step]);
}

template <int dim>
bool DeformationHeat<dim>::add(const State<dim> &state, const bool with_derivatives,
                               Response<dim> &response) const
{
  const unsigned int T = this->field.first_component;
  const double *const accepted = state.memory.accepted.data() + this->first_internal_variable;
  const double duration = state.t - accepted[time_of_step];
  if (duration <= 0) {
    response.source[T] -= accepted[heat_of_step];
    return true;
  }
  double heat = 0;
  Response<dim> *const derivatives = with_derivatives ? &response : nullptr;
  if ((with_compression && !add_compression(state, duration, accepted, heat, derivatives)) ||
      (share > 0 && !add_flow(state, duration, heat, derivatives)))
    return false;
  response.source[T] -= heat;
  remember(state, heat);
  return true;
}

template class DeformationHeat<2>;
template class DeformationHeat<3>;

} // namespace dovetail
