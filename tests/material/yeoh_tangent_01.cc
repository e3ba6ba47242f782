// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The Yeoh solid against its energy.

#include "law_check.h"

struct Energy
{
  template <typename Number>
  Number operator()(const Matrix<Number> &F) const
  {
    const Matrix<Number> C = right_cauchy_green(F);
    const Number J = determinant_of(F), ln_J = log(J),
                 a = exp(-2. / 3. * ln_J) * (C[0][0] + C[1][1] + C[2][2]) - 3.;
    return 0.65 * a - 0.1 * a * a + 0.05 * a * a * a + 2.7 / 2 * (J - 1.) * (J - 1.);
  }
};

int main()
{
  check_solid(
      "Yeoh", Expanding<Energy>(),
      "set C10 = 0.65\nset C20 = -0.1\nset C30 = 0.05\nset Bulk modulus = 2.7\nset Volumetric = quadratic");
}
