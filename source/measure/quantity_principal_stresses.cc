// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The eigenvalues of the Cauchy stress, sigma n = sigma_i n, the largest (most tensile) first; three scalars.
// By Jacobi's method (1846): the closed formula of the cubic loses half of the digits of equal stresses.
//
//     set Quantity = principal stresses

#include <dovetail/measure/quantity.h>

#include <cmath>
#include <limits>

namespace dovetail {

namespace {

template <int dim>
class PrincipalStresses : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  std::vector<typename Quantity<dim>::Array> arrays() const override
  {
    return {{"principal stress 1", 1}, {"principal stress 2", 1}, {"principal stress 3", 1}};
  }

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    const dealii::SymmetricTensor<2, 3> sigma = symmetrize(point.cauchy_stress());
    if (!std::isfinite(sigma.norm())) {
      numbers.insert(numbers.end(), 3, std::numeric_limits<double>::quiet_NaN());
      return;
    }
    for (const auto &pair : eigenvectors(sigma, dealii::SymmetricTensorEigenvectorMethod::jacobi))
      numbers.push_back(pair.first);
  }
};

const bool registered = add_quantity<PrincipalStresses>(
    "principal stresses", "displacement", "the eigenvalues of the Cauchy stress, the largest first [Pa]");

} // namespace

} // namespace dovetail
