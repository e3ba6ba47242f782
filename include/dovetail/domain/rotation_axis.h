// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// An axis about which something turns.

#pragma once

#include <dovetail/scene/section.h>

#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>

namespace dovetail {

/// The unit vector e of the entry Axis through the point of the entry Axis point; in 2D perpendicular to the
/// plane, or the axis of a body of revolution.
template <int dim>
class RotationAxis
{
public:
  explicit RotationAxis(const Section &section);

  /// From the axis to X: r = (1 - e e^T)(X - axis point).
  dealii::Tensor<1, dim> distance(const dealii::Point<dim> &X) const;
  dealii::Tensor<2, dim> projection() const; ///< dr/dX = 1 - e e^T
  /// (R(angle) - 1)(X - axis point) = sin(angle) e x r + (cos(angle) - 1) r (Rodrigues 1840)
  dealii::Tensor<1, dim> displacement(const dealii::Point<dim> &X, double angle) const;

private:
  dealii::Tensor<1, 3> e;
  dealii::Point<3> point;
};

} // namespace dovetail
