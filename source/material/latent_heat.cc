// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The heat of melting, H = L f(T), with the liquid fraction f, which grows from 0 at the solidus T_s to 1 at
// the liquidus T_l: with s = (T - T_s)/(T_l - T_s) between 0 and 1,
//
//     linear: f = s      smooth: f = s^2 (3 - 2 s)
//
// Reference: Voller, International Journal for Numerical Methods in Engineering 24 (1987), 271.
//
//     subsection Heat
//       set Latent heat = 397e3    # J/kg, aluminium
//       set Solidus     = 930      # K
//       set Liquidus    = 936
//     end

#include <dovetail/material/content.h>

#include <algorithm>
#include <string>
#include <utility>

namespace dovetail {

namespace {

class LatentHeat : public Content
{
public:
  LatentHeat(const double heat, const double solidus, const double liquidus, const bool is_smooth)
      : Content("Latent heat"), heat(heat), solidus(solidus), liquidus(liquidus), is_smooth(is_smooth)
  {
  }

  double change(const ScalarState &state, const double from) const override
  {
    const double T = std::clamp(state.value(), solidus, liquidus), T_0 = std::clamp(from, solidus, liquidus),
                 s = share(T), r = share(T_0), grown = (T - T_0) / (liquidus - solidus);
    return heat * grown * (is_smooth ? 3 * (s + r) - 2 * (s * s + s * r + r * r) : 1);
  }
  double capacity(const ScalarState &state) const override
  {
    const double s = share(state.value());
    if (s <= 0 || s >= 1)
      return 0;
    return heat / (liquidus - solidus) * (is_smooth ? 6 * s * (1 - s) : 1);
  }
  double slope_of_change(const ScalarState & /*state*/, double /*from*/, unsigned int /*s*/) const override
  {
    return 0;
  }

  bool is_linear() const override { return false; }
  bool depends_on_scalar(unsigned int /*s*/) const override { return false; }
  bool depends_on_time() const override { return false; }
  bool depends_on_position() const override { return false; }
  double liquid_fraction(const ScalarState &state) const override { return fraction(state.value()); }

private:
  double share(const double T) const { return (T - solidus) / (liquidus - solidus); }
  double fraction(const double T) const
  {
    const double s = std::min(1., std::max(0., share(T)));
    return is_smooth ? s * s * (3 - 2 * s) : s;
  }

  const double heat, solidus, liquidus;
  const bool is_smooth;
};

} // namespace

std::unique_ptr<const Content> read_latent_heat(const Section &section)
{
  const double heat =
      section.read<double>("Latent heat", 0, "Heat of melting per mass, for transient scenes [J/kg]");
  const double solidus =
      section.read<double>("Solidus", 0, "Temperature at which melting begins, with Latent heat [K]");
  const double liquidus = section.read<double>(
      "Liquidus", 0, "Temperature at which melting ends, above the Solidus, with Latent heat [K]");
  const bool is_smooth = section.choose("Melting", {"linear", "smooth"}, 0,
                                        "How the liquid fraction grows from Solidus to Liquidus [-]") == 1;
  section.check(heat >= 0, "Latent heat", "must be positive (or 0: nothing melts).");
  if (heat == 0) {
    for (const auto &[entry, value] : {std::pair("Solidus", solidus), std::pair("Liquidus", liquidus)})
      section.check(value == 0, entry, "belongs to Latent heat, which is zero or not given. Set that, too.");
    return nullptr;
  }
  for (const std::string entry : {"Solidus", "Liquidus"})
    section.check(section.is_set(entry), "Latent heat",
                  "needs the temperatures between which the material melts: set Solidus and Liquidus.");
  section.check(solidus < liquidus, "Liquidus",
                "must be higher than the Solidus. For a pure substance set both a little beside its melting "
                "point, for instance a hundredth of the temperature differences in the body apart.");
  return std::make_unique<LatentHeat>(heat, solidus, liquidus, is_smooth);
}

} // namespace dovetail
