// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/invariant_law.h>

#include <array>
#include <cmath>

namespace dovetail {

using dealii::Tensor;

namespace {

/// One of the invariants I_k and its isochoric version J^-beta I_k.
struct Invariant
{
  double beta, factor;    ///< J^-beta
  double I;               ///< I_k
  dealii::Tensor<2, 3> N; ///< dI_k/dF
  dealii::Tensor<2, 3> G; ///< of the isochoric one
  double minus_3;         ///< the isochoric one minus 3
};

/// What both invariants need.
struct Kinematics
{
  explicit Kinematics(const Deformation &deformation)
      : F(deformation.F), Q(transpose(invert(deformation.F))), E(deformation.green_strain()),
        log_J(std::log1p(deformation.J_minus_1)), J(deformation.J)
  {
    for (unsigned int i = 0; i < 3; ++i)
      identity[i][i] = 1;
    C = identity + 2. * E;
    b = F * transpose(F);
    const double tr_E = deformation.trace_of_green_strain();
    const Tensor<2, 3> F_minus_Q = deformation.H + Q * transpose(deformation.H);

    set(0, 2. / 3., 2. * F, 2. * F_minus_Q, 2 * tr_E);
    // I_2 = 3 + 4 tr E + 2 ((tr E)² - E:E), N = 2 F (I_1 I - C) = 4 F (I + tr E I - E)
    const Tensor<2, 3> F_E = F * (tr_E * identity - E);
    set(1, 4. / 3., 4. * (F + F_E), 4. * (F_minus_Q + F_E), 4 * tr_E + 2 * (tr_E * tr_E - E.norm_square()));
  }

  /// @param N_minus_3_beta_Q and @p I_minus_3 vanish with H.
  void set(const unsigned int k, const double beta, const Tensor<2, 3> &N,
           const Tensor<2, 3> &N_minus_3_beta_Q, const double I_minus_3)
  {
    const double factor = std::exp(-beta * log_J); // J^-beta
    invariants[k] = {beta,
                     factor,
                     3 + I_minus_3,
                     N,
                     factor * (N_minus_3_beta_Q - beta * I_minus_3 * Q),
                     factor * I_minus_3 + 3 * std::expm1(-beta * log_J)};
  }

  /// d²I_k/dF_iJ dF_mN
  double second_derivative(const unsigned int k, const unsigned int i, const unsigned int J,
                           const unsigned int m, const unsigned int N) const
  {
    const double same = (i == m ? 1 : 0) * (J == N ? 1 : 0);
    if (k == 0)
      return 2 * same;
    return 2 * (2 * F[i][J] * F[m][N] + invariants[0].I * same - (i == m ? C[J][N] : 0) - F[i][N] * F[m][J] -
                (J == N ? b[i][m] : 0));
  }

  /// dG_iJ/dF_mN
  double derivative_of_G(const unsigned int k, const unsigned int i, const unsigned int J,
                         const unsigned int m, const unsigned int N) const
  {
    const Invariant &of = invariants[k];
    return of.factor * (second_derivative(k, i, J, m, N) -
                        of.beta * (Q[i][J] * of.N[m][N] - of.I * Q[i][N] * Q[m][J])) -
           of.beta * of.G[i][J] * Q[m][N];
  }

  const Tensor<2, 3> F, Q, E;
  Tensor<2, 3> identity, C, b;
  const double log_J, J;
  std::array<Invariant, 2> invariants;
};

/// The Hessian of w:G for one invariant, with s = w:N - beta I w:Q, so that w:G = J^-beta s, and its
/// gradient.
struct Contracted
{
  Contracted(const Kinematics &kinematics, const unsigned int k, const Tensor<2, 3> &w)
      : kinematics(kinematics), invariant(kinematics.invariants[k]), k(k), w(w), factor(invariant.factor)
  {
    const Tensor<2, 3> &F = kinematics.F, &Q = kinematics.Q;
    w_F = scalar_product(w, F);
    w_Q = scalar_product(w, Q);
    Y = Q * transpose(w) * Q; // d(w:Q)/dF = -Y
    F_wT = F * transpose(w);
    wT_F = transpose(w) * F;
    // d(w:N)/dF
    const Tensor<2, 3> h = k == 0 ? 2. * w
                                  : 2. * (2. * w_F * F + kinematics.invariants[0].I * w - w * kinematics.C -
                                          F_wT * F - kinematics.b * w);
    s = scalar_product(w, invariant.N) - invariant.beta * invariant.I * w_Q;
    grad_s = h - invariant.beta * (w_Q * invariant.N - invariant.I * Y);
    gradient = factor * (grad_s - invariant.beta * s * Q);
  }

  /// Entry (k, L, m, N) of the Hessian.
  double operator()(const unsigned int i, const unsigned int L, const unsigned int m,
                    const unsigned int M) const
  {
    const Tensor<2, 3> &Q = kinematics.Q;
    const double beta = invariant.beta, change_of_Q = Q[i][M] * Q[m][L]; // minus dQ_iL/dF_mM
    const double of_s =
        third_derivative(i, L, m, M) -
        beta * (w_Q * kinematics.second_derivative(k, i, L, m, M) - invariant.N[i][L] * Y[m][M] -
                Y[i][L] * invariant.N[m][M] + invariant.I * (Q[i][M] * Y[m][L] + Y[i][M] * Q[m][L]));
    return factor * (of_s - beta * (Q[i][L] * grad_s[m][M] + grad_s[i][L] * Q[m][M]) +
                     s * (beta * beta * Q[i][L] * Q[m][M] + beta * change_of_Q));
  }

  Tensor<2, 3> gradient; ///< of w:G

private:
  /// d²(w:N)/dF_iL dF_mM
  double third_derivative(const unsigned int i, const unsigned int L, const unsigned int m,
                          const unsigned int M) const
  {
    if (k == 0)
      return 0;
    const Tensor<2, 3> &F = kinematics.F;
    const double same_row = i == m ? 1 : 0, same_column = L == M ? 1 : 0;
    return 2 * (2 * (w[m][M] * F[i][L] + w_F * same_row * same_column + F[m][M] * w[i][L]) -
                w[i][M] * F[m][L] - F_wT[m][i] * same_column - same_row * wT_F[M][L] -
                F_wT[i][m] * same_column - F[i][M] * w[m][L] - same_row * wT_F[L][M]);
  }

  const Kinematics &kinematics;
  const Invariant &invariant;
  const unsigned int k;
  const Tensor<2, 3> w;
  double factor, w_F, w_Q, s;
  Tensor<2, 3> Y, F_wT, wT_F, grad_s;
};

/// a_1 = J U', a_2 = J a_1', a_3 = J a_2', which are the derivatives by ln J.
struct Volumetric
{
  Volumetric(const VolumetricEnergy &U, const double J)
      : a_1(J * U.U_1), a_2(J * J * U.U_2 + a_1), a_3(J * J * J * U.U_3 + 3 * J * J * U.U_2 + a_1)
  {
  }
  double a_1, a_2, a_3;
};

bool needs_second(const IsochoricEnergy &W)
{
  return W.W_2 != 0 || W.W_12 != 0 || W.W_22 != 0;
}

} // namespace

VolumetricEnergy simo_taylor(const double kappa, const double J_minus_1)
{
  const double J = 1 + J_minus_1;
  return {kappa / 2 * J_minus_1 * (J + 1) / J, kappa / 2 * (1 + 1 / (J * J)), -kappa / (J * J * J)};
}

// P = W_k G_k + a_1 Q,  D = W_kl G_k (x) G_l + W_k dG_k/dF + a_2 Q (x) Q - a_1 Q_iN Q_mJ, where
//   dG_iJ/dF_mN = J^-beta (N'_iJmN - beta (Q_iJ N_mN - I Q_iN Q_mJ)) - beta G_iJ Q_mN
void InvariantLaw::elastic_response(const Deformation &deformation, Tensor<2, 3> &P, Tensor<4, 3> *D) const
{
  const Kinematics kinematics(deformation);
  const auto &[first, second] = kinematics.invariants;
  const IsochoricEnergy W = isochoric(first.minus_3, second.minus_3);
  const Volumetric volumetric(this->volumetric(deformation.J_minus_1), deformation.J);
  const Tensor<2, 3> &Q = kinematics.Q;
  const std::array<double, 2> W_k = {{W.W_1, W.W_2}};
  P = W.W_1 * first.G + W.W_2 * second.G + volumetric.a_1 * Q;
  if (D == nullptr)
    return;

  const unsigned int n_invariants = needs_second(W) ? 2 : 1;
  const std::array<Tensor<2, 3>, 2> dW = {
      {W.W_11 * first.G + W.W_12 * second.G, W.W_12 * first.G + W.W_22 * second.G}};
  Tensor<2, 3> of_Q = volumetric.a_2 * Q; // what stands beside Q_mN, and beside Q_iJ
  Tensor<2, 3> beside_Q;
  double across = -volumetric.a_1; // of Q_iN Q_mJ
  for (unsigned int k = 0; k < n_invariants; ++k) {
    const Invariant &invariant = kinematics.invariants[k];
    const double beta_W = invariant.beta * W_k[k], factor = invariant.factor;
    of_Q -= beta_W * invariant.G;
    beside_Q -= beta_W * factor * invariant.N;
    across += beta_W * factor * invariant.I;
  }
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int J = 0; J < 3; ++J)
      for (unsigned int m = 0; m < 3; ++m)
        for (unsigned int N = 0; N < 3; ++N) {
          double entry = of_Q[i][J] * Q[m][N] + Q[i][J] * beside_Q[m][N] + across * Q[i][N] * Q[m][J];
          for (unsigned int k = 0; k < n_invariants; ++k)
            entry += kinematics.invariants[k].G[i][J] * dW[k][m][N] +
                     W_k[k] * kinematics.invariants[k].factor * kinematics.second_derivative(k, i, J, m, N);
          (*D)[i][J][m][N] = entry;
        }
}

// With g_k = w:G_k, h_k = dg_k/dF, q = w:Q, Y = -dq/dF and V_k = W_kl G_l:
//   d²(w:P)/dF² = g_k (W_klm G_l (x) G_m + W_kl dG_l/dF) + V_k (x) h_k + h_k (x) V_k + W_k d²g_k/dF²
//                 + a_3 q Q (x) Q - a_2 (q Q_iN Q_mL + Q (x) Y + Y (x) Q) + a_1 (Q_iN Y_mL + Y_iN Q_mL)
Tensor<4, 3> InvariantLaw::elastic_curvature(const Deformation &deformation, const Tensor<2, 3> &w) const
{
  const Kinematics kinematics(deformation);
  const auto &[first, second] = kinematics.invariants;
  const IsochoricEnergy W = isochoric(first.minus_3, second.minus_3);
  const Volumetric volumetric(this->volumetric(deformation.J_minus_1), deformation.J);
  const Tensor<2, 3> &Q = kinematics.Q;
  const double q = scalar_product(w, Q);
  const Tensor<2, 3> Y = Q * transpose(w) * Q;

  const std::array<Contracted, 2> g = {{Contracted(kinematics, 0, w), Contracted(kinematics, 1, w)}};
  const double g_1 = scalar_product(w, first.G), g_2 = scalar_product(w, second.G);
  // by G_l (x) G_m, and by dG_l/dF
  const double c_11 = g_1 * W.W_111 + g_2 * W.W_112, c_12 = g_1 * W.W_112 + g_2 * W.W_122,
               c_22 = g_1 * W.W_122 + g_2 * W.W_222;
  const std::array<double, 2> c = {{g_1 * W.W_11 + g_2 * W.W_12, g_1 * W.W_12 + g_2 * W.W_22}},
                              W_k = {{W.W_1, W.W_2}};
  const std::array<Tensor<2, 3>, 2> G = {{first.G, second.G}},
                                    V = {{W.W_11 * G[0] + W.W_12 * G[1], W.W_12 * G[0] + W.W_22 * G[1]}},
                                    cG = {{c_11 * G[0] + c_12 * G[1], c_12 * G[0] + c_22 * G[1]}};
  Tensor<4, 3> result;
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int L = 0; L < 3; ++L)
      for (unsigned int m = 0; m < 3; ++m)
        for (unsigned int N = 0; N < 3; ++N) {
          double entry = volumetric.a_3 * q * Q[i][L] * Q[m][N] -
                         volumetric.a_2 * (q * Q[i][N] * Q[m][L] + Q[i][L] * Y[m][N] + Y[i][L] * Q[m][N]) +
                         volumetric.a_1 * (Q[i][N] * Y[m][L] + Y[i][N] * Q[m][L]);
          for (unsigned int k = 0; k < (needs_second(W) ? 2 : 1); ++k)
            entry += G[k][i][L] * cG[k][m][N] + c[k] * kinematics.derivative_of_G(k, i, L, m, N) +
                     V[k][i][L] * g[k].gradient[m][N] + g[k].gradient[i][L] * V[k][m][N] +
                     W_k[k] * g[k](i, L, m, N);
          result[i][L][m][N] = entry;
        }
  return result;
}

} // namespace dovetail
