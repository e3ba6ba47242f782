// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The force per deformed area, sigma = P F^T / det F (Cauchy 1823); P itself for a linear law, which knows no
// deformed area. Nine components row by row, three-dimensional also in plane strain; NaN where the law is not
// defined.
//
//     set Quantity = Cauchy stress

#include <dovetail/measure/quantity.h>

namespace dovetail {

namespace {

template <int dim>
class CauchyStress : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  unsigned int n_components() const override { return 9; }

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    const dealii::Tensor<2, 3> &sigma = point.cauchy_stress();
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        numbers.push_back(sigma[i][j]);
  }
};

const bool registered =
    add_quantity<CauchyStress>("Cauchy stress", "displacement",
                               "sigma = P F^T/J, 3 x 3 also in 2D; P for a law of small displacements [Pa]");

} // namespace

} // namespace dovetail
