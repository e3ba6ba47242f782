// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The Mooney-Rivlin solid against its energy.

#include "law_check.h"

struct Energy
{
  template <typename Number>
  Number operator()(const Matrix<Number> &F) const
  {
    const double C10 = 0.45, C01 = 0.2, kappa = 2.7;
    const Matrix<Number> C = right_cauchy_green(F);
    const Number J = determinant_of(F), tr_C = C[0][0] + C[1][1] + C[2][2], ln_J = log(J);
    Number tr_C2 = 0. * J;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        tr_C2 += C[i][j] * C[i][j];
    const Number I_1 = exp(-2. / 3. * ln_J) * tr_C, I_2 = exp(-4. / 3. * ln_J) * 0.5 * (tr_C * tr_C - tr_C2);
    return C10 * (I_1 - 3.) + C01 * (I_2 - 3.) + kappa / 4 * (J * J - 1. - 2. * ln_J);
  }
};

int main()
{
  check_solid("Mooney-Rivlin", Expanding<Energy>(), "set C10 = 0.45\nset C01 = 0.2\nset Bulk modulus = 2.7");
}
