// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Fick's law of diffusion: the amount of a species with concentration c that goes into the body through its
// outward normal N is A.N with
//
//     A = D(scalars, X, t) grad c
//
// Reference: Crank, The Mathematics of Diffusion (1975), sections 1.2 and 1.4.
//
//     set Species = carbon
//     subsection Species carbon
//       set Type        = Fick
//       set Diffusivity = 1e-11 * exp(-18000/T)    # m^2/s, of a material with a heat law
//     end

#include <dovetail/material/gradient_law.h>
#include <dovetail/scene/catalogue.h>

namespace dovetail {

class Fick : public GradientLaw<SpeciesLaw>
{
public:
  Fick(const Section &section, const ScalarNames &scalars)
      : GradientLaw(
            section, "Diffusivity",
            "Diffusivity, which may depend on x, y, z, t and every scalar of the material: one number, the "
            "diagonal, or the full tensor row by row [m^2/s]",
            scalars)
  {
  }
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SpeciesLaw, const ScalarNames &>::add<Fick>(
    "Fick", "The species diffuses down the gradient of its concentration; isotropic or anisotropic.");
}

} // namespace dovetail
