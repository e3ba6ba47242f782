// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/deformed_diffusion_term.h>
#include <dovetail/material/embedding.h>
#include <dovetail/scene/undefined.h>

#include <algorithm>

namespace dovetail {

using dealii::Tensor;

template <int dim>
DeformedDiffusionTerm<dim>::DeformedDiffusionTerm(const Field &field, const std::vector<Field> &all,
                                                  const Section &section, std::unique_ptr<ScalarLaw> law,
                                                  const std::string &name_of_law)
    : Term<dim>(field), scalars(all), own(scalars.number(field.first_component)), section(section),
      is_axisymmetric(section.top().peek("Geometry") == "axisymmetric"), law(std::move(law)),
      name_of_law(name_of_law)
{
  for (const Field &other : all)
    if (other.n_components == dim)
      u = other.first_component;
}

template <int dim>
Coupling DeformedDiffusionTerm<dim>::coupling(const unsigned int c, const unsigned int d) const
{
  const unsigned int s = scalars.number(d);
  const bool is_of_displacement = d >= u && d < u + dim;
  Coupling result;
  result.flux_by_gradient = c == d || is_of_displacement;
  result.flux_by_value = (s < scalars.size() && law->depends_on_scalar(s)) || (is_axisymmetric && d == u);
  return result;
}

/// On the axis u_r/r is du_r/dr.
template <int dim>
Tensor<2, 3> DeformedDiffusionTerm<dim>::deformation_gradient(const State<dim> &state) const
{
  Tensor<2, 3> F;
  for (unsigned int i = 0; i < 3; ++i)
    F[i][i] = 1;
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int L = 0; L < dim; ++L)
      F[i][L] += state.gradient[u + i][L];
  if (is_axisymmetric)
    F[2][2] = radius(state) > 0 ? 1 + state.value[u] / radius(state) : F[0][0];
  return F;
}

/// dA_J/dF_iL = J (F^-1_Li b_J - F^-1_Ji b_L - (F^-1 k F^-T)_JL g_i) with b = F^-1 a and k = da/dg.
template <int dim>
bool DeformedDiffusionTerm<dim>::add(const State<dim> &state, const bool with_derivatives,
                                     Response<dim> &response) const
{
  const unsigned int c = this->field.first_component, n = state.value.size();
  const Tensor<2, 3> F = deformation_gradient(state);
  const double J = determinant(F);
  if (!(J > 0))
    return undefined(
        sentence_about(section, "Configuration",
                       "is deformed, but det F is " + in_words(J) + " at " + in_words(state.X) + "."));
  const Tensor<2, 3> inverse = invert(F);
  ScalarState here = scalars.state(state, own);
  here.G = transpose(inverse) * embed(state.gradient[c]);
  ScalarLaw::Response local(with_derivatives ? scalars.size() : 0);
  if (!law->evaluate(here, with_derivatives, local))
    return false;
  const Tensor<1, 3> b = inverse * local.A;
  response.flux[c] += restrict_to<dim>(J * b);
  if (!with_derivatives)
    return true;
  const Tensor<2, 3> k = inverse * local.by_gradient * transpose(inverse);
  response.by_gradient[c * n + c] += restrict_to<dim>(J * k);
  for (unsigned int s = 0; s < scalars.size(); ++s)
    response.by_value[c * n + scalars.component(s)] += restrict_to<dim>(J * (inverse * local.by_scalar[s]));
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int K = 0; K < dim; ++K)
      for (unsigned int L = 0; L < dim; ++L)
        response.by_gradient[c * n + u + i][K][L] +=
            J * (inverse[L][i] * b[K] - inverse[K][i] * b[L] - k[K][L] * here.G[i]);
  if (is_axisymmetric && radius(state) > 0)
    response.by_value[c * n + u] += restrict_to<dim>(J * b) / (F[2][2] * radius(state));
  else if (is_axisymmetric)
    for (unsigned int K = 0; K < dim; ++K)
      response.by_gradient[c * n + u][K][0] += J * b[K] / F[2][2];
  return true;
}

template class DeformedDiffusionTerm<2>;
template class DeformedDiffusionTerm<3>;

} // namespace dovetail
