// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The strain, thermal strain included, with H = grad u: that of Green and Lagrange (Green 1841)
//
//     E = (F^T F - I)/2 = (H + H^T + H^T H)/2
//
// for a law of large strain, the small strain (H + H^T)/2 for another, which knows no other. Nine components
// row by row, three-dimensional also in plane strain.
//
//     set Quantity = strain

#include <dovetail/measure/quantity.h>

namespace dovetail {

namespace {

template <int dim>
class Strain : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  unsigned int n_components() const override { return 9; }

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    const dealii::Tensor<2, 3> H = point.displacement_gradient();
    dealii::Tensor<2, 3> E = (H + transpose(H)) / 2;
    if (this->domain.material.has_large_strain())
      E += transpose(H) * H / 2;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        numbers.push_back(E[i][j]);
  }
};

const bool registered = add_quantity<Strain>(
    "strain", "displacement",
    "E = (F^T F - I)/2, for a law of small displacements (grad u + grad u^T)/2, 3 x 3 also in 2D [-]");

} // namespace

} // namespace dovetail
