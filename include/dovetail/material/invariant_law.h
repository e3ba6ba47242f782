// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Isotropic hyperelastic laws by the invariants of the deformation.

#pragma once

#include <dovetail/material/hyperelastic_law.h>

namespace dovetail {

/// The two invariants without change of volume minus 3, exact where they are small; computed when asked for.
struct IsochoricInvariants
{
  double first_minus_3() const;
  double second_minus_3() const;

  const Deformation &deformation;
};

/// The isochoric part of an energy by the two invariants without change of volume,
/// @f[ \bar I_1 = J^{-2/3} I_1,\quad \bar I_2 = J^{-4/3} I_2,\qquad I_1 = \mathrm{tr}\,C,\quad
///     I_2 = \tfrac12 (I_1^2 - \mathrm{tr}\,C^2). @f]
struct IsochoricEnergy
{
  double W_1 = 0, W_2 = 0;                           ///< dW/dI_1, dW/dI_2 [Pa]
  double W_11 = 0, W_12 = 0, W_22 = 0;               ///< second derivatives
  double W_111 = 0, W_112 = 0, W_122 = 0, W_222 = 0; ///< third derivatives
};

/// The volumetric part U(J).
struct VolumetricEnergy
{
  double U_1 = 0, U_2 = 0, U_3 = 0; ///< U', U'', U''' [Pa]
};

/// A hyperelastic solid with @f[ W_e = W(\bar I_1, \bar I_2) + U(J). @f] A member of the family gives the
/// derivatives of two functions of scalars; this class makes the tensors of them, once for all laws. With
/// C = I + 2E, Q = F^-T and N_k = dI_k/dF each invariant has the derivative
/// @f[ G = J^{-\beta}\,(N - \beta I\,Q),\qquad \beta = \tfrac23, \tfrac43, @f]
/// which is computed so that it vanishes with H = F - I term by term; see doc/theory/laws.md.
class InvariantLaw : public HyperelasticLaw
{
protected:
  virtual IsochoricEnergy isochoric(const IsochoricInvariants &invariants) const = 0;
  /// @p J_minus_1 is exact where it is small.
  virtual VolumetricEnergy volumetric(double J_minus_1) const = 0;

  void elastic_response(const Deformation &deformation, dealii::Tensor<2, 3> &P,
                        dealii::Tensor<4, 3> *D) const final;
  dealii::Tensor<4, 3> elastic_curvature(const Deformation &deformation,
                                         const dealii::Tensor<2, 3> &w) const final;
};

/// kappa/4 (J^2 - 1 - 2 ln J), the volumetric energy of Simo and Taylor (1982).
VolumetricEnergy simo_taylor(double kappa, double J_minus_1);

} // namespace dovetail
