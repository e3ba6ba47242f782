// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/hyperelastic_law.h>
#include <dovetail/material/material.h>
#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/undefined.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

using dealii::Point;
using dealii::Tensor;

namespace {

/// Optional until a transient scene needs it; 0 means not given.
void read_positive(const Section &section, const std::string &name, const std::string &description)
{
  const double value = section.read<double>(name, 0, description);
  section.check(value >= 0, name, "must be positive (or 0: not given).");
}

template <int dim>
Tensor<1, 3> embed(const Tensor<1, dim> &vector)
{
  Tensor<1, 3> result;
  for (unsigned int i = 0; i < dim; ++i)
    result[i] = vector[i];
  return result;
}

template <int dim>
Point<3> embed(const Point<dim> &point)
{
  return Point<3>(embed(static_cast<const Tensor<1, dim> &>(point)));
}

template <int dim>
Tensor<1, dim> restrict_to(const Tensor<1, 3> &vector)
{
  Tensor<1, dim> result;
  for (unsigned int i = 0; i < dim; ++i)
    result[i] = vector[i];
  return result;
}

template <int dim>
Tensor<2, dim> restrict_to(const Tensor<2, 3> &tensor)
{
  Tensor<2, dim> result;
  for (unsigned int i = 0; i < dim; ++i)
    result[i] = restrict_to<dim>(tensor[i]);
  return result;
}

/// H = grad u; in 2D plane strain, H_33 = 0. The displacement is the first field.
template <int dim>
Tensor<2, 3> displacement_gradient(const State<dim> &state)
{
  Tensor<2, 3> H;
  for (unsigned int i = 0; i < dim; ++i)
    H[i] = embed(state.gradient[i]);
  return H;
}

/// Whether a field is to be asked at all: an interface does not know the fields that it does not tie.
template <int dim>
bool is_known(const State<dim> &state, const unsigned int component)
{
  return !std::isnan(state.value[component]);
}

template <int dim>
void forget_flux(Response<dim> &response, const unsigned int first, const unsigned int end)
{
  for (unsigned int c = first; c < end; ++c)
    for (unsigned int d = 0; d < dim; ++d)
      response.flux[c][d] = std::numeric_limits<double>::quiet_NaN();
}

template <typename Law>
std::unique_ptr<Law> create(const Section &section, const std::string &description)
{
  return Catalogue<Law>::create(section, "none", description);
}

} // namespace

const std::vector<Field> &every_field()
{
  static const std::vector<Field> fields = {{"displacement", 3, 0}, {"temperature", 1, 3}};
  return fields;
}

template <int dim>
Material<dim>::Material(const std::string &name, const Section &section) : name(name)
{
  const Section solid_section = section.subsection("Solid"), heat_section = section.subsection("Heat");
  solid =
      create<SolidLaw>(solid_section, "The law of the stress; none: the material has no displacement [-]");
  heat = create<HeatLaw>(heat_section, "The law of the heat flux; none: the material has no temperature [-]");
  name_of_solid = solid_section.peek("Type");
  name_of_heat = heat_section.peek("Type");
  section.check(solid || heat, "",
                "has no law: set Type in its subsection Solid, in its subsection Heat, or both.");

  if (solid || section.documenting()) {
    solid_section.choose("Formulation", {"displacement"}, 0, "Unknowns of the solid [-]");
    read_positive(solid_section, "Density", "Mass per volume, for the inertia of transient scenes [kg/m^3]");
    expansion_coefficient = solid_section.read<double>(
        "Expansion coefficient", 0,
        "alpha in the free thermal strain alpha (T - Reference temperature) [1/K]");
    reference_temperature = solid_section.read<double>(
        "Reference temperature", 0, "Temperature at which the undeformed solid is free of stress [K]");
    solid_section.check(
        heat || expansion_coefficient == 0, "Expansion coefficient",
        "needs a Heat law whose temperature expands the solid: add subsection Heat to the material, "
        "or remove the entry.");
  }
  if (heat || section.documenting()) {
    read_positive(heat_section, "Density",
                  "Mass per volume, for the heat stored in transient scenes [kg/m^3]");
    read_positive(heat_section, "Heat capacity", "Heat capacity per mass [J/(kg K)]");
  }

  if (solid)
    all_fields.push_back({"displacement", dim, 0});
  if (heat)
    all_fields.push_back({"temperature", 1, n_components()});
}

template <int dim>
const Field *Material<dim>::find_field(const std::string &field_name) const
{
  for (const Field &field : all_fields)
    if (field.name == field_name)
      return &field;
  return nullptr;
}

template <int dim>
unsigned int Material<dim>::n_components() const
{
  return all_fields.empty() ? 0 : all_fields.back().first_component + all_fields.back().n_components;
}

template <int dim>
bool Material<dim>::evaluate(const State<dim> &state, bool with_derivatives, Response<dim> &response) const
{
  const unsigned int n = n_components();
  AssertDimension(state.gradient.size(), n);
  AssertDimension(response.flux.size(), n);
  const unsigned int c_T = n - 1; // the temperature is the last component

  if (with_derivatives && solid && heat) {
    std::fill(response.by_gradient.begin(), response.by_gradient.end(), Tensor<2, dim>());
    std::fill(response.by_value.begin(), response.by_value.end(), Tensor<1, dim>());
  }

  if (solid && !is_known(state, 0))
    forget_flux(response, 0, dim);
  else if (solid) {
    const bool expands = expansion_coefficient != 0;
    const double e = expands ? expansion_coefficient * (state.value[c_T] - reference_temperature) : 0;
    SolidLaw::Response local;
    ++n_evaluations.solid;
    if (!solid->evaluate(displacement_gradient(state), e, with_derivatives, local)) {
      std::string &reason = last_undefined().reason;
      reason = "material " + name + ", " + name_of_solid + ": " + reason;
      return false;
    }
    for (unsigned int i = 0; i < dim; ++i) {
      response.flux[i] = restrict_to<dim>(local.P[i]);
      if (!with_derivatives)
        continue;
      for (unsigned int k = 0; k < dim; ++k) {
        Tensor<2, dim> &by_gradient = response.by_gradient[i * n + k];
        for (unsigned int J = 0; J < dim; ++J)
          by_gradient[J] = restrict_to<dim>(local.dP_dF[i][J][k]);
        response.by_value[i * n + k] = 0;
      }
      if (expands)
        response.by_value[i * n + c_T] = expansion_coefficient * restrict_to<dim>(local.dP_de[i]);
    }
  }

  if (heat && !is_known(state, c_T))
    forget_flux(response, c_T, n);
  else if (heat) {
    HeatLaw::Response local;
    ++n_evaluations.heat;
    if (!heat->evaluate(embed(state.X), state.t, state.value[c_T], embed(state.gradient[c_T]),
                        with_derivatives, local))
      return false;
    response.flux[c_T] = restrict_to<dim>(local.A);
    if (with_derivatives) {
      response.by_gradient[c_T * n + c_T] = restrict_to<dim>(local.dA_dG);
      response.by_value[c_T * n + c_T] = restrict_to<dim>(local.dA_dT);
    }
  }
  return true;
}

template <int dim>
void Material<dim>::curvature(const State<dim> &state, const std::vector<Tensor<1, dim>> &w,
                              dealii::FullMatrix<double> &result) const
{
  const unsigned int n = n_components();
  AssertDimension(w.size(), n);
  const unsigned int c_T = n - 1;
  const auto value_row = [](unsigned int c) { return c * (1 + dim); };
  const auto gradient_row = [](unsigned int c, unsigned int J) { return c * (1 + dim) + 1 + J; };
  const auto add_symmetric = [&result](unsigned int row, unsigned int column, double value) {
    result(row, column) += value;
    result(column, row) += value;
  };
  result.reinit(n * (1 + dim), n * (1 + dim));

  if (solid && !solid->is_linear()) {
    Tensor<2, 3> w_3d;
    for (unsigned int i = 0; i < dim; ++i)
      w_3d[i] = embed(w[i]);
    if (w_3d.norm_square() > 0) {
      const double alpha = expansion_coefficient;
      const double e = alpha != 0 ? alpha * (state.value[c_T] - reference_temperature) : 0;
      const SolidLaw::Curvature local = solid->curvature(displacement_gradient(state), e, w_3d);
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int J = 0; J < dim; ++J) {
          for (unsigned int k = 0; k < dim; ++k)
            for (unsigned int L = 0; L < dim; ++L)
              result(gradient_row(i, J), gradient_row(k, L)) = local.FF[i][J][k][L];
          if (alpha != 0)
            add_symmetric(gradient_row(i, J), value_row(c_T), alpha * local.Fe[i][J]);
        }
      if (alpha != 0)
        result(value_row(c_T), value_row(c_T)) += alpha * alpha * local.ee;
    }
  }

  if (heat && !heat->is_linear() && w[c_T].norm_square() > 0) {
    const HeatLaw::Curvature local =
        heat->curvature(embed(state.X), state.t, state.value[c_T], embed(state.gradient[c_T]), embed(w[c_T]));
    for (unsigned int J = 0; J < dim; ++J) {
      for (unsigned int L = 0; L < dim; ++L)
        result(gradient_row(c_T, J), gradient_row(c_T, L)) += local.GG[J][L];
      add_symmetric(gradient_row(c_T, J), value_row(c_T), local.GT[J]);
    }
    result(value_row(c_T), value_row(c_T)) += local.TT;
  }
}

template <int dim>
Tensor<2, 3> Material<dim>::cauchy_stress(const State<dim> &state) const
{
  Assert(solid, dealii::ExcMessage("A material without a solid law has no stress."));
  const Deformation deformation(displacement_gradient(state));
  const double e = expansion_coefficient != 0
                       ? expansion_coefficient * (state.value[n_components() - 1] - reference_temperature)
                       : 0;
  SolidLaw::Response local;
  if (!solid->evaluate(deformation.H, e, false, local))
    return std::numeric_limits<double>::quiet_NaN() * dealii::unit_symmetric_tensor<3>();
  return solid->is_linear() ? local.P : local.P * transpose(deformation.F) / deformation.J;
}

template <int dim>
bool Material<dim>::depends(unsigned int field, unsigned int on_field) const
{
  AssertIndexRange(field, all_fields.size());
  AssertIndexRange(on_field, all_fields.size());
  return field == on_field || (all_fields[field].name == "displacement" && expansion_coefficient != 0);
}

template <int dim>
bool Material<dim>::has_large_strain() const
{
  for (unsigned int f = 0; f < all_fields.size(); ++f)
    if (all_fields[f].n_components > 1 && !is_linear(f))
      return true;
  return false;
}

template <int dim>
bool Material<dim>::is_linear(unsigned int field) const
{
  AssertIndexRange(field, all_fields.size());
  return all_fields[field].name == "displacement" ? solid->is_linear() : heat->is_linear();
}

template <int dim>
bool Material<dim>::is_symmetric(unsigned int field) const
{
  AssertIndexRange(field, all_fields.size());
  return all_fields[field].name == "displacement" || heat->is_symmetric(); // a solid has an energy
}

template <int dim>
bool Material<dim>::depends_on_time() const
{
  return heat && heat->depends_on_time();
}

template <int dim>
std::string Material<dim>::description(const unsigned int field) const
{
  std::string words = all_fields[field].name == "displacement" ? name_of_solid : name_of_heat;
  words += is_linear(field) ? ", linear" : ", nonlinear";
  for (unsigned int other = 0; other < all_fields.size(); ++other)
    if (other != field && depends(field, other))
      words += ", depends on the " + all_fields[other].name;
  return words;
}

template class Material<2>;
template class Material<3>;

} // namespace dovetail
