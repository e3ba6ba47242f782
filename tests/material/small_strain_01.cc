// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Stress and derivatives of each solid at H = 1e-12 ... 1e-1 times a fixed tensor, with a thermal strain as
// large, against the textbook formulas in F = I + H with 50 digits. The errors are relative to |H|
// (derivatives: to 1), in units of the largest modulus.

#include "law_check.h"

#include <boost/multiprecision/cpp_bin_float.hpp>

using Exact = boost::multiprecision::cpp_bin_float_50;
using ExactMatrix = Matrix<Exact>;

const Exact mu = 1.3, kappa = 2.7;
const double modulus = 5;

ExactMatrix inverse_transpose(const ExactMatrix &F)
{
  ExactMatrix result;
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int j = 0; j < 3; ++j) {
      const unsigned int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
      result[i][j] = (F[a][c] * F[b][d] - F[a][d] * F[b][c]) / determinant_of(F);
    }
  return result;
}

struct LinearElastic
{
  static constexpr bool is_hyperelastic = false;
  const char *type = "linear elastic";
  ExactMatrix operator()(const ExactMatrix &F) const
  {
    ExactMatrix P;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        P[i][j] = mu * (F[i][j] + F[j][i]) +
                  (i == j ? (kappa - 2 * mu / 3) * (F[0][0] + F[1][1] + F[2][2] - 3) - 2 * mu : Exact(0));
    return P;
  }
};

struct SaintVenantKirchhoff
{
  static constexpr bool is_hyperelastic = true;
  const char *type = "Saint Venant-Kirchhoff";
  ExactMatrix operator()(const ExactMatrix &F) const
  {
    const ExactMatrix C = right_cauchy_green(F);
    const Exact lambda_tr_E = (kappa - 2 * mu / 3) * (C[0][0] + C[1][1] + C[2][2] - 3) / 2;
    ExactMatrix P{};
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        for (unsigned int k = 0; k < 3; ++k)
          P[i][j] += F[i][k] * (mu * C[k][j] + (k == j ? lambda_tr_E - mu : Exact(0)));
    return P;
  }
};

struct NeoHookean
{
  static constexpr bool is_hyperelastic = true;
  const char *type = "neo-Hookean";
  ExactMatrix operator()(const ExactMatrix &F) const
  {
    const ExactMatrix C = right_cauchy_green(F), Q = inverse_transpose(F);
    const Exact J = determinant_of(F), a = mu / cbrt(J * J);
    const Exact p = kappa / 2 * (J * J - 1) - a * (C[0][0] + C[1][1] + C[2][2]) / 3;
    ExactMatrix P;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        P[i][j] = a * F[i][j] + p * Q[i][j];
    return P;
  }
};

struct MooneyRivlin
{
  static constexpr bool is_hyperelastic = true;
  const char *type = "Mooney-Rivlin";
  ExactMatrix operator()(const ExactMatrix &F) const
  {
    const ExactMatrix C = right_cauchy_green(F), Q = inverse_transpose(F);
    const Exact J = determinant_of(F), C10 = 0.45, C01 = 0.2, tr_C = C[0][0] + C[1][1] + C[2][2];
    Exact tr_C2 = 0;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        tr_C2 += C[i][j] * C[i][j];
    const Exact a = 2 * C10 / cbrt(J * J), b = 2 * C01 / cbrt(J * J * J * J), I_2 = (tr_C * tr_C - tr_C2) / 2;
    ExactMatrix P;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j) {
        Exact F_C = 0;
        for (unsigned int k = 0; k < 3; ++k)
          F_C += F[i][k] * C[k][j];
        P[i][j] = a * (F[i][j] - tr_C / 3 * Q[i][j]) + b * (tr_C * F[i][j] - F_C - 2 * I_2 / 3 * Q[i][j]) +
                  kappa / 2 * (J * J - 1) * Q[i][j];
      }
    return P;
  }
};

/// s² P_e(F/s) with s = 1 + e; the linear law has no such split but -3 kappa e I.
template <typename Law>
ExactMatrix exact_stress(const Law &law, const ExactMatrix &H, const Exact &e)
{
  const Exact s = Law::is_hyperelastic ? 1 + e : Exact(1);
  ExactMatrix F = H;
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int j = 0; j < 3; ++j)
      F[i][j] = (H[i][j] + (i == j ? 1 : 0)) / s;
  ExactMatrix P = law(F);
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int j = 0; j < 3; ++j)
      P[i][j] = s * s * P[i][j] - (!Law::is_hyperelastic && i == j ? 3 * kappa * e : Exact(0));
  return P;
}

template <typename Law>
void check(const Law &law)
{
  const std::string type = law.type,
                    shear = type == "Mooney-Rivlin" ? "C10 = 0.45\nset C01 = 0.2" : "Shear modulus = 1.3";
  const Material<3> material = make_material<3>("set Type = " + type + "\nset " + shear +
                                                    "\nset Bulk modulus = 2.7"
                                                    "\nset Expansion coefficient = 1",
                                                "set Type = Fourier\nset Conductivity = 1");
  const Tensor<2, 3> direction({{0.7, -0.3, 0.2}, {0.4, -0.9, 0.5}, {-0.1, 0.6, 0.3}});
  double stress_error = 0, derivative_error = 0, Cauchy_error = 0;
  for (const double size : {1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1}) {
    State<3> state(4);
    ExactMatrix H;
    state.value[3] = 0.4 * size; // the thermal strain
    for (unsigned int i = 0; i < 3; ++i) {
      state.gradient[i] = size * direction[i];
      for (unsigned int j = 0; j < 3; ++j)
        H[i][j] = state.gradient[i][j];
    }
    Response<3> response(4);
    if (!material.evaluate(state, true, response))
      std::cout << "not defined" << std::endl;

    const ExactMatrix P = exact_stress(law, H, state.value[3]);
    const Tensor<2, 3> sigma = material.cauchy_stress(state);
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j) {
        const auto error_of = [&](const double value, const Exact &exact, const double unit) {
          return std::abs(static_cast<double>(value - exact)) / (modulus * unit);
        };
        stress_error = std::max(stress_error, error_of(response.flux[i][j], P[i][j], size));
        ExactMatrix F = H;
        for (unsigned int k = 0; k < 3; ++k)
          F[k][k] += 1;
        Exact P_F = Law::is_hyperelastic ? 0 : P[i][j];
        for (unsigned int k = 0; k < 3 && Law::is_hyperelastic; ++k)
          P_F += P[i][k] * F[j][k] / determinant_of(F);
        Cauchy_error = std::max(Cauchy_error, error_of(sigma[i][j], P_F, size));
      }
    const Exact step("1e-15");
    for (unsigned int s = 0; s < 10; ++s) { // the components of H, then e
      ExactMatrix plus = H, minus = H;
      Exact e_plus = state.value[3], e_minus = e_plus;
      (s < 9 ? plus[s / 3][s % 3] : e_plus) += step;
      (s < 9 ? minus[s / 3][s % 3] : e_minus) -= step;
      const ExactMatrix P_plus = exact_stress(law, plus, e_plus), P_minus = exact_stress(law, minus, e_minus);
      for (unsigned int i = 0; i < 3; ++i)
        for (unsigned int j = 0; j < 3; ++j) {
          const Exact exact = (P_plus[i][j] - P_minus[i][j]) / (2 * step);
          const double value =
              s < 9 ? response.by_gradient[i * 4 + s / 3][j][s % 3] : response.by_value[i * 4 + 3][j];
          derivative_error =
              std::max(derivative_error, std::abs(static_cast<double>(value - exact)) / modulus);
        }
    }
  }
  report(std::string(law.type) + ", stress", stress_error, 1e-15);
  report(std::string(law.type) + ", Cauchy stress", Cauchy_error, 1e-15);
  report(std::string(law.type) + ", derivatives", derivative_error, 2e-15);
}

int main()
{
  check(LinearElastic());
  check(SaintVenantKirchhoff());
  check(NeoHookean());
  check(MooneyRivlin());
}
