// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// From a purely elastic energy W_e(F) to a law with free thermal strain, once for every hyperelastic law.

#pragma once

#include <dovetail/material/solid_law.h>

namespace dovetail {

/// A solid with the energy @f[ W(F, e) = s^3 W_e(F/s), \quad s = 1 + e, @f] per volume at the reference
/// temperature: the multiplicative split F = F_e s of Stojanovic, Djuric & Vujosevic (1964). F = s I is free
/// of stress for every e. A member of the family gives P_e = dW_e/dF and two more derivatives; this class
/// turns them into P = s^2 P_e(F/s) and its exact derivatives by F and e.
class HyperelasticLaw : public SolidLaw
{
public:
  bool evaluate(const dealii::Tensor<2, 3> &F, double e, bool with_derivatives,
                Response &response) const final;
  Curvature curvature(const dealii::Tensor<2, 3> &F, double e, const dealii::Tensor<2, 3> &w) const final;

protected:
  /// P = dW_e/dF and, unless @p D is nullptr, D = d²W_e/dF² (every entry of it). @pre J = det F > 0.
  virtual void elastic_response(const dealii::Tensor<2, 3> &F, double J, dealii::Tensor<2, 3> &P,
                                dealii::Tensor<4, 3> *D) const = 0;
  /// d²(w:P)/dF² for the same P. @pre J = det F > 0.
  virtual dealii::Tensor<4, 3> elastic_curvature(const dealii::Tensor<2, 3> &F, double J,
                                                 const dealii::Tensor<2, 3> &w) const = 0;
};

} // namespace dovetail
