// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// One name for the quadrature rules of all cell and face shapes.

#pragma once

#include <deal.II/base/exceptions.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/grid/reference_cell.h>

namespace dovetail {

/// A symmetric rule that is exact for polynomials of degree 2 n - 1: per direction on lines, quadrilaterals
/// and hexahedra (Gauss, n points per direction), in total on triangles and tetrahedra (Witherden and
/// Vincent, 2015; beyond their n <= 7 and 5 Gauss points in collapsed coordinates).
template <int structdim>
dealii::Quadrature<structdim> gauss_rule(const dealii::ReferenceCell &cell, const unsigned int n)
{
  if (cell.is_hyper_cube())
    return dealii::QGauss<structdim>(n);
  AssertThrow(cell.is_simplex(), dealii::ExcNotImplemented());
  if constexpr (structdim == 1)
    return dealii::QGauss<1>(n);
  else {
    if (n <= (structdim == 2 ? 7 : 5))
      return dealii::QWitherdenVincentSimplex<structdim>(n);
    // X_d = u_d times what is left of the unit length; one more point for the Jacobian
    const dealii::QGauss<structdim> cube(n + 1);
    std::vector<dealii::Point<structdim>> points;
    std::vector<double> weights;
    for (unsigned int q = 0; q < cube.size(); ++q) {
      dealii::Point<structdim> X;
      double rest = 1, jacobian = 1;
      for (unsigned int d = 0; d < structdim; ++d) {
        X[d] = cube.point(q)[d] * rest;
        jacobian *= rest;
        rest -= X[d];
      }
      points.push_back(X);
      weights.push_back(cube.weight(q) * jacobian);
    }
    return dealii::Quadrature<structdim>(points, weights);
  }
}

} // namespace dovetail
