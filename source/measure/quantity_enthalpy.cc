// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The heat content per undeformed volume above the temperature 0, rho (int_0^T c dT + L f(T)), or rho (H(T) -
// H(0)) with an Enthalpy (content.h). Its integral over a domain is a probe with Reduce = integral. NaN in
// static scenes, where nothing is stored.
//
//     set Quantity = enthalpy

#include <dovetail/measure/quantity.h>

namespace dovetail {

namespace {

template <int dim>
class EnthalpyDensity : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    const Material<dim> &material = this->domain.material;
    numbers.push_back(material.content(point.state(), material.find_field("temperature")->first_component));
  }
};

const bool registered = add_quantity<EnthalpyDensity>(
    "enthalpy", "temperature", "the heat content per volume above T = 0, in transient scenes [J/m^3]");

} // namespace

} // namespace dovetail
