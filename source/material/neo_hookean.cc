// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rubber-like solid for large strains. With the invariant I_1 of the deformation without change of volume
// (invariant_law.h), J^(-2/3) tr C:
//
//     W_e = mu/2 (I_1 - 3) + kappa/4 (J^2 - 1 - 2 ln J)
//
// Reference: Simo & Taylor (1982) and Holzapfel, Nonlinear Solid Mechanics (2000), sections 6.4 and 6.5.
//
//     subsection Solid
//       set Type          = neo-Hookean
//       set Shear modulus = 0.4e6    # Pa
//       set Bulk modulus  = 2e6      # Pa
//     end

#include <dovetail/material/invariant_law.h>
#include <dovetail/scene/catalogue.h>

namespace dovetail {

class NeoHookean : public InvariantLaw
{
public:
  explicit NeoHookean(const Section &section) : moduli(*this, section), U(section, moduli) {}

  const Volumetric *volume() const override { return &U; }

protected:
  IsochoricEnergy isochoric(const IsochoricInvariants &invariants) const override
  {
    IsochoricEnergy W;
    W.W_1 = moduli.shear.at(invariants.place()) / 2;
    return W;
  }

private:
  const VaryingModuli moduli;
  const Volumetric U;
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<NeoHookean>(
    "neo-Hookean", "Rubber-like solid for large strains, with a separate resistance to changes of volume.");
}

} // namespace dovetail
