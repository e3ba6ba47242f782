// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Radiation of a grey surface to black surroundings (Stefan 1879; Boltzmann 1884): with absolute temperatures
// theta = T + offset,
//
//     A.N = c (theta_ambient^4 - theta^4),   c = emissivity times 5.670374e-8 W/(m^2 K^4)
//
// For iterates below the absolute zero, theta^4 continues as theta |theta|^3, which grows everywhere.
//
//     subsection Boundary condition glow
//       set Type         = radiation
//       set Field        = temperature
//       set Boundary ids = 2
//       set Coefficient  = 0.98*5.670374e-8
//       set Ambient      = 20
//       set Offset       = 273.15             # the field is in degrees Celsius
//     end

#include <dovetail/domain/surface_exchange.h>

#include <cmath>

namespace dovetail {

namespace {

template <int dim>
class Radiation : public SurfaceExchange<dim>
{
public:
  Radiation(const Section &section, const Material<dim> &material, const Toggles &toggles)
      : SurfaceExchange<dim>(
            section, material, toggles,
            "Emissivity times the Stefan-Boltzmann constant 5.670374e-8; it may depend on x, y, "
            "z, t and the field, for a temperature T [W/(m^2 K^4)]",
            "The temperature of the surroundings, in the units of the field [K]"),
        offset(section.read<double>(
            "Offset", 0,
            "Added to the field it gives the absolute temperature; 273.15 for degrees Celsius [K]"))
  {
  }

  double potential(const double T) const override
  {
    const double theta = T + offset;
    return theta * std::pow(std::abs(theta), 3);
  }
  double slope(const double T) const override { return 4 * std::pow(std::abs(T + offset), 3); }

  bool is_linear() const override { return false; }
  bool has_constant_tangent() const override { return false; }

private:
  const double offset;
};

const bool registered = add_condition<Radiation>(
    "radiation", "Radiation to surroundings, Coefficient ((Ambient + Offset)^4 - (T + Offset)^4).");

} // namespace

} // namespace dovetail
