// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Metals whose inelastic strain changes no volume, for small displacements.

#pragma once

#include <dovetail/material/invariant_law.h>
#include <dovetail/material/solid_law.h>

namespace dovetail {

/// With eps = sym(H), the inelastic strain eps_p of trace zero and the free thermal strain e,
/// @f[ P = \kappa\,(\mathrm{tr}\,\varepsilon - 3e)\,I + 2\mu\,(\mathrm{dev}\,\varepsilon - \varepsilon_p).
/// @f] A member of the family says how eps_p grows. Its nine components, row by row, are the first that it
/// remembers.
class IsochoricFlow : public SolidLaw
{
public:
  /// The part that unloading gives back.
  double energy(const dealii::Tensor<2, 3> &H, double e, const Place &place) const final;

  bool has_large_strain() const final { return false; }
  bool has_expansion_work() const final { return true; } // dP/de is constant
  const Volumetric *volume() const final { return &U; }
  std::optional<double> shear_of_flow() const final { return moduli.shear; }

protected:
  explicit IsochoricFlow(const Section &section) : moduli(section), U(Volumetric::quadratic(moduli)) {}

  /// dev P if the inelastic strain were still @p eps_p [Pa]
  dealii::Tensor<2, 3> deviator(const dealii::Tensor<2, 3> &H, const double *eps_p) const;

  /// Sets P. @return whether it is finite
  bool set_stress(const dealii::Tensor<2, 3> &deviator, const dealii::Tensor<2, 3> &H, double e,
                  Response &response) const;

  /// Sets dP/de and
  /// @f[ D = \kappa\,I\otimes I + 2\mu\,(c\,\mathrm{dev} + (s - c)\,n\otimes n). @f]
  /// @param n direction of the deviator that flows, of norm 1 (of no meaning where c = s)
  /// @param c, s by which flow reduces 2 mu across and along n [-]; both are 1 where nothing flows
  void set_derivatives(const dealii::Tensor<2, 3> &n, double c, double s, Response &response) const;

  const IsotropicModuli moduli;

private:
  const Volumetric U;
};

} // namespace dovetail
