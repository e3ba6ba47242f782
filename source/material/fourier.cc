// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Fourier's law of heat conduction: the heat into the body through its outward normal N is A.N with
//
//     A = K(T, X, t) grad T
//
// Reference: Carslaw & Jaeger, Conduction of Heat in Solids (1959), sections 1.3 and 1.17.
//
//     subsection Heat
//       set Type         = Fourier
//       set Conductivity = 15 * (1 + 0.001 * T)    # W/(m K)
//     end

#include <dovetail/material/gradient_law.h>
#include <dovetail/scene/catalogue.h>

namespace dovetail {

class Fourier : public GradientLaw<HeatLaw>
{
public:
  Fourier(const Section &section, const ScalarNames &scalars)
      : GradientLaw(section, "Conductivity",
                    "Thermal conductivity, which may depend on x, y, z, t and the temperature T: one "
                    "number, the diagonal, or the full tensor row by row [W/(m K)]",
                    scalars)
  {
  }
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<HeatLaw, const ScalarNames &>::add<Fourier>(
    "Fourier", "Heat flows down the gradient of the temperature; isotropic or anisotropic.");
}

} // namespace dovetail
