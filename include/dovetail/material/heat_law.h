// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Laws of heat conduction at one point, in three dimensions (2D uses the upper left part).

#pragma once

#include <dovetail/scene/section.h>

#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>

namespace dovetail {

/// The influx A = k(T, X, t) grad T, so that A.N is the heat into the body through its outward normal N.
class HeatLaw
{
public:
  virtual ~HeatLaw() = default;

  struct Response
  {
    dealii::Tensor<1, 3> A; ///< [W/m^2]
    dealii::Tensor<2, 3>
        dA_dG; ///< derivative by the gradient G = grad T, filled only if derivatives are asked for
    dealii::Tensor<1, 3> dA_dT; ///< likewise by the temperature
  };

  /// Second derivatives of the scalar w.A(T, G).
  struct Curvature
  {
    dealii::Tensor<2, 3> GG;
    dealii::Tensor<1, 3> GT;
    double TT = 0;
  };

  /// @return false if the flux is not defined at this state (for instance k not positive definite).
  virtual bool evaluate(const dealii::Point<3> &X, double t, double T, const dealii::Tensor<1, 3> &G,
                        bool with_derivatives, Response &response) const = 0;
  virtual Curvature curvature(const dealii::Point<3> &X, double t, double T, const dealii::Tensor<1, 3> &G,
                              const dealii::Tensor<1, 3> &w) const = 0;

  virtual bool is_linear() const = 0;       ///< A is linear in (T, G)
  virtual bool is_symmetric() const = 0;    ///< dA_dG is symmetric and dA_dT vanishes
  virtual bool depends_on_time() const = 0; ///< through t itself
};

} // namespace dovetail
