// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A solid law whose coefficients or expansion are formulas.

#pragma once

#include <dovetail/material/coefficient.h>

#include <memory>
#include <optional>

namespace dovetail {

/// The free thermal strain @f[ e = \alpha\,(T - T_0), @f] where the secant coefficient alpha is a number or
/// a formula of x, y, z, t and T.
class ThermalStrain
{
public:
  /// Reads `Expansion coefficient` and `Reference temperature`.
  explicit ThermalStrain(const Section &section);

  bool is_zero() const { return is_none; }
  /// alpha, if it is a number.
  const std::optional<double> &constant_coefficient() const { return coefficient; }
  double reference_temperature() const { return reference; }
  /// e, or its derivative if the place asks for that.
  double at(const SolidLaw::Place &place) const { return strain.at(place); }
  bool depends_on_time() const { return is_of_time; }

private:
  bool is_none = false, is_of_time = false;
  std::optional<double> coefficient;
  double reference;
  Coefficient strain = 0;
};

/// A law P(H, e; m) with coefficients m and a free strain e that are formulas of the temperature, as a law of
/// H and T itself, which a SolidTerm hands over in the place of the thermal strain:
/// @f[ \frac{\partial P}{\partial T} = P_{,e}\,e' + P[m'] , \qquad P[m'] = P(H, e; m'), @f]
/// since the stress is linear in m, and likewise the second derivatives of w:P
/// @f[ (\cdot)_{FT} = (\cdot)_{Fe}\,e' + w:P[m']_{,F}, \qquad
///     (\cdot)_{TT} = (\cdot)_{ee}\,e'^2 + w:(P_{,e}\,e'' + 2 P[m']_{,e}\,e' + P[m'']). @f]
/// Where a coefficient leaves its range the law is not defined. Costs nothing in scenes without formulas,
/// which do without it.
class ThermalLaw : public SolidLaw
{
public:
  ThermalLaw(std::unique_ptr<SolidLaw> law, const ThermalStrain &strain);

  static bool is_needed(const SolidLaw &law, const ThermalStrain &strain)
  {
    return !law.formulas().empty() || !strain.constant_coefficient();
  }

  bool evaluate(const dealii::Tensor<2, 3> &H, double T, bool with_derivatives,
                Response &response) const override;
  Curvature curvature(const dealii::Tensor<2, 3> &H, double T, const dealii::Tensor<2, 3> &w,
                      const Place &place) const override;
  double energy(const dealii::Tensor<2, 3> &H, double T, const Place &place) const override;
  std::vector<InternalVariable> internal_variables() const override { return law->internal_variables(); }
  void pass(const Place &place) const override { law->pass(place); }
  bool has_curvature() const override { return law->has_curvature(); }
  /// Large strains: not without the thermal strain itself, which SolidTerm does not see here.
  std::optional<double> shear_of_flow() const override
  {
    return has_large_strain() ? std::nullopt : law->shear_of_flow();
  }
  bool has_expansion_work() const override { return law->has_expansion_work(); }
  bool expansion_work(const dealii::Tensor<2, 3> &H, double T, const dealii::Tensor<2, 3> &H_n,
                      const Place &place, ExpansionWork &work) const override;
  bool is_symmetric() const override { return law->is_symmetric(); }
  const Volumetric *volume() const override { return law->volume(); }
  bool is_linear() const override
  {
    return law->is_linear() && !has_coefficients_of_temperature && strain.constant_coefficient();
  }
  bool has_large_strain() const override { return law->has_large_strain(); }
  bool depends_on_time() const override { return law->depends_on_time() || strain.depends_on_time(); }

private:
  bool are_in_range(const Place &place) const;

  const std::unique_ptr<SolidLaw> law;
  const ThermalStrain strain;
  const bool has_coefficients_of_temperature;
};

} // namespace dovetail
