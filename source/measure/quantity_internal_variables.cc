// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the laws of a domain remember from the last good step (memory.h), each variable under its own name.
// Between the quadrature points of a cell those of the nearest one hold.
//
//     set Fields = solution, internal variables

#include <dovetail/measure/quantity.h>

namespace dovetail {

namespace {

template <int dim>
class AllInternalVariables : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  std::vector<typename Quantity<dim>::Array> arrays() const override
  {
    std::vector<typename Quantity<dim>::Array> result;
    for (const InternalVariable &variable : this->domain.material.internal_variables())
      result.push_back({variable.name, variable.n_components});
    return result;
  }

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    const auto &memory = point.state().memory.accepted;
    numbers.insert(numbers.end(), memory.begin(), memory.end());
  }
};

const bool registered =
    add_quantity<AllInternalVariables>("internal variables", "", "what laws remember at a point, by name");

} // namespace

} // namespace dovetail
