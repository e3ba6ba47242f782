// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// From a purely elastic energy W_e(F) to a law with free thermal strain, once for every hyperelastic law.

#pragma once

#include <dovetail/material/solid_law.h>

namespace dovetail {

/// What a purely elastic law sees: F = I + H, and what is small where H is, each to its own last digit.
struct Deformation
{
  explicit Deformation(const dealii::Tensor<2, 3> &H, const SolidLaw::Place &place = {});
  dealii::Tensor<2, 3> green_strain() const; ///< E = (H + H^T + H^T H)/2
  double trace_of_green_strain() const;

  const dealii::Tensor<2, 3> H;
  dealii::Tensor<2, 3> F;
  double J_minus_1; ///< of J = det F: the sum of the three invariants of H
  double J;
  const SolidLaw::Place place; ///< for formulas
};

/// T_abcd in the axes that are the columns of @p N, which need not be orthonormal: N_ia N_jb N_kc N_ld
/// T_abcd.
dealii::Tensor<4, 3> turned(dealii::Tensor<4, 3> T, const dealii::Tensor<2, 3> &N);

/// A solid with the energy @f[ W(F, e) = s^3 W_e(F/s), \quad s = 1 + e, @f] per volume at the reference
/// temperature: the multiplicative split F = F_e s of Stojanovic, Djuric & Vujosevic (1964). F = s I is free
/// of stress for every e. A member of the family gives P_e = dW_e/dF and two more derivatives; this class
/// turns them into P = s^2 P_e(F/s) and its exact derivatives by F and e.
class HyperelasticLaw : public SolidLaw
{
public:
  bool evaluate(const dealii::Tensor<2, 3> &H, double e, bool with_derivatives,
                Response &response) const final;
  Curvature curvature(const dealii::Tensor<2, 3> &H, double e, const dealii::Tensor<2, 3> &w,
                      const Place &place) const final;

protected:
  /// Whether the energy is finite; else the reason is left.
  virtual bool is_defined(const Deformation & /*deformation*/) const { return true; }
  /// P = dW_e/dF and, unless @p D is nullptr, D = d²W_e/dF² (every entry of it). P must vanish with H, and so
  /// must its rounding. @pre J = det F > 0.
  virtual void elastic_response(const Deformation &deformation, dealii::Tensor<2, 3> &P,
                                dealii::Tensor<4, 3> *D) const = 0;
  /// d²(w:P)/dF² for the same P. @pre J = det F > 0.
  virtual dealii::Tensor<4, 3> elastic_curvature(const Deformation &deformation,
                                                 const dealii::Tensor<2, 3> &w) const = 0;

  /// Of a law that gives S = F^-1 P by E, C = dS/dE: D_iJkL += A_iM B_kN C_MJNL, where A = B = F gives that
  /// part of dP/dF.
  static void add_material_stiffness(const dealii::Tensor<2, 3> &A, const dealii::Tensor<2, 3> &B,
                                     const dealii::Tensor<4, 3> &C, dealii::Tensor<4, 3> &D);
  /// And the other part: D_iJkL += delta_ik S_JL.
  static void add_geometric_stiffness(const dealii::Tensor<2, 3> &S, dealii::Tensor<4, 3> &D);
};

} // namespace dovetail
