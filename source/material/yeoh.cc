// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rubber that becomes stiffer at large strain: a polynomial of the first invariant of the deformation without
// change of volume (invariant_law.h),
//
//     W_e = C10 (I_1 - 3) + C20 (I_1 - 3)^2 + C30 (I_1 - 3)^3 + kappa U(J)
//
// The shear modulus of small strains is 2 C10. Simple tension, shear and biaxial tension follow from a fit to
// one of them better than with two coefficients of Mooney and Rivlin.
//
// Reference: Yeoh, Rubber Chem. Technol. 63 (1990) 792-805; Holzapfel, Nonlinear Solid Mechanics (2000),
// section 6.5.
//
//     subsection Solid
//       set Type         = Yeoh
//       set C10          = 0.5e6      # Pa
//       set C20          = -0.02e6    # Pa
//       set C30          = 0.001e6    # Pa
//       set Bulk modulus = 100e6      # Pa
//     end

#include <dovetail/material/invariant_law.h>
#include <dovetail/scene/catalogue.h>

namespace dovetail {

class Yeoh : public InvariantLaw
{
public:
  explicit Yeoh(const Section &section)
      : C10(section.require<double>("C10", "Coefficient of the first invariant minus 3 [Pa]")),
        C20(section.read<double>("C20", 0, "Coefficient of its square [Pa]")),
        C30(section.read<double>("C30", 0, "Coefficient of its third power [Pa]")),
        U(section, require_bulk_modulus(section))
  {
    section.check(C10 > 0, "C10", "must be positive: half of the shear modulus of small strains.");
  }

  const Volumetric *volume() const override { return &U; }

protected:
  IsochoricEnergy isochoric(const IsochoricInvariants &invariants) const override
  {
    const double a = C20 == 0 && C30 == 0 ? 0 : invariants.first_minus_3();
    IsochoricEnergy W;
    W.W_1 = C10 + a * (2 * C20 + 3 * C30 * a);
    W.W_11 = 2 * C20 + 6 * C30 * a;
    W.W_111 = 6 * C30;
    return W;
  }
  VolumetricEnergy volumetric(const IsochoricInvariants &invariants) const override
  {
    return U.at(invariants);
  }

private:
  const double C10, C20, C30;
  const Volumetric U;
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<Yeoh>(
    "Yeoh",
    "Rubber-like solid for large strains, by a polynomial of the first invariant of the deformation.");
}

} // namespace dovetail
