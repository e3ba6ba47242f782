// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rubber whose stiffness in shear and in extension differ. With the invariants I_1 and I_2 of the deformation
// without change of volume (invariant_law.h):
//
//     W_e = C10 (I_1 - 3) + C01 (I_2 - 3) + kappa/4 (J^2 - 1 - 2 ln J)
//
// The shear modulus of small strains is 2 (C10 + C01); C01 = 0 is the neo-Hookean solid.
//
// Reference: Mooney (1940), Rivlin (1948); Holzapfel, Nonlinear Solid Mechanics (2000), section 6.5.
//
//     subsection Solid
//       set Type         = Mooney-Rivlin
//       set C10          = 0.16e6    # Pa
//       set C01          = 0.04e6    # Pa
//       set Bulk modulus = 2e6       # Pa
//     end

#include <dovetail/material/invariant_law.h>
#include <dovetail/scene/catalogue.h>

namespace dovetail {

class MooneyRivlin : public InvariantLaw
{
public:
  explicit MooneyRivlin(const Section &section)
      : C10(*this, section, "C10", "Coefficient of the first invariant minus 3 [Pa]",
            Coefficient::not_negative()),
        C01(*this, section, "C01", "Coefficient of the second invariant minus 3 [Pa]",
            Coefficient::not_negative()),
        U(*this, section)
  {
    section.check(!C10.is_constant() || !C01.is_constant() || C10.at({}) + C01.at({}) > 0, "C10",
                  "and C01 are zero, but their sum must be positive.");
  }

  const Volumetric *volume() const override { return &U; }

protected:
  IsochoricEnergy isochoric(const IsochoricInvariants &invariants) const override
  {
    IsochoricEnergy W;
    W.W_1 = C10.at(invariants.place());
    W.W_2 = C01.at(invariants.place());
    return W;
  }

private:
  const Coefficient C10, C01;
  const Volumetric U;
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<MooneyRivlin>(
    "Mooney-Rivlin", "Rubber-like solid for large strains, by both invariants of the deformation.");
}

} // namespace dovetail
