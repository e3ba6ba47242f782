// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/deformation_heat.h>

namespace dovetail {

using dealii::Tensor;

template <int dim>
DeformationHeat<dim>::DeformationHeat(const Field &temperature, const SolidTerm<dim> &solid,
                                      const VolumeTerm<dim> *const volume, const bool with_compression,
                                      const double share, const double offset)
    : Term<dim>(temperature), solid(solid), volume(volume), with_compression(with_compression), share(share),
      offset(offset)
{
}

template <int dim>
std::vector<InternalVariable> DeformationHeat<dim>::internal_variables() const
{
  std::vector<InternalVariable> result = {
      {"heat of deformation"}, {"time of the heat"}, {"gradient of the step", dim * dim}};
  if (solid.is_around_axis())
    result.push_back({"hoop strain of the step"});
  if (volume != nullptr)
    result.push_back({"change of volume of the step"});
  return result;
}

template <int dim>
Coupling DeformationHeat<dim>::coupling(const unsigned int c, const unsigned int d) const
{
  Coupling result;
  result.source_by_gradient = solid.field.has_component(d);
  result.source_by_value = c == d || (solid.is_around_axis() && d == solid.field.first_component) ||
                           (with_compression && volume != nullptr && volume->field.has_component(d));
  return result;
}

/// (T + offset) times what the step adds to dW/dT, per time.
template <int dim>
bool DeformationHeat<dim>::add_compression(const State<dim> &state, const double duration,
                                           const double *const accepted, double &heat,
                                           Response<dim> *const response) const
{
  const unsigned int T = this->field.first_component, n = state.value.size();
  Tensor<2, 3> H_n;
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int J = 0; J < dim; ++J)
      H_n[i][J] = accepted[gradient_of_step + i * dim + J];
  if (solid.is_around_axis())
    H_n[2][2] = accepted[hoop_of_step()];
  typename SolidTerm<dim>::Work work;
  typename VolumeTerm<dim>::ExpansionWork of_volume;
  if (!solid.expansion_work(state, H_n, work) ||
      (volume != nullptr && !volume->expansion_work(state, accepted[volume_of_step()], of_volume)))
    return false;
  const double factor = (state.value[T] + offset) / duration, whole = work.value + of_volume.value;
  heat += factor * whole;
  if (response == nullptr)
    return true;
  add_derivatives(state, factor, work, *response);
  response->source_by_value[T * n + T] -= whole / duration + factor * of_volume.by_temperature;
  if (volume != nullptr)
    response->source_by_value[T * n + volume->field.first_component] -= factor * of_volume.by_pressure;
  return true;
}

template <int dim>
bool DeformationHeat<dim>::add_flow(const State<dim> &state, const double duration, double &heat,
                                    Response<dim> *const response) const
{
  typename SolidTerm<dim>::Work work;
  if (!solid.flow_work(state, work))
    return false;
  heat += share / duration * work.value;
  if (response != nullptr)
    add_derivatives(state, share / duration, work, *response);
  return true;
}

template <int dim>
void DeformationHeat<dim>::add_derivatives(const State<dim> &state, const double factor,
                                           const typename SolidTerm<dim>::Work &work,
                                           Response<dim> &response) const
{
  const unsigned int T = this->field.first_component, n = state.value.size(),
                     first = solid.field.first_component;
  response.source_by_value[T * n + T] -= factor * work.by_temperature;
  if (solid.is_around_axis())
    response.source_by_value[T * n + first] -= factor * work.by_radius;
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int J = 0; J < dim; ++J)
      response.source_by_gradient[T * n + first + i][J] -= factor * work.by_gradient[i][J];
}

template <int dim>
void DeformationHeat<dim>::remember(const State<dim> &state, const double heat,
                                    const bool is_in_equilibrium) const
{
  double *const trial = state.memory.trial.data() + this->first_internal_variable;
  trial[heat_of_step] = heat;
  trial[time_of_step] = state.t;
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int J = 0; J < dim; ++J)
      trial[gradient_of_step + i * dim + J] = state.gradient[solid.field.first_component + i][J];
  if (solid.is_around_axis())
    trial[hoop_of_step()] = solid.displacement_gradient(state)[2][2];
  if (volume != nullptr)
    trial[volume_of_step()] =
        is_in_equilibrium ? volume->volume_of_pressure(state) : volume->volume_of_displacement(state);
}

/// Before the first step, or with the pressure of another phase.
template <int dim>
void DeformationHeat<dim>::pass(const State<dim> &state) const
{
  const double *const accepted = state.memory.accepted.data() + this->first_internal_variable;
  remember(state, state.t > accepted[time_of_step] ? 0 : accepted[heat_of_step], false);
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
  remember(state, heat, true);
  return true;
}

template class DeformationHeat<2>;
template class DeformationHeat<3>;

} // namespace dovetail
