// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The share that has melted, between 0 and 1 (latent_heat.cc). Its integral over a domain, a probe with
// Reduce = integral, is the volume of the melt. NaN without Latent heat.
//
//     set Quantity = liquid fraction

#include <dovetail/measure/quantity.h>

namespace dovetail {

namespace {

template <int dim>
class LiquidFraction : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  bool is_stored() const override { return true; }

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    const Material<dim> &material = this->domain.material;
    numbers.push_back(
        material.liquid_fraction(point.state(), material.find_field("temperature")->first_component));
  }
};

const bool registered = add_quantity<LiquidFraction>("liquid fraction", "temperature",
                                                     "the share that has melted, with Latent heat [-]");

} // namespace

} // namespace dovetail
