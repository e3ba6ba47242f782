// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The Ogden solid: with even exponents, whose energy is one of invariants, against automatic differentiation,
// and against the law "energy" where stretches are equal or nearly so; with Treloar's fit (Ogden 1972)
// against differences.

#include "law_check.h"

namespace {

/// sum mu_p/alpha_p (x_1 + x_2 + x_3 - 3) of mu = 0.4, 0.3, -0.3, alpha = 2, 4, -2 (x^2: I_1, x^4: I_1^2 - 2
/// I_2, x^-2: I_2)
struct Energy
{
  template <typename Number>
  Number operator()(const Matrix<Number> &F) const
  {
    const Matrix<Number> C = right_cauchy_green(F);
    const Number J = determinant_of(F), tr_C = C[0][0] + C[1][1] + C[2][2], ln_J = log(J);
    Number tr_C2 = 0. * J;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        tr_C2 += C[i][j] * C[i][j];
    const Number I_1 = exp(-2. / 3. * ln_J) * tr_C, I_2 = exp(-4. / 3. * ln_J) * 0.5 * (tr_C * tr_C - tr_C2);
    return 0.2 * (I_1 - 3.) + 0.075 * (I_1 * I_1 - 2. * I_2 - 3.) + 0.15 * (I_2 - 3.) +
           2.7 * (J * ln_J - J + 1.);
  }
};

const std::string even = "\nset Moduli = 0.4, 0.3, -0.3\nset Exponents = 2, 4, -2";

/// Flux, derivatives and curvature of two laws at the state F = R diag(stretches) R2.
double difference(const Material<3> &a, const Material<3> &b, const std::array<double, 3> &stretches)
{
  Random random;
  Tensor<2, 3> U;
  for (unsigned int i = 0; i < 3; ++i)
    U[i][i] = stretches[i] - 1;
  const Tensor<2, 3> R = random.rotation(), R2 = random.rotation(), I = dealii::unit_symmetric_tensor<3>(),
                     H = R * U * R2 + (R * R2 - I);
  State<3> state(3);
  std::vector<Tensor<1, 3>> w(3);
  for (unsigned int i = 0; i < 3; ++i) {
    state.gradient[i] = H[i];
    w[i] = random.vector<3>();
  }
  Response<3> of_a(3), of_b(3);
  a.evaluate(state, true, of_a);
  b.evaluate(state, true, of_b);
  FullMatrix<double> curvature_a, curvature_b;
  a.curvature(state, w, curvature_a);
  b.curvature(state, w, curvature_b);
  double flux = 0;
  for (unsigned int i = 0; i < 3; ++i)
    flux = std::max(flux, (of_a.flux[i] - of_b.flux[i]).norm());
  return std::max(
      {flux, relative_error(derivatives(of_a), derivatives(of_b)), relative_error(curvature_a, curvature_b)});
}

} // namespace

int main()
{
  check_solid("Ogden", Expanding<Energy>(), even + "\nset Bulk modulus = 2.7\nset Volumetric = Liu");

  const Material<3> ogden = make_material<3>("set Type = Ogden" + even + "\nset Bulk modulus = 2.7", ""),
                    energy =
                        make_material<3>("set Type = energy\nset Energy = 0.2*I1_bar + 0.075*(I1_bar^2 - "
                                         "2*I2_bar) + 0.15*I2_bar + 2.7/4*(J^2 - 1 - 2*ln(J))",
                                         "");
  double error = 0;
  for (const double d : {0., 1e-15, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 1e-2, 0.1, 0.13, 0.14, 0.2})
    for (const std::array<double, 3> &stretches :
         std::vector<std::array<double, 3>>{{{1 + d, 1, 1}},
                                            {{1.4, 1.4, 1.4 + d}},
                                            {{0.8, 1.7, 1.7 - d}},
                                            {{1.1, 1.1 + d, 1.1 + d / 3}},
                                            {{0.5, 0.5 + d, 2}}})
      error = std::max(error, difference(ogden, energy, stretches));
  report("equal stretches", error, 1e-12);

  for (const std::string more : {"", "\nset Volumetric = Ogden\nset Volumetric exponent = 3"})
    check_differences(
        "Treloar" + std::string(more.empty() ? "" : ", Ogden's U"),
        make_material<3>("set Type = Ogden\nset Moduli = 0.63, 0.0012, -0.01\nset Exponents = 1.3, 5, -2\n"
                         "set Bulk modulus = 10" +
                             more,
                         ""));

  // small loads: the rounding of the stress is that of the strain
  const Material<3> linear =
      make_material<3>("set Type = linear elastic\nset Shear modulus = 1.3\nset Bulk modulus = 2.7", "");
  State<3> state(3);
  Response<3> response(3), of_linear(3);
  Random random;
  for (unsigned int i = 0; i < 3; ++i)
    state.gradient[i] = 1e-14 * random.vector<3>();
  ogden.evaluate(state, true, response);
  linear.evaluate(state, true, of_linear);
  double rounding = 0;
  for (unsigned int i = 0; i < 3; ++i)
    rounding = std::max(rounding, (response.flux[i] - of_linear.flux[i]).norm() / 1e-14);
  report("small load", rounding, 1e-12);
}
