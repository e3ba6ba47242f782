// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Exchange with a surrounding fluid (Newton's law of cooling): A.N = h(T, X, t) (T_ambient - T).
//
//     subsection Boundary condition hot gas
//       set Type         = convection
//       set Field        = temperature
//       set Boundary ids = 2
//       set Coefficient  = 1500 + 0.2*T
//       set Ambient      = 1300
//     end

#include <dovetail/domain/surface_exchange.h>

namespace dovetail {

namespace {

template <int dim>
class Convection : public SurfaceExchange<dim>
{
public:
  Convection(const Section &section, const Material<dim> &material, const Toggles &toggles)
      : SurfaceExchange<dim>(section, material, toggles,
                             "The heat transfer coefficient h, which may depend on x, y, z, t and the field, "
                             "for a temperature T [W/(m^2 K)]",
                             "The temperature of the surroundings [K]")
  {
  }

  double potential(const double T) const override { return T; }
  double slope(double /*T*/) const override { return 1; }
};

const bool registered =
    add_condition<Convection>("convection", "Heat exchange with a fluid, h (Ambient - T).");

} // namespace

} // namespace dovetail
