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
      : C10(*this, section, "C10", "Coefficient of the first invariant minus 3 [Pa]",
            Coefficient::positive()),
        C20(*this, section, "C20", "Coefficient of its square [Pa]", Coefficient::any(), "0"),
        C30(*this, section, "C30", "Coefficient of its third power [Pa]", Coefficient::any(), "0"),
        U(*this, section)
  {
  }

  const Volumetric *volume() const override { return &U; }

protected:
  IsochoricEnergy isochoric(const IsochoricInvariants &invariants) const override
  {
    const auto &place = invariants.place();
    const double c_2 = C20.at(place), c_3 = C30.at(place), a = invariants.first_minus_3();
    IsochoricEnergy W;
    W.W_1 = C10.at(place) + a * (2 * c_2 + 3 * c_3 * a);
    W.W_11 = 2 * c_2 + 6 * c_3 * a;
    W.W_111 = 6 * c_3;
    return W;
  }

private:
  const Coefficient C10, C20, C30;
  const Volumetric U;
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<Yeoh>(
    "Yeoh",
    "Rubber-like solid for large strains, by a polynomial of the first invariant of the deformation.");
}

} // namespace dovetail
