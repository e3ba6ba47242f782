// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Hooke's law against its energy.

#include "law_check.h"

struct Energy
{
  template <typename Number>
  Number operator()(const Matrix<Number> &F, const Number &e) const
  {
    const double mu = 1.3, kappa = 2.7, lambda = kappa - 2. / 3. * mu;
    const Number tr_eps = F[0][0] + F[1][1] + F[2][2] - 3.;
    Number eps_eps = 0.;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j) {
        const Number eps_ij = 0.5 * (F[i][j] + F[j][i]) - (i == j ? 1. : 0.);
        eps_eps += eps_ij * eps_ij;
      }
    return lambda / 2 * tr_eps * tr_eps + mu * eps_eps - 3 * kappa * e * tr_eps;
  }
};

int main()
{
  check_solid("linear elastic", Energy());
}
