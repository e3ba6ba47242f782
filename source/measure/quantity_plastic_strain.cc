// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a law that yields remembers, each under its own name: zero where a body has no such law.
//
//     set Fields = solution, plastic strain, equivalent plastic strain

#include <dovetail/measure/quantity.h>

#include <optional>

namespace dovetail {

namespace {

/// The internal variable with the name of the quantity and @p n components.
template <int dim, unsigned int n>
class OneInternalVariable : public Quantity<dim>
{
public:
  OneInternalVariable(const std::string &name, const Domain<dim> &domain) : Quantity<dim>(name, domain)
  {
    unsigned int position = 0;
    for (const InternalVariable &variable : domain.material.internal_variables()) {
      if (variable.name == name && variable.n_components == n)
        first = position;
      position += variable.n_components;
    }
  }

  unsigned int n_components() const override { return n; }

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    if (!first) {
      numbers.insert(numbers.end(), n, 0.);
      return;
    }
    const double *const values = point.state().memory.accepted.data() + *first;
    numbers.insert(numbers.end(), values, values + n);
  }

private:
  std::optional<unsigned int> first;
};

template <int dim>
using InternalNumber = OneInternalVariable<dim, 1>;
template <int dim>
using InternalTensor = OneInternalVariable<dim, 9>;

const bool plastic_strain =
    add_quantity<InternalTensor>("plastic strain", "displacement", "3 x 3 also in 2D; 0 without it [-]");
const bool equivalent_plastic_strain = add_quantity<InternalNumber>(
    "equivalent plastic strain", "displacement", "integral of (2/3 d eps_p : d eps_p)^1/2; 0 without it [-]");
const bool back_stress =
    add_quantity<InternalTensor>("back stress", "displacement", "3 x 3 also in 2D; 0 without it [Pa]");

} // namespace

} // namespace dovetail
