// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The velocity du/dt of a body with inertia at the end of a step, as the time scheme finds it
// (time_scheme.h).
//
//     set Fields = solution, velocity

#include <dovetail/measure/quantity.h>

namespace dovetail {

namespace {

template <int dim>
class Velocity : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  unsigned int n_components() const override { return dim; }
  bool is_of_motion() const override { return true; }

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    const dealii::Tensor<1, dim> v = this->velocity(point);
    numbers.insert(numbers.end(), v.begin_raw(), v.end_raw());
  }
};

const bool registered = add_quantity<Velocity>("velocity", "displacement",
                                               "du/dt of a body with inertia, in transient scenes [m/s]");

} // namespace

} // namespace dovetail
