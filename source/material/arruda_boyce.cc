// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rubber as a network of eight chains with Langevin's statistics, by five terms of the series in the first
// invariant of the deformation without change of volume (invariant_law.h),
//
//     W_e = m sum_i c_i/l^(2i - 2) (I_1^i - 3^i) + kappa U(J),   c = 1/2, 1/20, 11/1050, 19/7000, 519/673750
//
// where l is the locking stretch (the square root of the number of links of a chain) and m = n k T follows
// from the shear modulus of small strains, mu = m (1 + 3/(5 l^2) + 99/(175 l^4) + 513/(875 l^6) +
// 42039/(67375 l^8)).
//
// Reference: Arruda & Boyce, J. Mech. Phys. Solids 41 (1993) 389-412, eq. (21).
//
//     subsection Solid
//       set Type            = Arruda-Boyce
//       set Shear modulus   = 0.3e6    # Pa
//       set Bulk modulus    = 100e6    # Pa
//       set Locking stretch = 5
//     end

#include <dovetail/material/invariant_law.h>
#include <dovetail/scene/catalogue.h>

#include <array>
#include <cmath>

namespace dovetail {

class ArrudaBoyce : public InvariantLaw
{
public:
  explicit ArrudaBoyce(const Section &section)
      : moduli(*this, section), U(section, moduli),
        locking(section.require<double>("Locking stretch",
                                        "l, at which the chains are straight, greater than 1 [-]"))
  {
    section.check(locking > 1, "Locking stretch", "must be greater than 1.");
    double at_rest = 0; // dW/dI_1 of m = 1
    for (unsigned int i = 1; i <= 5; ++i)
      at_rest += factor(i) * i * std::pow(3, i - 1);
    network_per_shear = 1 / (2 * at_rest);
  }

  const Volumetric *volume() const override { return &U; }

protected:
  IsochoricEnergy isochoric(const IsochoricInvariants &invariants) const override
  {
    const double I = 3 + invariants.first_minus_3(),
                 m = network_per_shear * moduli.shear.at(invariants.place());
    IsochoricEnergy W;
    for (unsigned int i = 5; i >= 1; --i) { // Horner's scheme of the three derivatives
      const double c = m * factor(i) * i;
      W.W_1 = W.W_1 * I + c;
      if (i >= 2)
        W.W_11 = W.W_11 * I + c * (i - 1);
      if (i >= 3)
        W.W_111 = W.W_111 * I + c * (i - 1) * (i - 2);
    }
    return W;
  }

private:
  double factor(const unsigned int i) const
  {
    static const std::array<double, 5> c = {{1. / 2, 1. / 20, 11. / 1050, 19. / 7000, 519. / 673750}};
    return c[i - 1] / std::pow(locking, 2. * i - 2);
  }

  const VaryingModuli moduli;
  const Volumetric U;
  const double locking;
  double network_per_shear; ///< m/mu
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<ArrudaBoyce>(
    "Arruda-Boyce", "Rubber-like solid for large strains, a network of eight chains of limited length.");
}

} // namespace dovetail
