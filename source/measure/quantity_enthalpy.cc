// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The heat content per undeformed volume above the `Reference temperature of enthalpy` T_r of the material,
// rho (int_(T_r)^T c dT + L (f(T) - f(T_r))), or rho (H(T) - H(T_r)) with an Enthalpy (content.h). Its
// integral over a domain is a probe with Reduce = integral. Static scenes, in which nothing is stored, refuse
// it. NaN where this content is not finite: a formula c(T) may have a pole between T_r and T.
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

  bool is_stored() const override { return true; }

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    const Material<dim> &material = this->domain.material;
    numbers.push_back(material.content(point.state(), material.find_field("temperature")->first_component));
  }
};

const bool registered = add_quantity<EnthalpyDensity>(
    "enthalpy", "temperature",
    "the heat content per volume above the Reference temperature of enthalpy, in transient scenes [J/m^3]");

} // namespace

} // namespace dovetail
