// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/interface/side_points.h>

#include <algorithm>
#include <limits>

namespace dovetail {

template <int dim>
void SidePoints<dim>::reinit(const Interface<dim> &new_interface, const double t)
{
  interface = &new_interface;
  for (const unsigned int side : {source, destination}) {
    const unsigned int n = interface->sides[side].domain->n_components();
    state[side] = State<dim>(n);
    state[side].t = t;
    response[side] = Response<dim>(n);
    trial_memory[side] = interface->sides[side].domain->material.initial_memory();
  }
}

template <int dim>
void SidePoints<dim>::reinit(const unsigned int side, const unsigned int q,
                             const dealii::Tensor<1, dim> *gradients, const std::vector<double> &unknowns)
{
  State<dim> &at_point = state[side];
  shape_gradients[side] = gradients;
  at_point.X = interface->pairing().X(side, q);
  at_point.memory = {interface->memory.accepted(side, q),
                     {trial_memory[side].data(), trial_memory[side].size()}};
  if (interface->sides[side].domain->is_on_axis(at_point.X))
    at_point.X[0] = 0;
  const auto &layout = interface->sides[side].domain->layout();
  const double *values_of_all = interface->pairing().values(side, q);
  const double *unknown = unknowns.data() + (side == source ? 0 : interface->n_local(source));
  std::fill(at_point.value.begin(), at_point.value.end(), std::numeric_limits<double>::quiet_NaN());
  for (const unsigned int c : interface->components[side]) {
    at_point.value[c] = 0;
    at_point.gradient[c] = 0;
    const unsigned int n = layout.n_nodes(c);
    const double *values = values_of_all + layout.first_shape(c);
    const dealii::Tensor<1, dim> *component_gradients = gradients + layout.first_shape(c);
    for (unsigned int a = 0; a < n; ++a, ++unknown) {
      at_point.value[c] += values[a] * *unknown;
      at_point.gradient[c] += *unknown * component_gradients[a];
    }
  }
}

template <int dim>
bool SidePoints<dim>::evaluate(const unsigned int side, const std::vector<Asked> &asked)
{
  return interface->sides[side].domain->material.evaluate(state[side], asked, response[side]);
}

template <int dim>
void SidePoints<dim>::curvature(const unsigned int side, const std::vector<dealii::Tensor<1, dim>> &w,
                                dealii::FullMatrix<double> &result) const
{
  interface->sides[side].domain->material.curvature(state[side], w, result);
}

template <int dim>
bool respond(const Interface<dim> &interface, const unsigned int side, const State<dim> &state,
             Response<dim> &response)
{
  return interface.sides[side].domain->material.evaluate(state, true, response);
}

template class SidePoints<2>;
template class SidePoints<3>;

template bool respond(const Interface<2> &, unsigned int, const State<2> &, Response<2> &);
template bool respond(const Interface<3> &, unsigned int, const State<3> &, Response<3> &);

} // namespace dovetail
