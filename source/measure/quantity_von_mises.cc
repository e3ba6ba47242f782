// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The equivalent stress (3/2 dev sigma : dev sigma)^1/2 of the Cauchy stress (von Mises 1913): in uniaxial
// tension its absolute value.
//
//     set Quantity = von Mises

#include <dovetail/measure/quantity.h>

#include <cmath>

namespace dovetail {

namespace {

template <int dim>
class VonMises : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    numbers.push_back(std::sqrt(1.5) * deviator(symmetrize(point.cauchy_stress())).norm());
  }
};

const bool registered = add_quantity<VonMises>("von Mises", "displacement",
                                               "(3/2 dev sigma : dev sigma)^1/2 of the Cauchy stress [Pa]");

} // namespace

} // namespace dovetail
