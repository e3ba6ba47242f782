// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/pressure_of_flux.h>
#include <dovetail/measure/interface_point.h>

#include <cmath>
#include <limits>

namespace dovetail {

namespace {
constexpr double rounding = 1e-10; ///< of a flux, in units of the terms that cancel in it
}

template <int dim>
InterfacePoint<dim>::InterfacePoint(const Interface<dim> &interface, const double t)
    : fields(interface.fields.size()), interface(interface), t(t), points(interface, t)
{
}

template <int dim>
void InterfacePoint<dim>::for_each(const Vector &solution, const Visitor &visit)
{
  for_each_group(interface, values_in(solution), [&](const auto &group, const std::vector<double> &unknowns) {
    for (unsigned int q = group.begin; q < group.end; ++q) {
      evaluate(q, unknowns);
      visit(q, group.side);
    }
  });
}

template <int dim>
void InterfacePoint<dim>::evaluate(const unsigned int q, const std::vector<double> &unknowns)
{
  auto &state = points.state;
  for (const unsigned int side : {source, destination}) {
    const Response<dim> &response = points.response[side];
    points.reinit(side, q, unknowns);
    for (unsigned int f = 0; f < fields.size(); ++f) {
      const TiedField &field = interface.fields[f];
      fields[f].flux[side] = normal_flux(field, side, q);
      double square = 0, gradient_part = 0, value_part = 0;
      for (unsigned int c = field.first_component[side]; c < field.first_component[side] + field.n_components;
           ++c) {
        square += response.flux[c].norm_square();
        gradient_part += state[side].gradient[c].norm_square();
        value_part += state[side].value[c] * state[side].value[c];
      }
      const double size = std::sqrt(square),
                   terms = modulus(field, side) *
                           (std::sqrt(gradient_part) +
                            std::sqrt(value_part) / interface.sides[side].domain->typical_length());
      fields[f].flux_size[side] = size > rounding * terms ? size : 0; // as of a rigid motion
      const auto first = state[side].value.begin() + field.first_component[side];
      fields[f].trace[side].assign(first, first + field.n_components);
    }
  }
  for (unsigned int f = 0; f < fields.size(); ++f) {
    interface.jump(interface.fields[f], q, t, unknowns, fields[f].jump);
    fields[f].numerical_flux.assign(interface.fields[f].n_components, 0.);
    if (interface.is_active(t))
      interface.tie().numerical_flux(interface, interface.fields[f], q, state, fields[f].flux, fields[f].jump,
                                     fields[f].numerical_flux);
  }
}

template <int dim>
std::vector<double> InterfacePoint<dim>::normal_flux(const TiedField &field, const unsigned int side,
                                                     const unsigned int q)
{
  const bool is_defined = points.evaluate(side, true);
  std::vector<double> result(field.n_components, std::numeric_limits<double>::quiet_NaN());
  for (unsigned int c = 0; is_defined && c < field.n_components; ++c)
    result[c] = points.response[side].flux[field.first_component[side] + c] * interface.pairing().N(side, q);
  return result;
}

template <int dim>
std::vector<double> InterfacePoint<dim>::flux_without_pressure(const TiedField &field,
                                                               const unsigned int q) const
{
  const FieldAtPoint &at_point = fields[field.index];
  auto flux = at_point.flux;
  bool has_pressure = false;
  for (const unsigned int side : {source, destination})
    if (const auto p = pressure_of_flux(*interface.sides[side].domain, field.field[side])) {
      has_pressure = true;
      const unsigned int n = points.state[side].value.size(), first = field.first_component[side];
      for (unsigned int c = 0; c < field.n_components; ++c)
        flux[side][c] -= points.response[side].by_value[(first + c) * n + *p] *
                         interface.pairing().N(side, q) * points.state[side].value[*p];
    }
  if (!has_pressure)
    return at_point.numerical_flux;
  std::vector<double> result(field.n_components);
  interface.tie().numerical_flux(interface, field, q, points.state, flux, at_point.jump, result);
  return result;
}

template <int dim>
bool InterfacePoint<dim>::has_exact_flux(const unsigned int field, const unsigned int side) const
{
  const Domain<dim> &domain = *interface.sides[side].domain;
  for (unsigned int g = 0; g < domain.fields().size(); ++g)
    if (domain.material.flux_depends(interface.fields[field].field[side], g) &&
        domain.exact().find(domain.fields()[g].name) == nullptr)
      return false;
  return true;
}

template <int dim>
std::vector<double> InterfacePoint<dim>::exact_flux(const unsigned int field, const unsigned int side,
                                                    const unsigned int q)
{
  const Domain<dim> &domain = *interface.sides[side].domain;
  const dealii::Point<dim> &X = interface.pairing().X(side, q);
  for (const Field &domain_field : domain.fields())
    if (const Expression *exact = domain.exact().find(domain_field.name))
      for (unsigned int c = 0; c < domain_field.n_components; ++c) {
        points.state[side].value[domain_field.first_component + c] = exact->value(X, t, c);
        points.state[side].gradient[domain_field.first_component + c] =
            exact->gradient(X, t, c, domain.typical_length());
      }
  return normal_flux(interface.fields[field], side, q);
}

template <int dim>
double InterfacePoint<dim>::modulus(const TiedField &field, const unsigned int side) const
{
  const unsigned int n = points.state[side].value.size(), first = field.first_component[side];
  double square = 0;
  for (unsigned int c = first; c < first + field.n_components; ++c)
    for (unsigned int d = first; d < first + field.n_components; ++d)
      square += points.response[side].by_gradient[c * n + d].norm_square();
  return std::sqrt(square);
}

template <int dim>
bool InterfacePoint<dim>::has_exact_flux(const unsigned int field) const
{
  return has_exact_flux(field, source) || has_exact_flux(field, destination);
}

template <int dim>
std::vector<double> InterfacePoint<dim>::exact_flux(const unsigned int field, const unsigned int q)
{
  const double much_softer = 1e-3;
  std::vector<double> result;
  double stiffness = std::numeric_limits<double>::infinity();
  if (has_exact_flux(field, source)) {
    result = exact_flux(field, source, q);
    stiffness = modulus(interface.fields[field], source);
  }
  if (has_exact_flux(field, destination)) {
    std::vector<double> destination_flux = exact_flux(field, destination, q);
    if (modulus(interface.fields[field], destination) < much_softer * stiffness) {
      for (double &component : destination_flux)
        component = -component;
      result = destination_flux;
    }
  }
  return result;
}

template class InterfacePoint<2>;
template class InterfacePoint<3>;

} // namespace dovetail
