// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The law "energy": an energy that does not split into parts of shape and volume (neo-Hookean, compressible),
// and one with all mixed derivatives, against automatic differentiation; the same formula in other
// invariants; energies that are none.

#include "law_check.h"

#include <dovetail/scene/user_error.h>

namespace {

struct Compressible
{
  template <typename Number>
  Number operator()(const Matrix<Number> &F) const
  {
    const Matrix<Number> C = right_cauchy_green(F);
    const Number ln_J = log(determinant_of(F));
    return 1.3 / 2 * (C[0][0] + C[1][1] + C[2][2] - 3. - 2. * ln_J) + (2.7 - 2.6 / 3) / 2 * ln_J * ln_J;
  }
};

struct Mixed
{
  template <typename Number>
  Number operator()(const Matrix<Number> &F) const
  {
    const Matrix<Number> C = right_cauchy_green(F);
    const Number J = determinant_of(F), a = C[0][0] + C[1][1] + C[2][2];
    Number tr_C2 = 0. * J;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        tr_C2 += C[i][j] * C[i][j];
    const Number b = 0.5 * (a * a - tr_C2), j = J - 1.;
    return 0.5 * (a - 3. * exp(2. / 3. * log(J))) * (1. + 0.3 * j) +
           0.15 * (b - 3. * exp(4. / 3. * log(J))) * J + 0.2 * j * j * a * b * J + (2.7 / 2 - 1.8) * j * j;
  }
};

std::string message(const std::string &energy)
{
  try {
    make_material<3>("set Type = energy\nset Energy = " + energy, "");
  } catch (const UserError &error) {
    return error.what();
  }
  return "no error";
}

} // namespace

int main()
{
  check_solid("energy", Expanding<Compressible>(),
              "set Energy = 1.3/2*(I1 - 3 - 2*ln(J)) + (2.7 - 2.6/3)/2*ln(J)^2");
  const std::string law =
      "set Type = energy\nset Energy = 0.5*(I1 - 3*J^(2/3))*(1 + 0.3*(J - 1)) + 0.15*(I2 - "
      "3*J^(4/3))*J + 0.2*(J - 1)^2*I1*I2*J + (2.7/2 - 1.8)*(J - 1)^2";
  check_energy(make_material<3>(law + expansion, conducts), Expanding<Mixed>());
  check_differences("mixed", make_material<2>(law, ""));
  for (const std::string energy : {"I1 - 3", "-0.5*(I1_bar - 3) + (J - 1)^2", "0.5*(I1_bar - 3)",
                                   "0.5*(I4 - 3) + (J - 1)^2", "0.5*(I1 - 3"})
    std::cout << message(energy) << std::endl;
}
