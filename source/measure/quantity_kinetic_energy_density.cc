// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The kinetic energy per undeformed volume of a body with inertia, rho |v|^2/2 with the Density rho of its
// solid. Its integral over a domain is a probe with Reduce = integral; Output/Energy reports that of all
// bodies.
//
//     set Quantity = kinetic energy density

#include <dovetail/measure/quantity.h>

namespace dovetail {

namespace {

template <int dim>
class KineticEnergyDensity : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  bool is_of_motion() const override { return true; }

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    numbers.push_back(this->domain.material.solid_density() / 2 * this->velocity(point).norm_square());
  }
};

const bool registered =
    add_quantity<KineticEnergyDensity>("kinetic energy density", "displacement",
                                       "rho |v|^2/2 of a body with inertia, in transient scenes [J/m^3]");

} // namespace

} // namespace dovetail
