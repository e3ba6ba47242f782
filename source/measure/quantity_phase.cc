// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Which material holds at a point in the last step (phase_choice.h): 0 is that of the domain, 1 the one that
// it names in Otherwise, and so on. The integral of it over a domain with two phases is the volume of the
// second one.
//
//     set Quantity = phase

#include <dovetail/measure/quantity.h>

namespace dovetail {

namespace {

template <int dim>
class PhaseNumber : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    numbers.push_back(this->domain.material.phase(point.state()));
  }
};

const bool registered = add_quantity<PhaseNumber>(
    "phase", "", "number of the material that holds in the last step, 0 where its Toggle is on [-]");

} // namespace

} // namespace dovetail
