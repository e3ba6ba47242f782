// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The fields of a domain, each under its own name.
//
//     set Fields = solution

#include <dovetail/measure/quantity.h>

namespace dovetail {

namespace {

template <int dim>
class Solution : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  std::vector<typename Quantity<dim>::Array> arrays() const override
  {
    std::vector<typename Quantity<dim>::Array> result;
    for (const Field &field : this->domain.fields())
      result.push_back({field.name, field.n_components});
    return result;
  }

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    const std::vector<double> &B = point.state().value;
    numbers.insert(numbers.end(), B.begin(), B.end());
  }
};

const bool registered = add_quantity<Solution>("solution", "", "all fields of the domain, by name");

} // namespace

} // namespace dovetail
