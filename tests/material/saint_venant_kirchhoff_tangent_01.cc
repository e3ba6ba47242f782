// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The Saint Venant-Kirchhoff solid against its energy.

#include "law_check.h"

struct Energy
{
  template <typename Number>
  Number operator()(const Matrix<Number> &F) const
  {
    const double mu = 1.3, lambda = 2.7 - 2. / 3. * mu;
    const Matrix<Number> C = right_cauchy_green(F);
    const Number tr_E = 0.5 * (C[0][0] + C[1][1] + C[2][2] - 3.);
    Number E_E = 0.;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j) {
        const Number E_ij = 0.5 * (C[i][j] - (i == j ? 1. : 0.));
        E_E += E_ij * E_ij;
      }
    return lambda / 2 * tr_E * tr_E + mu * E_E;
  }
};

int main()
{
  check_solid("Saint Venant-Kirchhoff", Expanding<Energy>());
}
