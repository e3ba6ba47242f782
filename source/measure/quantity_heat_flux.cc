// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The physical heat flux per undeformed area, q = -A = -K grad T (Fourier 1822): minus the influx A of
// scalar_law.h. NaN where the law is not defined.
//
//     set Quantity = heat flux

#include <dovetail/measure/quantity.h>

namespace dovetail {

namespace {

template <int dim>
class HeatFlux : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  unsigned int n_components() const override { return dim; }

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    const auto &A = point.response().flux[this->domain.material.find_field("temperature")->first_component];
    for (unsigned int d = 0; d < dim; ++d)
      numbers.push_back(-A[d]);
  }
};

const bool registered = add_quantity<HeatFlux>("heat flux", "temperature", "q = -K grad T [W/m^2]");

} // namespace

} // namespace dovetail
