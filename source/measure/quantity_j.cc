// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The ratio of deformed and undeformed volume, J = det F = det(I + grad u), for every law. Its integral over
// a domain is the volume of the deformed body (per thickness in 2D).
//
//     set Quantity = J

#include <dovetail/measure/quantity.h>

namespace dovetail {

namespace {

template <int dim>
class VolumeRatio : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    const dealii::Tensor<2, 3> I = dealii::unit_symmetric_tensor<3>();
    numbers.push_back(determinant(I + point.displacement_gradient()));
  }
};

const bool registered =
    add_quantity<VolumeRatio>("J", "displacement", "det F, deformed over undeformed volume [-]");

} // namespace

} // namespace dovetail
