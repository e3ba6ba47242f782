// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Laws of the flux of a scalar at one point, in three dimensions (2D uses the upper left part).

#pragma once

#include <dovetail/scene/section.h>

#include <deal.II/base/array_view.h>
#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>

#include <optional>
#include <string>
#include <vector>

namespace dovetail {

/// What the law of a scalar sees: the values of all scalars of the material and the gradient of its own.
struct ScalarState
{
  dealii::Point<3> X;
  double t = 0;
  dealii::ArrayView<const double> scalars;
  unsigned int own = 0; ///< which of them is the law's
  dealii::Tensor<1, 3> G;

  double value() const { return scalars[own]; }
};

/// The influx A = A(scalars, G, X, t) of a scalar with gradient G, so that A.N goes into the body through its
/// outward normal N.
class ScalarLaw
{
public:
  virtual ~ScalarLaw() = default;

  struct Response
  {
    explicit Response(const unsigned int n_scalars) : by_scalar(n_scalars) {}
    dealii::Tensor<1, 3> A;                      ///< [W/m^2] of heat
    dealii::Tensor<2, 3> by_gradient;            ///< dA/dG, filled only if derivatives are asked for
    std::vector<dealii::Tensor<1, 3>> by_scalar; ///< dA/ds of each scalar s, likewise
  };

  /// Second derivatives of w.A.
  struct Curvature
  {
    explicit Curvature(const unsigned int n_scalars)
        : by_gradient_and_scalar(n_scalars), by_scalars(n_scalars * n_scalars, 0.)
    {
    }
    dealii::Tensor<2, 3> by_gradients;
    std::vector<dealii::Tensor<1, 3>> by_gradient_and_scalar;
    std::vector<double> by_scalars; ///< of scalars i and j at i * n_scalars + j
  };

  /// @return false if the flux is not defined at this state (for instance k not positive definite), with the
  /// reason left as scene/undefined.h says.
  virtual bool evaluate(const ScalarState &state, bool with_derivatives, Response &response) const = 0;
  virtual void curvature(const ScalarState &state, const dealii::Tensor<1, 3> &w,
                         Curvature &result) const = 0;

  virtual bool is_linear() const = 0;                       ///< A is linear in G and depends on no scalar
  virtual bool is_symmetric() const = 0;                    ///< dA/dG is
  virtual bool depends_on_scalar(unsigned int s) const = 0; ///< through its value
  virtual bool depends_on_time() const = 0;                 ///< through t itself
  /// K, if A = K G with the same K at every X, t and state: then evaluate() need not be asked there.
  virtual std::optional<dealii::Tensor<2, 3>> constant_gradient() const { return {}; }
};

/// Laws of heat conduction, `Type` in subsection Heat: constructed from their section and the names of the
/// scalars in formulas.
class HeatLaw : public ScalarLaw
{
};

/// Laws of diffusion, `Type` in a subsection Species: likewise.
class SpeciesLaw : public ScalarLaw
{
};

/// The variables of a law's formulas besides x, y, z, t.
using ScalarNames = std::vector<std::string>;

} // namespace dovetail
