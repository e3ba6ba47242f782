// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/invariant_law.h>
#include <dovetail/widest_vectors.h>

#include <boost/container/static_vector.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/math/special_functions/lambert_w.hpp>
#include <boost/math/tools/toms748_solve.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace dovetail {

using dealii::Tensor;

namespace {

bool needs_second(const IsochoricEnergy &W)
{
  return W.W_2 != 0 || W.W_12 != 0 || W.W_22 != 0 || W.mixed;
}

/// Whether dW/dI_k change with the invariants.
bool varies(const IsochoricEnergy &W)
{
  return W.W_11 != 0 || W.W_12 != 0 || W.W_22 != 0 || W.mixed;
}

/// One of the invariants I_k and its isochoric version J^-beta I_k.
struct Invariant
{
  double beta, factor; ///< J^-beta
  double I;            ///< I_k
  Tensor<2, 3> N;      ///< dI_k/dF
  Tensor<2, 3> G;      ///< derivative of the isochoric one
};

/// The invariants that the energy depends on, with what both need.
struct InvariantKinematics
{
  InvariantKinematics(const Deformation &deformation, const bool with_second)
      : F(deformation.F), Q(transpose(invert(deformation.F)))
  {
    const double tr_E = deformation.trace_of_green_strain(), J = deformation.J;
    const Tensor<2, 3> E = deformation.green_strain(), F_minus_Q = 2. * Q * E; // as P F^T keeps its symmetry
    add(2. / 3., 1 / std::cbrt(J * J), 2. * F, 2. * F_minus_Q, 2 * tr_E);
    if (!with_second)
      return;
    // I_2 = 3 + 4 tr E + 2 ((tr E)^2 - E:E), N = 2 F (I_1 I - C) = 4 F (I + tr E I - E)
    const Tensor<2, 3> F_E = tr_E * F - F * E;
    C = 2. * E;
    for (unsigned int i = 0; i < 3; ++i)
      C[i][i] += 1;
    b = F * transpose(F);
    add(4. / 3., invariants[0].factor * invariants[0].factor, 4. * (F + F_E), 4. * (F_minus_Q + F_E),
        4 * tr_E + 2 * (tr_E * tr_E - E.norm_square()));
  }

  /// @p N_minus_3_beta_Q and @p I_minus_3 vanish with H.
  void add(const double beta, const double factor, const Tensor<2, 3> &N,
           const Tensor<2, 3> &N_minus_3_beta_Q, const double I_minus_3)
  {
    invariants.push_back(
        {beta, factor, 3 + I_minus_3, N, factor * (N_minus_3_beta_Q - beta * I_minus_3 * Q)});
  }

  /// d(w:N)/dF of invariant k.
  Tensor<2, 3> derivative_of_N(const unsigned int k, const Tensor<2, 3> &w) const
  {
    if (k == 0)
      return 2. * w;
    return 2. * (2. * scalar_product(w, F) * F + invariants[0].I * w - w * C - F * transpose(w) * F - b * w);
  }

  /// Add c d²I_k/dF².
  void add_derivative_of_N(const unsigned int k, const double c, Tensor<4, 3> &D) const
  {
    if (k == 0) {
      double *const entries = &D[0][0][0][0];
      for (unsigned int iJ = 0; iJ < 9; ++iJ)
        entries[10 * iJ] += 2 * c;
      return;
    }
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int J = 0; J < 3; ++J)
        for (unsigned int m = 0; m < 3; ++m) {
          for (unsigned int N = 0; N < 3; ++N)
            D[i][J][m][N] += 2 * c * (2 * F[i][J] * F[m][N] - F[i][N] * F[m][J]);
          D[i][J][i][m] -= 2 * c * C[J][m];
          D[i][J][m][J] -= 2 * c * b[i][m];
          if (i == m)
            D[i][J][m][J] += 2 * c * invariants[0].I;
        }
  }

  /// Add c d²(w:N_2)/dF², which is zero for the first invariant.
  void add_second_derivative_of_N(const double c, const Tensor<2, 3> &w, Tensor<4, 3> &T) const
  {
    const Tensor<2, 3> across = F * transpose(w) + w * transpose(F),
                       along = transpose(w) * F + transpose(F) * w;
    const double w_F = scalar_product(w, F);
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int L = 0; L < 3; ++L)
        for (unsigned int m = 0; m < 3; ++m) {
          for (unsigned int M = 0; M < 3; ++M)
            T[i][L][m][M] +=
                2 * c *
                (2 * w[m][M] * F[i][L] + 2 * F[m][M] * w[i][L] - w[i][M] * F[m][L] - F[i][M] * w[m][L]);
          T[i][L][m][L] -= 2 * c * across[i][m];
          T[i][L][i][m] -= 2 * c * along[m][L];
          if (i == m)
            T[i][L][m][L] += 4 * c * w_F;
        }
  }

  const Tensor<2, 3> F, Q;
  Tensor<2, 3> C, b;                                        ///< of the second invariant only
  boost::container::static_vector<Invariant, 2> invariants; ///< an allocation takes as long as the rest
};

/// a_1 = J U', a_2 = J a_1', a_3 = J a_2', which are the derivatives by ln J.
struct VolumetricByLogarithm
{
  VolumetricByLogarithm(const VolumetricEnergy &U, const double J)
      : a_1(J * U.U_1), a_2(J * J * U.U_2 + a_1), a_3(J * J * J * U.U_3 + 3 * J * J * U.U_2 + a_1)
  {
  }
  double a_1, a_2, a_3;
};

/// D_iJmN += A_iJ B_mN
void add_product(const Tensor<2, 3> &A, const Tensor<2, 3> &B, Tensor<4, 3> &D)
{
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int J = 0; J < 3; ++J)
      for (unsigned int m = 0; m < 3; ++m)
        for (unsigned int N = 0; N < 3; ++N)
          D[i][J][m][N] += A[i][J] * B[m][N];
}

/// Both ways round.
void add_symmetric_product(const Tensor<2, 3> &A, const Tensor<2, 3> &B, Tensor<4, 3> &D)
{
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int J = 0; J < 3; ++J)
      for (unsigned int m = 0; m < 3; ++m)
        for (unsigned int N = 0; N < 3; ++N)
          D[i][J][m][N] += A[i][J] * B[m][N] + B[i][J] * A[m][N];
}

/// D_iJmN = A_iJ Q_mN + Q_iJ B_mN + c Q_iN Q_mJ, in rows of the nine mN.
DOVETAIL_WIDEST_VECTORS void set_products(const double *const __restrict__ Q,
                                          const double *const __restrict__ A,
                                          const double *const __restrict__ B, const double c,
                                          double *const __restrict__ D)
{
  double of_i[3][9], of_J[3][9]; // Q_iN and c Q_mJ
  for (unsigned int a = 0; a < 3; ++a)
    for (unsigned int m = 0; m < 3; ++m)
      for (unsigned int N = 0; N < 3; ++N) {
        of_i[a][3 * m + N] = Q[3 * a + N];
        of_J[a][3 * m + N] = c * Q[3 * m + a];
      }
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int J = 0; J < 3; ++J) {
      const double A_iJ = A[3 * i + J], Q_iJ = Q[3 * i + J];
      double *const __restrict__ row = D + 9 * (3 * i + J);
      for (unsigned int k = 0; k < 9; ++k)
        row[k] = A_iJ * Q[k] + Q_iJ * B[k] + of_J[J][k] * of_i[i][k];
    }
}

void set_products_with_Q(const Tensor<2, 3> &Q, const Tensor<2, 3> &A, const Tensor<2, 3> &B, const double c,
                         Tensor<4, 3> &D)
{
  set_products(&Q[0][0], &A[0][0], &B[0][0], c, &D[0][0][0][0]);
}

/// D_iJmN = A_iJ Q_mN + Q_iJ B_mN + Q_iN S_mJ + T_iN Q_mJ
void set_products_with_Q(const Tensor<2, 3> &Q, const Tensor<2, 3> &A, const Tensor<2, 3> &B,
                         const Tensor<2, 3> &S, const Tensor<2, 3> &T, Tensor<4, 3> &D)
{
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int J = 0; J < 3; ++J) {
      const double A_iJ = A[i][J], Q_iJ = Q[i][J];
      for (unsigned int m = 0; m < 3; ++m) {
        const double S_mJ = S[m][J], Q_mJ = Q[m][J];
        Tensor<1, 3> &row = D[i][J][m];
        for (unsigned int N = 0; N < 3; ++N)
          row[N] = A_iJ * Q[m][N] + Q_iJ * B[m][N] + Q[i][N] * S_mJ + T[i][N] * Q_mJ;
      }
    }
}

/// dG_iJ/dF_mN = J^-beta (dN_iJmN - beta (Q_iJ N_mN - I Q_iN Q_mJ)) - beta G_iJ Q_mN
Tensor<4, 3> derivative_of_G(const InvariantKinematics &kinematics, const unsigned int k)
{
  const auto &[beta, factor, I, N, G] = kinematics.invariants[k];
  Tensor<4, 3> result;
  set_products_with_Q(kinematics.Q, -beta * G, -beta * factor * N, beta * factor * I, result);
  kinematics.add_derivative_of_N(k, factor, result);
  return result;
}

/// Of d²(w:P)/dF² what changes W_k brings: g_k (W_klm G_l (x) G_m + W_kl dG_l/dF) + W_kl G_l v h_k. In an
/// energy that does not split J is the third of the variables, with G = J Q; what J alone brings is left out.
void add_change_of_energy(const IsochoricEnergy &W, const InvariantKinematics &kinematics, const double J,
                          const Tensor<2, 3> &w, std::vector<Tensor<2, 3>> h, Tensor<4, 3> &result)
{
  const IsochoricEnergy::Mixed mixed = W.mixed.value_or(IsochoricEnergy::Mixed());
  const double W_kl[3][3] = {
      {W.W_11, W.W_12, mixed.W_1J}, {W.W_12, W.W_22, mixed.W_2J}, {mixed.W_1J, mixed.W_2J, 0}};
  // at the number of derivatives by J, then at the number of those by I_2
  const double W_klm[4][4] = {{W.W_111, W.W_112, W.W_122, W.W_222},
                              {mixed.W_11J, mixed.W_12J, mixed.W_22J, 0},
                              {mixed.W_1JJ, mixed.W_2JJ, 0, 0},
                              {0, 0, 0, 0}};
  const Tensor<2, 3> &Q = kinematics.Q;
  std::vector<Tensor<2, 3>> G;
  std::vector<Tensor<4, 3>> by_F;
  for (unsigned int k = 0; k < kinematics.invariants.size(); ++k) {
    G.push_back(kinematics.invariants[k].G);
    by_F.push_back(derivative_of_G(kinematics, k));
  }
  if (W.mixed) {
    G.push_back(J * Q);
    h.push_back(J * (scalar_product(w, Q) * Q - Q * transpose(w) * Q));
    by_F.emplace_back();
    set_products_with_Q(Q, J * Q, Tensor<2, 3>(), -J, by_F.back());
  }
  for (unsigned int k = 0; k < G.size(); ++k) {
    const double g = scalar_product(w, G[k]);
    for (unsigned int l = 0; l < G.size(); ++l) {
      result += g * W_kl[k][l] * by_F[l];
      add_symmetric_product(W_kl[k][l] * G[l], h[k], result);
      for (unsigned int m = 0; m < G.size(); ++m)
        add_product(g * W_klm[k / 2 + l / 2 + m / 2][k % 2 + l % 2 + m % 2] * G[l], G[m], result);
    }
  }
}

} // namespace

Volumetric::Volumetric(const Section &section, const double kappa)
    : kappa(kappa), inverse(1 / kappa), is_separate(is_mixed(section))
{
  read_function(section);
}

Volumetric::Volumetric(const Section &section, const VaryingModuli &moduli)
    : kappa(moduli.bulk), inverse(moduli.compressibility), is_separate(is_mixed(section))
{
  read_function(section);
}

Volumetric::Volumetric(SolidLaw &law, const Section &section) : kappa(0), is_separate(is_mixed(section))
{
  kappa = read_bulk_modulus(law, section, inverse);
  read_function(section);
}

void Volumetric::read_function(const Section &section)
{
  choice = section.choose(
      "Volumetric", {"Simo-Taylor", "quadratic", "logarithmic", "Miehe", "Liu", "Ogden"}, 0,
      "U(J)/kappa: (J^2 - 1 - 2 ln J)/4, (J - 1)^2/2, (ln J)^2/2, J - ln J - 1, J ln J - J + 1 or, with "
      "the Volumetric exponent b, (J^-b - 1 + b ln J)/b^2 [-]");
  if (choice == 5 || section.documenting())
    exponent =
        section.read<double>("Volumetric exponent", 9, "b in Ogden's U(J) [-]", Patterns::Double(1e-300));
}

VolumetricEnergy Volumetric::times(const double kappa, const double J_minus_1) const
{
  const double J = 1 + J_minus_1;
  if (choice == 0) // by far the most frequent one needs no logarithm
    return {kappa / 2 * J_minus_1 * (J + 1) / J, kappa / 2 * (1 + 1 / (J * J)), -kappa / (J * J * J)};
  const double log_J = std::log1p(J_minus_1), power = std::exp(-exponent * log_J);
  switch (choice) {
  case 1:
    return {kappa * J_minus_1, kappa, 0};
  case 2:
    return {kappa * log_J / J, kappa * (1 - log_J) / (J * J), kappa * (2 * log_J - 3) / (J * J * J)};
  case 3:
    return {kappa * J_minus_1 / J, kappa / (J * J), -2 * kappa / (J * J * J)};
  case 4:
    return {kappa * log_J, kappa / J, -kappa / (J * J)};
  default:
    return {-kappa / (exponent * J) * std::expm1(-exponent * log_J),
            kappa / (exponent * J * J) * ((exponent + 1) * power - 1),
            kappa / (exponent * J * J * J) * (2 - (exponent + 1) * (exponent + 2) * power)};
  }
}

double Volumetric::change_at(const double strain) const
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double largest_logarithmic = std::exp(-1.); // of ln J / J
  if (strain == 0 || choice == 1)
    return strain;
  if (choice == 0)
    return strain + strain * strain / (1 + std::sqrt(1 + strain * strain));
  if (choice == 2)
    return strain <= largest_logarithmic ? std::expm1(-boost::math::lambert_w0(-strain)) : nan;
  if (choice == 3)
    return strain < 1 ? strain / (1 - strain) : nan;
  if (choice == 4)
    return std::expm1(strain);
  const auto excess = [&](const double log_J) { return times(1., std::expm1(log_J)).U_1 - strain; };
  double log_J = strain > 0 ? std::log1p(exponent) / exponent : strain; // where U' is largest
  for (unsigned int i = 0; i < 10 && excess(log_J) * strain < 0; ++i)
    log_J *= 2;
  if (!(excess(log_J) * strain >= 0))
    return nan;
  boost::uintmax_t n_evaluations = 100;
  const auto [below, above] =
      boost::math::tools::toms748_solve(excess, std::min(0., log_J), std::max(0., log_J),
                                        boost::math::tools::eps_tolerance<double>(50), n_evaluations);
  return std::expm1((below + above) / 2);
}

double Volumetric::energy_at(const double p, const SolidLaw::Place &place) const
{
  const double strain = p * inverse.at(place);
  if (strain == 0)
    return 0;
  const double change = change_at(strain);
  if (std::isnan(change))
    return change;
  const auto power = [&](const double s) { return times(1., s * change).U_1 * change; };
  return boost::math::quadrature::gauss_kronrod<double, 15>::integrate(power, 0., 1., 10, 1e-10) /
         inverse.at(place);
}

double require_bulk_modulus(const Section &section)
{
  return read_bulk_modulus(section, "kappa (three-dimensional) [Pa]");
}

double IsochoricInvariants::first_minus_3() const
{
  const double log_J = std::log1p(deformation.J_minus_1);
  return std::exp(-2. / 3. * log_J) * 2 * deformation.trace_of_green_strain() +
         3 * std::expm1(-2. / 3. * log_J);
}

double IsochoricInvariants::second_minus_3() const
{
  const double log_J = std::log1p(deformation.J_minus_1), tr_E = deformation.trace_of_green_strain();
  return std::exp(-4. / 3. * log_J) *
             (4 * tr_E + 2 * (tr_E * tr_E - deformation.green_strain().norm_square())) +
         3 * std::expm1(-4. / 3. * log_J);
}

VolumetricEnergy InvariantLaw::volumetric(const IsochoricInvariants &invariants) const
{
  return volume()->at(invariants);
}

// P = W_k G_k + a_1 Q,  D = W_kl G_k (x) G_l + W_k dG_k/dF + a_2 Q (x) Q - a_1 Q_iN Q_mJ
void InvariantLaw::elastic_response(const Deformation &deformation, Tensor<2, 3> &P, Tensor<4, 3> *D) const
{
  const IsochoricEnergy W = isochoric({deformation});
  const VolumetricByLogarithm U(volumetric({deformation}), deformation.J);
  const InvariantKinematics kinematics(deformation, needs_second(W));
  const auto &invariants = kinematics.invariants;
  const std::array<double, 2> W_k = {{W.W_1, W.W_2}};
  const Tensor<2, 3> &Q = kinematics.Q;
  P = U.a_1 * Q;
  Tensor<2, 3> before_Q = U.a_2 * Q, after_Q;
  double across = -U.a_1;
  for (unsigned int k = 0; k < invariants.size(); ++k) {
    const auto &[beta, factor, I, N, G] = invariants[k];
    P += W_k[k] * G;
    before_Q -= W_k[k] * beta * G;
    after_Q -= W_k[k] * beta * factor * N;
    across += W_k[k] * beta * factor * I;
  }
  if (D == nullptr)
    return;
  set_products_with_Q(Q, before_Q, after_Q, across, *D);
  for (unsigned int k = 0; k < invariants.size(); ++k)
    kinematics.add_derivative_of_N(k, W_k[k] * invariants[k].factor, *D);
  if (!varies(W))
    return;
  add_product(W.W_11 * invariants[0].G, invariants[0].G, *D);
  if (invariants.size() > 1) {
    add_symmetric_product(W.W_12 * invariants[0].G, invariants[1].G, *D);
    add_product(W.W_22 * invariants[1].G, invariants[1].G, *D);
  }
  if (W.mixed)
    add_symmetric_product(deformation.J * (W.mixed->W_1J * invariants[0].G + W.mixed->W_2J * invariants[1].G),
                          Q, *D);
}

// With g_k = w:G_k, h_k = dg_k/dF, q = w:Q, Y = -dq/dF, s_k = w:N_k - beta I_k q and A v B = A (x) B + B (x)
// A:
//   d²g/dF² = J^-beta (s'' - beta Q v s' + s (beta² Q (x) Q + beta Q_iN Q_mL))
//   s'' = d²(w:N)/dF² - beta (q dN - N v Y + I (Q_iN Y_mL + Y_iN Q_mL))
// and of the volumetric part a_3 q Q (x) Q - a_2 (q Q_iN Q_mL + Q v Y) + a_1 (Q_iN Y_mL + Y_iN Q_mL).
Tensor<4, 3> InvariantLaw::elastic_curvature(const Deformation &deformation, const Tensor<2, 3> &w) const
{
  const IsochoricEnergy W = isochoric({deformation, true});
  const VolumetricByLogarithm U(volumetric({deformation, true}), deformation.J);
  const InvariantKinematics kinematics(deformation, needs_second(W));
  const auto &invariants = kinematics.invariants;
  const std::array<double, 2> W_k = {{W.W_1, W.W_2}};
  const Tensor<2, 3> &Q = kinematics.Q;
  const Tensor<2, 3> Y = Q * transpose(w) * Q;
  const double q = scalar_product(w, Q);

  Tensor<2, 3> with_Q = U.a_3 * q / 2 * Q - U.a_2 * Y, crossed = U.a_1 * Y - U.a_2 * q / 2 * Q;
  std::vector<Tensor<2, 3>> h;
  for (unsigned int k = 0; k < invariants.size(); ++k) {
    const auto &[beta, factor, I, N, G] = invariants[k];
    const double s = scalar_product(w, N) - beta * I * q, c = W_k[k] * factor;
    const Tensor<2, 3> slope = kinematics.derivative_of_N(k, w) - beta * (q * N - I * Y);
    h.push_back(factor * (slope - beta * s * Q));
    with_Q += c * beta * (beta * s / 2 * Q - slope);
    crossed += c * beta * (s / 2 * Q - I * Y);
  }
  Tensor<4, 3> result;
  set_products_with_Q(Q, with_Q, with_Q, crossed, crossed, result);
  for (unsigned int k = 0; k < invariants.size(); ++k) {
    const auto &[beta, factor, I, N, G] = invariants[k];
    add_symmetric_product(W_k[k] * factor * beta * N, Y, result);
    kinematics.add_derivative_of_N(k, -W_k[k] * factor * beta * q, result);
    if (k == 1)
      kinematics.add_second_derivative_of_N(W_k[k] * factor, w, result);
  }
  if (varies(W))
    add_change_of_energy(W, kinematics, deformation.J, w, h, result);
  return result;
}

} // namespace dovetail
