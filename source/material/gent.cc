// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rubber whose chains have a largest extension: with the first invariant of the deformation without change of
// volume (invariant_law.h),
//
//     W_e = -mu/2 J_m ln(1 - (I_1 - 3)/J_m) + kappa U(J)
//
// Not defined where I_1 - 3 reaches J_m. For J_m to infinity it is the neo-Hookean solid.
//
// Reference: Gent, Rubber Chem. Technol. 69 (1996) 59-61.
//
//     subsection Solid
//       set Type          = Gent
//       set Shear modulus = 0.3e6    # Pa
//       set Bulk modulus  = 100e6    # Pa
//       set Limit         = 100
//     end

#include <dovetail/material/invariant_law.h>
#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/undefined.h>

namespace dovetail {

class Gent : public InvariantLaw
{
public:
  explicit Gent(const Section &section)
      : moduli(*this, section), U(section, moduli),
        limit(section.require<double>(
            "Limit", "J_m, which the first invariant minus 3 cannot reach: 30 to 100 for rubber [-]",
            Patterns::Double(1e-300)))
  {
  }

  const Volumetric *volume() const override { return &U; }

protected:
  bool is_defined(const Deformation &deformation) const override
  {
    const double stretch = IsochoricInvariants{deformation}.first_minus_3();
    return stretch < limit || undefined("the first invariant minus 3 is " + in_words(stretch) +
                                        ", but must be less than the Limit " + in_words(limit));
  }

  IsochoricEnergy isochoric(const IsochoricInvariants &invariants) const override
  {
    const double rest = limit - invariants.first_minus_3();
    IsochoricEnergy W;
    W.W_1 = moduli.shear.at(invariants.place()) / 2 * limit / rest;
    W.W_11 = W.W_1 / rest;
    W.W_111 = 2 * W.W_11 / rest;
    return W;
  }

private:
  const VaryingModuli moduli;
  const Volumetric U;
  const double limit;
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<Gent>(
    "Gent", "Rubber-like solid for large strains whose chains have a largest extension.");
}

} // namespace dovetail
