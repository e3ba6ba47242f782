// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A law by invariants whose energy has all second and third derivatives, against automatic differentiation:
//
//     W = 0.45 a + 0.2 b + 0.3 a^2 + 0.25 a b + 0.15 b^2 + 0.1 (a^3 + a^2 b + a b^2 + b^3),   a = I_1 - 3, b
//     = I_2 - 3

#include "law_check.h"

#include <dovetail/material/invariant_law.h>
#include <dovetail/scene/catalogue.h>

namespace {

class Polynomial : public InvariantLaw
{
public:
  explicit Polynomial(const Section &section) : U(section, require_bulk_modulus(section)) {}

protected:
  IsochoricEnergy isochoric(const IsochoricInvariants &invariants) const override
  {
    const double a = invariants.first_minus_3(), b = invariants.second_minus_3();
    return {0.45 + 0.6 * a + 0.25 * b + 0.1 * (3 * a * a + 2 * a * b + b * b),
            0.2 + 0.25 * a + 0.3 * b + 0.1 * (a * a + 2 * a * b + 3 * b * b),
            0.6 + 0.1 * (6 * a + 2 * b),
            0.25 + 0.1 * (2 * a + 2 * b),
            0.3 + 0.1 * (2 * a + 6 * b),
            0.6,
            0.2,
            0.2,
            0.6};
  }
  VolumetricEnergy volumetric(const IsochoricInvariants &invariants) const override
  {
    return U.at(invariants);
  }

private:
  const Volumetric U;
};

struct PolynomialEnergy
{
  template <typename Number>
  Number operator()(const Matrix<Number> &F) const
  {
    const double kappa = 2.7;
    const Matrix<Number> C = right_cauchy_green(F);
    const Number J = determinant_of(F), tr_C = C[0][0] + C[1][1] + C[2][2], ln_J = log(J);
    Number tr_C2 = 0. * J;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        tr_C2 += C[i][j] * C[i][j];
    const Number a = exp(-2. / 3. * ln_J) * tr_C - 3.,
                 b = exp(-4. / 3. * ln_J) * 0.5 * (tr_C * tr_C - tr_C2) - 3.;
    return 0.45 * a + 0.2 * b + 0.3 * a * a + 0.25 * a * b + 0.15 * b * b +
           0.1 * (a * a * a + a * a * b + a * b * b + b * b * b) + kappa / 4 * (J * J - 1. - 2. * ln_J);
  }
};

} // namespace

int main()
{
  Catalogue<SolidLaw>::add<Polynomial>("polynomial", "For this test.");
  check_solid("polynomial", Expanding<PolynomialEnergy>(), "set Bulk modulus = 2.7");
}
