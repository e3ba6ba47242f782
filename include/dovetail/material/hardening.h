// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How the yield stress of a metal grows with its plastic strain.

#pragma once

#include <dovetail/scene/section.h>

namespace dovetail {

/// The yield stress over the equivalent plastic strain a (linear; Voce 1955),
/// @f[ Y = Y_0 + K a + (Y_\infty - Y_0)\,(1 - e^{-r a}). @f]
class IsotropicHardening
{
public:
  /// Reads `Yield stress`, `Isotropic hardening modulus`, `Saturation stress` and `Saturation exponent`.
  explicit IsotropicHardening(const Section &section);

  double strength(double a) const; ///< Y [Pa]
  double slope(double a) const;    ///< dY/da [Pa]

  /// The flow d gamma that returns a deviator to the yield surface, from the equivalent plastic strain @p a:
  /// the root of the convex, falling function
  /// @f[ f - s\,\Delta\gamma - \sqrt{2/3}\,(Y(a + \sqrt{2/3}\,\Delta\gamma) - Y(a)) @f]
  /// by Newton's method from 0, whose values grow until rounding ends that. @param f by how much the trial
  /// state violates the yield condition @param stiffness s: 2 mu, and 2/3 of a kinematic modulus
  double find_flow(double f, double a, double stiffness) const;

  static constexpr double root_of_two_thirds = 0.81649658092772603;

private:
  const double yield_stress, linear, saturation, rate;
};

} // namespace dovetail
