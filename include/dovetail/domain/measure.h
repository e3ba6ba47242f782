// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The measure of all integrals: what a domain in 2D is in the third direction.

#pragma once

#include <dovetail/material/term.h>
#include <dovetail/scene/section.h>

#include <deal.II/base/numbers.h>
#include <deal.II/fe/fe_values.h>

namespace dovetail {

/// dV = m(X) dX of cells and dA = m(X) dX of faces and interfaces, with m = 1 in 3D, the Thickness in plane
/// strain and plane stress, and 2 pi r in axisymmetry, where x = r is the radius and y the axis [m].
template <int dim>
class Measure
{
public:
  /// @param scene its Geometry and Thickness, which run/simulation.cc checks
  explicit Measure(const Section &scene);

  bool is_axisymmetric() const { return around_axis; }
  double thickness() const { return factor; }
  /// Whether a field has the strain u_r/r around the axis.
  bool has_hoop_strain(const Field &field) const { return around_axis && field.n_components > 1; }

  /// m(X).
  double operator()(const dealii::Point<dim> &X) const
  {
    return around_axis ? 2 * dealii::numbers::PI * X[0] : factor;
  }
  /// dV or dA at a point of a cell or face. @pre @p values has the update_flags().
  double operator()(const dealii::FEValuesBase<dim> &values, const unsigned int q) const
  {
    return values.JxW(q) * (around_axis ? (*this)(values.quadrature_point(q)) : factor);
  }
  dealii::UpdateFlags update_flags() const
  {
    return around_axis ? dealii::update_JxW_values | dealii::update_quadrature_points
                       : dealii::update_JxW_values;
  }

private:
  const bool around_axis;
  const double factor;
};

} // namespace dovetail
