// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The elastic energy per undeformed volume, which unloading gives back (SolidLaw::energy, Green 1839). Its
// integral over a domain is a probe with Reduce = integral. NaN where the law is not defined.
//
//     set Quantity = energy density

#include <dovetail/measure/quantity.h>

namespace dovetail {

namespace {

template <int dim>
class EnergyDensity : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    numbers.push_back(point.energy_density());
  }
};

const bool registered = add_quantity<EnergyDensity>("energy density", "displacement",
                                                    "the elastic energy per undeformed volume [J/m^3]");

} // namespace

} // namespace dovetail
