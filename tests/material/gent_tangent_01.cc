// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The solid of Gent against its energy.

#include "law_check.h"

struct Energy
{
  template <typename Number>
  Number operator()(const Matrix<Number> &F) const
  {
    const Matrix<Number> C = right_cauchy_green(F);
    const Number J = determinant_of(F), ln_J = log(J),
                 a = exp(-2. / 3. * ln_J) * (C[0][0] + C[1][1] + C[2][2]) - 3.;
    return -1.3 / 2 * 20. * log(1. - a / 20.) + 2.7 / 2 * ln_J * ln_J;
  }
};

int main()
{
  check_solid("Gent", Expanding<Energy>(), moduli + "\nset Limit = 20\nset Volumetric = logarithmic");
}
