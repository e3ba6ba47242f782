// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/embedding.h>
#include <dovetail/material/hyperelastic_law.h>
#include <dovetail/material/solid_term.h>
#include <dovetail/scene/undefined.h>

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
                          const std::optional<Expansion> &expansion, const std::string &name_of_material,
                          const std::string &name_of_law, const double density)
    : Term<dim>(field), density(density), law(std::move(law)), expansion(expansion),
      name_of_material(name_of_material), name_of_law(name_of_law),
      n_internal_variables(n_numbers(this->law->internal_variables()))
{
}

template <int dim>
Coupling SolidTerm<dim>::coupling(const unsigned int /*c*/, const unsigned int d) const
{
  const unsigned int own = d - this->field.first_component; // wraps if of another field
  Coupling result;
  result.flux_by_gradient = own < this->field.n_components;
  result.flux_by_value = expansion && d == expansion->temperature;
  return result;
}

template <int dim>
Memory SolidTerm<dim>::memory(const State<dim> &state) const
{
  return state.memory.slice(this->first_internal_variable, n_internal_variables);
}

/// H = grad u.
template <int dim>
Tensor<2, 3> SolidTerm<dim>::displacement_gradient(const State<dim> &state) const
{
  Tensor<2, 3> H;
  for (unsigned int i = 0; i < dim; ++i)
    H[i] = embed(state.gradient[this->field.first_component + i]);
  return H;
}

template <int dim>
bool SolidTerm<dim>::add(const State<dim> &state, const bool with_derivatives, Response<dim> &response) const
{
  const unsigned int n = state.value.size(), first = this->field.first_component;
  SolidLaw::Response local;
  local.memory = memory(state);
  if (!law->evaluate(displacement_gradient(state), thermal_strain(state), with_derivatives, local)) {
    std::string &reason = last_undefined().reason;
    reason = "material " + name_of_material + ", " + name_of_law + ": " + reason;
    return false;
  }
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
  return true;
}

template <int dim>
void SolidTerm<dim>::add_curvature(const State<dim> &state, const std::vector<Tensor<1, dim>> &w,
                                   dealii::FullMatrix<double> &result) const
{
  const unsigned int first = this->field.first_component;
  Tensor<2, 3> w_3d;
  for (unsigned int i = 0; i < dim; ++i)
    w_3d[i] = embed(w[first + i]);
  const SolidLaw::Curvature local = law->curvature(displacement_gradient(state), thermal_strain(state), w_3d);
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int J = 0; J < dim; ++J) {
      const unsigned int row = this->gradient_row(first + i, J);
      for (unsigned int k = 0; k < dim; ++k)
        for (unsigned int L = 0; L < dim; ++L)
          result(row, this->gradient_row(first + k, L)) += local.FF[i][J][k][L];
      if (expansion)
        this->add_symmetric(result, row, this->value_row(expansion->temperature),
                            expansion->coefficient * local.Fe[i][J]);
    }
  if (expansion) {
    const unsigned int row = this->value_row(expansion->temperature);
    result(row, row) += expansion->coefficient * expansion->coefficient * local.ee;
  }
}

template <int dim>
Tensor<2, 3> SolidTerm<dim>::cauchy_stress(const State<dim> &state) const
{
  const Tensor<2, 3> H = displacement_gradient(state);
  const auto full = law->full_gradient(H, thermal_strain(state), memory(state));
  SolidLaw::Response local;
  local.memory = memory(state);
  if (!full || !law->evaluate(H, thermal_strain(state), false, local))
    return std::numeric_limits<double>::quiet_NaN() * dealii::unit_symmetric_tensor<3>();
  const Deformation deformation(*full);
  return law->is_linear() ? local.P : local.P * transpose(deformation.F) / deformation.J;
}

template <int dim>
Tensor<2, 3> SolidTerm<dim>::full_displacement_gradient(const State<dim> &state) const
{
  const auto full = law->full_gradient(displacement_gradient(state), thermal_strain(state), memory(state));
  return full ? *full : std::numeric_limits<double>::quiet_NaN() * dealii::unit_symmetric_tensor<3>();
}

template class SolidTerm<2>;
template class SolidTerm<3>;

} // namespace dovetail
