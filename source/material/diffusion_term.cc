// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/diffusion_term.h>
#include <dovetail/material/embedding.h>

#include <algorithm>

namespace dovetail {

using dealii::Tensor;

Scalars::Scalars(const std::vector<Field> &fields)
{
  for (const Field &field : fields)
    if (field.n_components == 1)
      components.push_back(field.first_component);
}

unsigned int Scalars::number(const unsigned int component) const
{
  return std::find(components.begin(), components.end(), component) - components.begin();
}

namespace {

template <int dim>
std::optional<Tensor<2, dim>> restricted(const std::optional<Tensor<2, 3>> &K)
{
  return K ? std::optional(restrict_to<dim>(*K)) : std::nullopt;
}

} // namespace

template <int dim>
DiffusionTerm<dim>::DiffusionTerm(const Field &field, const std::vector<Field> &all,
                                  std::unique_ptr<ScalarLaw> law, const std::string &name_of_law)
    : Term<dim>(field), scalars(all), own(scalars.number(field.first_component)), law(std::move(law)),
      constant(restricted<dim>(this->law->constant_gradient())), name_of_law(name_of_law)
{
}

template <int dim>
Coupling DiffusionTerm<dim>::coupling(const unsigned int c, const unsigned int d) const
{
  const unsigned int s = scalars.number(d);
  Coupling result;
  result.flux_by_gradient = c == d;
  result.flux_by_value = s < scalars.size() && law->depends_on_scalar(s);
  return result;
}

template <int dim>
ScalarState DiffusionTerm<dim>::scalar_state(const State<dim> &state) const
{
  ScalarState result = scalars.state(state, own);
  result.G = embed(state.gradient[this->field.first_component]);
  return result;
}

template <int dim>
bool DiffusionTerm<dim>::add(const State<dim> &state, const bool with_derivatives,
                             Response<dim> &response) const
{
  const unsigned int c = this->field.first_component, n = state.value.size();
  if (constant) {
    response.flux[c] += *constant * state.gradient[c];
    if (with_derivatives)
      response.by_gradient[c * n + c] += *constant;
    return true;
  }
  thread_local ScalarLaw::Response local(0); // no new memory at each point
  local.A = {};
  local.by_gradient = {};
  local.by_scalar.assign(with_derivatives ? scalars.size() : 0, {});
  if (!law->evaluate(scalar_state(state), with_derivatives, local))
    return false;
  response.flux[c] += restrict_to<dim>(local.A);
  if (!with_derivatives)
    return true;
  response.by_gradient[c * n + c] += restrict_to<dim>(local.by_gradient);
  for (unsigned int s = 0; s < scalars.size(); ++s)
    response.by_value[c * n + scalars.component(s)] += restrict_to<dim>(local.by_scalar[s]);
  return true;
}

template <int dim>
void DiffusionTerm<dim>::add_curvature(const State<dim> &state, const std::vector<Tensor<1, dim>> &w,
                                       dealii::FullMatrix<double> &result) const
{
  const unsigned int c = this->field.first_component;
  ScalarLaw::Curvature local(scalars.size());
  law->curvature(scalar_state(state), embed(w[c]), local);
  for (unsigned int J = 0; J < dim; ++J) {
    for (unsigned int L = 0; L < dim; ++L)
      result(this->gradient_row(c, J), this->gradient_row(c, L)) += local.by_gradients[J][L];
    for (unsigned int s = 0; s < scalars.size(); ++s)
      this->add_symmetric(result, this->gradient_row(c, J), this->value_row(scalars.component(s)),
                          local.by_gradient_and_scalar[s][J]);
  }
  for (unsigned int s = 0; s < scalars.size(); ++s)
    for (unsigned int r = 0; r < scalars.size(); ++r)
      result(this->value_row(scalars.component(s)), this->value_row(scalars.component(r))) +=
          local.by_scalars[s * scalars.size() + r];
}

template class DiffusionTerm<2>;
template class DiffusionTerm<3>;

} // namespace dovetail
