// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The solid of Arruda and Boyce against its energy, with the shear modulus of small strains.

#include "law_check.h"

struct Energy
{
  template <typename Number>
  Number operator()(const Matrix<Number> &F) const
  {
    const Matrix<Number> C = right_cauchy_green(F);
    const Number J = determinant_of(F), ln_J = log(J),
                 a = exp(-2. / 3. * ln_J) * (C[0][0] + C[1][1] + C[2][2]) - 3.;
    const double l = 2.5, l2 = l * l, l4 = l2 * l2,
                 m = 1.3 /
                     (1 + 3 / (5 * l2) + 99 / (175 * l4) + 513 / (875 * l2 * l4) + 42039 / (67375 * l4 * l4));
    const Number I = a + 3.;
    return m * (I / 2. + I * I / (20 * l2) + 11 * I * I * I / (1050 * l4) +
                19 * I * I * I * I / (7000 * l2 * l4) + 519 * I * I * I * I * I / (673750 * l4 * l4)) +
           2.7 * (J - ln_J - 1.);
  }
};

int main()
{
  check_solid("Arruda-Boyce", Expanding<Energy>(),
              moduli + "\nset Locking stretch = 2.5\nset Volumetric = Miehe");
}
