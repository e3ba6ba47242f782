// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The rank that owns a cell: the one number that is not the same on any number of ranks.
//
//     set Fields = solution, rank

#include <dovetail/measure/quantity.h>

namespace dovetail {

namespace {

template <int dim>
class Rank : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    numbers.push_back(point.cell()->subdomain_id());
  }
};

const bool registered = add_quantity<Rank>("rank", "", "the rank that owns a cell [-]");

} // namespace

} // namespace dovetail
