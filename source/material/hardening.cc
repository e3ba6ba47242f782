// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/hardening.h>

#include <cmath>
#include <limits>

namespace dovetail {

IsotropicHardening::IsotropicHardening(const Section &section)
    : yield_stress(section.require<double>("Yield stress",
                                           "Y_0 at the first yielding, in uniaxial tension "
                                           "[Pa]",
                                           Patterns::Double(1e-300))),
      linear(section.read<double>("Isotropic hardening modulus", 0,
                                  "K in Y = Y_0 + K a + ..., a the equivalent plastic strain [Pa]",
                                  Patterns::Double(0))),
      saturation(section.read<double>("Saturation stress", 0,
                                      "Y_inf, to which Voce's part of the yield stress grows; 0: no such "
                                      "part [Pa]",
                                      Patterns::Double(0))),
      rate(section.read<double>("Saturation exponent", 0, "r in 1 - exp(-r a) of Voce's part [-]",
                                Patterns::Double(0)))
{
  section.check(saturation == 0 || saturation >= yield_stress, "Saturation stress",
                "must not be less than the Yield stress: a material that softens has no unique state.");
  section.check((saturation == 0) == (rate == 0),
                saturation == 0 ? "Saturation exponent" : "Saturation stress",
                "needs Saturation " + std::string(saturation == 0 ? "stress" : "exponent") + " as well.");
}

double IsotropicHardening::strength(const double a) const
{
  const double voce = saturation > 0 ? saturation - yield_stress : 0;
  return yield_stress + linear * a - voce * std::expm1(-rate * a);
}

double IsotropicHardening::slope(const double a) const
{
  const double voce = saturation > 0 ? saturation - yield_stress : 0;
  return linear + voce * rate * std::exp(-rate * a);
}

double IsotropicHardening::find_flow(const double f, const double a, const double stiffness) const
{
  double flow = 0;
  for (unsigned int i = 0; i < 100; ++i) {
    const double now = a + root_of_two_thirds * flow;
    const double rest = f - stiffness * flow - root_of_two_thirds * (strength(now) - strength(a));
    const double next = flow + rest / (stiffness + 2. / 3. * slope(now));
    if (!(next > flow * (1 + std::numeric_limits<double>::epsilon())))
      break;
    flow = next;
  }
  return flow;
}

} // namespace dovetail
