// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The neo-Hookean solid against its energy.

#include "law_check.h"

struct Energy
{
  template <typename Number>
  Number operator()(const Matrix<Number> &F) const
  {
    const double mu = 1.3, kappa = 2.7;
    const Matrix<Number> C = right_cauchy_green(F);
    const Number J = determinant_of(F), tr_C = C[0][0] + C[1][1] + C[2][2], ln_J = log(J);
    return mu / 2 * (exp(-2. / 3. * ln_J) * tr_C - 3.) + kappa / 4 * (J * J - 1. - 2. * ln_J);
  }
};

int main()
{
  check_solid("neo-Hookean", Expanding<Energy>());
}
