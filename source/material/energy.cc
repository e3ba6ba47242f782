// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A hyperelastic solid by its energy per undeformed volume, a formula of the invariants of C = F^T F:
//
//     W_e = W(I1, I2, I1_bar, I2_bar, J, T, x, y, z, t)
//     I1 = tr C,  I2 = (I1^2 - tr C^2)/2,  J = det F,  I1_bar = J^(-2/3) I1,  I2_bar = J^(-4/3) I2
//
// The formula is written in I1_bar, I2_bar and J and then differentiated exactly, up to the third order. At
// rest (I1 = I2 = 3, J = 1) the stress must vanish, and the moduli 2 (dW/dI1_bar + dW/dI2_bar) and d²W/dJ²
// must be positive. The terms of a formula may cancel at rest: the rounding of the stress is then that of the
// moduli, not that of the strain.
//
// Reference: Rivlin (1948); Holzapfel, Nonlinear Solid Mechanics (2000), section 6.2.
//
//     subsection Solid
//       set Type   = energy
//       set Energy = 0.5e6*(I1_bar - 3) + 0.02e6*(I2_bar - 3)^2 + 50e6*(J - 1)^2    # Pa
//     end

#include <dovetail/material/invariant_law.h>
#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/undefined.h>

#include <array>
#include <cmath>
#include <regex>

namespace dovetail {

class EnergyLaw : public InvariantLaw
{
public:
  explicit EnergyLaw(const Section &section)
      : as_written(section.require_expression(
            "Energy", {1},
            "W per undeformed volume, a formula of I1, I2, J and of I1_bar = J^(-2/3) I1, I2_bar "
            "= J^(-4/3) I2, T, x, y, z, t [Pa]",
            {"I1", "I2", "I1_bar", "I2_bar", "J", "T"})),
        W(section.documenting() ? "0" : in_isochoric_invariants(section.peek("Energy")),
          {section.dimension(), {"I1_bar", "I2_bar", "J", "T"}})
  {
    if (W.depends_on_position() || W.depends_on_time() || W.depends_on_scalar(3))
      add_formula({section, "Energy", W, W.depends_on_scalar(3), std::nullopt});
    if (section.documenting() || is_inhomogeneous())
      return;
    const std::string fault = fault_at_rest({});
    section.check(fault.empty(), "Energy", fault + ".");
  }

protected:
  bool is_defined(const Deformation &deformation) const override
  {
    if (!is_inhomogeneous() || deformation.place.derivative > 0)
      return true;
    const std::string fault = fault_at_rest(deformation.place);
    return fault.empty() ||
           undefined("at " + in_words(deformation.place.X) + " the Energy " + fault, !W.depends_on_scalar(3));
  }

  IsochoricEnergy isochoric(const IsochoricInvariants &invariants) const override
  {
    const AtPoint at = here(invariants);
    IsochoricEnergy result;
    result.W_1 = at({0}), result.W_2 = at({1});
    result.W_11 = at({0, 0}), result.W_12 = at({0, 1}), result.W_22 = at({1, 1});
    IsochoricEnergy::Mixed mixed;
    mixed.W_1J = at({0, 2}), mixed.W_2J = at({1, 2});
    if (invariants.with_third) {
      result.W_111 = at({0, 0, 0}), result.W_112 = at({0, 0, 1});
      result.W_122 = at({0, 1, 1}), result.W_222 = at({1, 1, 1});
      mixed.W_11J = at({0, 0, 2}), mixed.W_12J = at({0, 1, 2}), mixed.W_22J = at({1, 1, 2});
      mixed.W_1JJ = at({0, 2, 2}), mixed.W_2JJ = at({1, 2, 2});
    }
    result.mixed = mixed;
    return result;
  }

  VolumetricEnergy volumetric(const IsochoricInvariants &invariants) const override
  {
    const AtPoint at = here(invariants);
    return {at({2}), at({2, 2}), invariants.with_third ? at({2, 2, 2}) : 0};
  }

private:
  bool is_inhomogeneous() const { return !formulas().empty(); }

  /// What is wrong with the energy of a body at rest; empty: nothing.
  std::string fault_at_rest(const SolidLaw::Place &place) const
  {
    const AtPoint rest{*this, place, {{3, 3, 1, place.T}}};
    const double shear = 2 * (rest({0}) + rest({1})), bulk = rest({2, 2}), stress = rest({2});
    const std::string at_rest = " at rest (I1 = I2 = 3, J = 1)";
    if (!(shear > 0 && bulk > 0 && std::isfinite(shear + bulk)))
      return "has the shear modulus " + in_words(shear) + " and the bulk modulus " + in_words(bulk) +
             at_rest + ", but both must be positive";
    if (!(std::abs(stress) < 1e-9 * (shear + bulk)))
      return "has the stress " + in_words(stress) + at_rest +
             ": its derivative by J must vanish there, with I1 = 3 J^(2/3) and I2 = 3 J^(4/3)";
    for (const unsigned int a : {0, 1})
      for (const unsigned int b : {0, 1})
        if (!std::isfinite(rest({a, b})))
          return "has no second derivatives" + at_rest;
    return {};
  }

  /// Derivatives of W at one point.
  struct AtPoint
  {
    /// By the arguments of these numbers, and by T as often as the place asks for it.
    double operator()(std::vector<unsigned int> by) const
    {
      by.insert(by.end(), place.derivative, 3);
      return law.W.derivative(place.X, place.t, 0, {arguments.data(), arguments.size()}, by);
    }
    const EnergyLaw &law;
    const SolidLaw::Place place;
    const std::array<double, 4> arguments; ///< I1_bar, I2_bar, J, T
  };

  AtPoint here(const IsochoricInvariants &invariants) const
  {
    return {*this,
            invariants.place(),
            {{3 + invariants.first_minus_3(), 3 + invariants.second_minus_3(), invariants.J(),
              invariants.place().T}}};
  }

  static std::string in_isochoric_invariants(const std::string &text)
  {
    const std::string first = std::regex_replace(text, std::regex("\\bI1\\b"), "(J^(2/3)*I1_bar)");
    return std::regex_replace(first, std::regex("\\bI2\\b"), "(J^(4/3)*I2_bar)");
  }

  const Expression as_written; ///< for its error messages
  const Expression W;          ///< in I1_bar, I2_bar and J
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<EnergyLaw>(
    "energy", "Hyperelastic solid by its energy, a formula of the invariants of the deformation.");
}

} // namespace dovetail
