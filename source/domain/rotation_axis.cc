// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rodrigues' formula.

#include <dovetail/domain/rotation_axis.h>
#include <dovetail/material/embedding.h>

#include <cmath>

namespace dovetail {

using dealii::Tensor;

template <int dim>
RotationAxis<dim>::RotationAxis(const Section &section)
{
  const bool is_axisymmetric = dim == 2 && section.top().peek("Geometry") == "axisymmetric";
  if (dim == 3)
    e = section.read_point("Axis", dealii::Point<3>(0, 0, 1), "Direction of the axis of the rotation [-]");
  else
    e[is_axisymmetric ? 1 : 2] = 1;
  section.check(e.norm() > 0, "Axis", "must not be zero.");
  e /= e.norm();
  if (!is_axisymmetric)
    point = section.read_point("Axis point", dealii::Point<3>(), "A point on the axis of the rotation [m]");
}

template <int dim>
Tensor<1, dim> RotationAxis<dim>::distance(const dealii::Point<dim> &X) const
{
  const Tensor<1, 3> d = embed(X) - point;
  return restrict_to<dim>(d - (d * e) * e);
}

template <int dim>
Tensor<2, dim> RotationAxis<dim>::projection() const
{
  Tensor<2, dim> result;
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int j = 0; j < dim; ++j)
      result[i][j] = (i == j ? 1 : 0) - e[i] * e[j];
  return result;
}

template <int dim>
Tensor<1, dim> RotationAxis<dim>::displacement(const dealii::Point<dim> &X, const double angle) const
{
  const Tensor<1, 3> r = embed(distance(X));
  const double half = std::sin(angle / 2);
  return restrict_to<dim>(std::sin(angle) * dealii::cross_product_3d(e, r) - 2 * half * half * r);
}

template class RotationAxis<2>;
template class RotationAxis<3>;

} // namespace dovetail
