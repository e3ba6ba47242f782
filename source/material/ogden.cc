// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rubber by powers of the principal stretches l_a: with those without change of volume, x_a = (J^(-1/3)
// l_a)^alpha,
//
//     W_e = sum_p mu_p/alpha_p (x_1 + x_2 + x_3 - 3) + kappa U(J)
//
// The shear modulus of small strains is sum_p mu_p alpha_p/2. One term with alpha = 2 is the neo-Hookean
// solid.
//
// S = dW/dE has the eigenvectors of the Green strain E and the eigenvalues S_a = b_a/c_a, where c_a = l_a^2 =
// 1 + 2 E_a and b_a = dW/d(ln l_a) = sum_p mu_p (x_a - (x_1 + x_2 + x_3)/3) + J U'. As a function of c_a it
// is a sum of powers, with factors that all three have in common. The derivatives of S by a change that turns
// the eigenvectors are therefore divided differences of powers, which are computed without cancellation also
// where stretches are equal or nearly so.
//
// Reference: Ogden, Proc. R. Soc. Lond. A 326 (1972) 565-584; Ogden, Non-linear Elastic Deformations (1984),
// section 6.1.4 (the derivatives by eigenvectors); de Boor, Surveys in Approximation Theory 1 (2005) 46-69
// (divided differences).
//
//     subsection Solid
//       set Type         = Ogden
//       set Moduli       = 0.63e6, 0.0012e6, -0.01e6    # mu_p, Pa
//       set Exponents    = 1.3, 5, -2                   # alpha_p
//       set Bulk modulus = 100e6                        # Pa
//     end

#include <dovetail/material/invariant_law.h>
#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/undefined.h>

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/base/symmetric_tensor.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace dovetail {

using dealii::Tensor;

namespace {

using Three = std::array<double, 3>;

/// ((x^p - y^p)/(x - y), p x^(p - 1) if they are equal.
double first_difference(const double p, const double x, const double y)
{
  const double ratio = std::log(x / y);
  return std::pow(y, p - 1) * (ratio == 0 ? p : std::expm1(p * ratio) / std::expm1(ratio));
}

/// The second divided difference of x^p: that of first ones, or the mean of the second derivative over the
/// triangle of the three (Hermite 1878, Genocchi 1869), where they are close to each other.
double second_difference(const double p, Three x)
{
  std::sort(x.begin(), x.end());
  if (x[2] > 1.3 * x[0])
    return (first_difference(p, x[2], x[1]) - first_difference(p, x[1], x[0])) / (x[2] - x[0]);
  static const dealii::QGauss<1> gauss(8);
  double sum = 0;
  for (unsigned int i = 0; i < gauss.size(); ++i)
    for (unsigned int j = 0; j < gauss.size(); ++j) {
      const double s = gauss.point(i)[0], t = (1 - s) * gauss.point(j)[0];
      sum += gauss.weight(i) * gauss.weight(j) * (1 - s) *
             std::pow(x[0] + s * (x[1] - x[0]) + t * (x[2] - x[0]), p - 2);
    }
  return p * (p - 1) * sum;
}

} // namespace

class Ogden : public HyperelasticLaw
{
public:
  explicit Ogden(const Section &section)
      : mu(section.require<std::vector<double>>("Moduli", "mu_p, one of each term [Pa]")),
        alpha(section.require<std::vector<double>>("Exponents", "alpha_p, as many [-]")),
        U(section, require_bulk_modulus(section))
  {
    section.check(mu.size() == alpha.size(), "Exponents", "must be as many as the Moduli.");
    double shear = 0;
    for (unsigned int p = 0; p < std::min(mu.size(), alpha.size()); ++p) {
      section.check(alpha[p] != 0, "Exponents", "must not be zero.");
      shear += mu[p] * alpha[p] / 2;
    }
    section.check(shear > 0, "Moduli",
                  "give half of the sum of Moduli times Exponents, the shear modulus of small "
                  "strains, as " +
                      in_words(shear) + ", which must be positive.");
  }

  const Volumetric *volume() const override { return &U; }

protected:
  // D_iJkL = delta_ik S_JL + F_iA F_kB C_AJBL
  void elastic_response(const Deformation &deformation, Tensor<2, 3> &P, Tensor<4, 3> *D) const override
  {
    const AtPoint at(*this, deformation);
    Tensor<2, 3> S;
    for (unsigned int a = 0; a < 3; ++a)
      for (unsigned int i = 0; i < 3; ++i)
        for (unsigned int j = 0; j < 3; ++j)
          S[i][j] += at.b[a] / at.c[a] * at.N[i][a] * at.N[j][a];
    P = deformation.F * S;
    if (D == nullptr)
      return;
    *D = 0;
    add_material_stiffness(deformation.F, deformation.F, turned(at.stiffness(), at.N), *D);
    add_geometric_stiffness(S, *D);
  }

  // with X = sym(F^T w) and K = dC/dE : X
  //   F_iA F_kB K_AJBL + (w_iA F_kB + F_iA w_kB) C_AJBL + delta_ik (C : X)_JL
  Tensor<4, 3> elastic_curvature(const Deformation &deformation, const Tensor<2, 3> &w) const override
  {
    const AtPoint at(*this, deformation);
    const Tensor<2, 3> &F = deformation.F, &N = at.N;
    const Tensor<2, 3> X = 0.5 * (transpose(F) * w + transpose(w) * F);
    const Tensor<4, 3> C = turned(at.stiffness(), N);
    Tensor<4, 3> result;
    add_material_stiffness(F, F, turned(at.change_of_stiffness(transpose(N) * X * N), N), result);
    add_material_stiffness(w, F, C, result);
    add_material_stiffness(F, w, C, result);
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int J = 0; J < 3; ++J)
        for (unsigned int L = 0; L < 3; ++L)
          result[i][J][i][L] += scalar_product(C[J][L], X);
    return result;
  }

private:
  /// S and its derivatives in the principal axes, which are the columns of N.
  struct AtPoint
  {
    AtPoint(const Ogden &law, const Deformation &deformation);
    Tensor<4, 3> stiffness() const;
    /// Its derivative by E, contracted with @p X.
    Tensor<4, 3> change_of_stiffness(const Tensor<2, 3> &X) const;

    Tensor<2, 3> N;
    Three c, b;

  private:
    double b_2(unsigned int k, unsigned int l) const;                 ///< db_k/d(ln l_l)
    double b_3(unsigned int k, unsigned int l, unsigned int m) const; ///< and its derivative
    double difference(unsigned int k, unsigned int l) const;          ///< (S_k - S_l)/(E_k - E_l)
    double difference(unsigned int k, unsigned int l, unsigned int m) const;
    double slope_of_difference(unsigned int k, unsigned int l, unsigned int m) const; ///< by E_m

    const Ogden &law;
    std::vector<Three> x;     ///< of each term
    std::vector<double> mean; ///< of x
    double log_J;
    VolumetricEnergy U;
    double a_1, a_2, a_3; ///< J U' and its derivatives by ln J
    double factor;        ///< of 1/c
  };

  const std::vector<double> mu, alpha;
  const Volumetric U;
};

Ogden::AtPoint::AtPoint(const Ogden &law, const Deformation &deformation)
    : law(law), log_J(std::log1p(deformation.J_minus_1)), U(law.U.at(deformation))
{
  const dealii::SymmetricTensor<2, 3> E = symmetrize(deformation.green_strain());
  const auto pairs = eigenvectors(E, dealii::SymmetricTensorEigenvectorMethod::jacobi);
  const double J = deformation.J;
  a_1 = J * U.U_1, a_2 = J * J * U.U_2 + a_1, a_3 = J * J * J * U.U_3 + 3 * J * J * U.U_2 + a_1;
  b = {{a_1, a_1, a_1}};
  Three stretch; // its logarithm, without change of volume
  for (unsigned int a = 0; a < 3; ++a) {
    for (unsigned int i = 0; i < 3; ++i)
      N[i][a] = pairs[a].second[i];
    c[a] = 1 + 2 * pairs[a].first;
    stretch[a] = std::log1p(2 * pairs[a].first) / 2 - log_J / 3;
  }
  factor = a_1;
  for (unsigned int p = 0; p < law.mu.size(); ++p) {
    Three grown; // x - 1
    for (unsigned int a = 0; a < 3; ++a)
      grown[a] = std::expm1(law.alpha[p] * stretch[a]);
    const double sum = grown[0] + grown[1] + grown[2];
    for (unsigned int a = 0; a < 3; ++a)
      b[a] += law.mu[p] * (grown[a] - sum / 3);
    x.push_back({{1 + grown[0], 1 + grown[1], 1 + grown[2]}});
    mean.push_back(1 + sum / 3);
    factor -= law.mu[p] * mean[p];
  }
}

double Ogden::AtPoint::b_2(const unsigned int k, const unsigned int l) const
{
  double result = a_2;
  for (unsigned int p = 0; p < x.size(); ++p)
    result += law.mu[p] * law.alpha[p] * ((k == l ? x[p][k] : 0) + (mean[p] - x[p][k] - x[p][l]) / 3);
  return result;
}

double Ogden::AtPoint::b_3(const unsigned int k, const unsigned int l, const unsigned int m) const
{
  double result = a_3;
  for (unsigned int p = 0; p < x.size(); ++p) {
    const double x_km = x[p][k] * ((k == m) - 1. / 3), x_lm = x[p][l] * ((l == m) - 1. / 3);
    result += law.mu[p] * law.alpha[p] * law.alpha[p] *
              ((k == l ? x_km : 0) + ((x[p][m] - mean[p]) / 3 - x_km - x_lm) / 3);
  }
  return result;
}

// S_a = sum_p mu_p J^(-alpha/3) c^(alpha/2 - 1) + factor/c
double Ogden::AtPoint::difference(const unsigned int k, const unsigned int l) const
{
  double result = factor * first_difference(-1, c[k], c[l]);
  for (unsigned int p = 0; p < x.size(); ++p)
    result +=
        law.mu[p] * std::exp(-law.alpha[p] / 3 * log_J) * first_difference(law.alpha[p] / 2 - 1, c[k], c[l]);
  return 2 * result;
}

double Ogden::AtPoint::difference(const unsigned int k, const unsigned int l, const unsigned int m) const
{
  const Three at = {{c[k], c[l], c[m]}};
  double result = factor * second_difference(-1, at);
  for (unsigned int p = 0; p < x.size(); ++p)
    result += law.mu[p] * std::exp(-law.alpha[p] / 3 * log_J) * second_difference(law.alpha[p] / 2 - 1, at);
  return 4 * result;
}

double Ogden::AtPoint::slope_of_difference(const unsigned int k, const unsigned int l,
                                           const unsigned int m) const
{
  double change = a_2, result = 0; // the first: of the factor by ln l_m
  for (unsigned int p = 0; p < x.size(); ++p) {
    change -= law.mu[p] * law.alpha[p] * (x[p][m] - mean[p]) / 3;
    result -= law.alpha[p] / 3 * law.mu[p] * std::exp(-law.alpha[p] / 3 * log_J) *
              first_difference(law.alpha[p] / 2 - 1, c[k], c[l]);
  }
  result += change * first_difference(-1, c[k], c[l]);
  result *= 2 / c[m];
  for (const unsigned int own : {k, l})
    if (own == m)
      result += difference(k, l, m);
  return result;
}

Tensor<4, 3> Ogden::AtPoint::stiffness() const
{
  Tensor<4, 3> C;
  for (unsigned int k = 0; k < 3; ++k)
    for (unsigned int l = 0; l < 3; ++l) {
      C[k][k][l][l] += b_2(k, l) / (c[k] * c[l]) - (k == l ? 2 * b[k] / (c[k] * c[k]) : 0);
      if (k != l)
        C[k][l][k][l] = C[k][l][l][k] = difference(k, l) / 2;
    }
  return C;
}

Tensor<4, 3> Ogden::AtPoint::change_of_stiffness(const Tensor<2, 3> &X) const
{
  Tensor<4, 3> K;
  for (unsigned int k = 0; k < 3; ++k)
    for (unsigned int l = 0; l < 3; ++l) {
      for (unsigned int m = 0; m < 3; ++m) {
        double third = b_3(k, l, m) / (c[k] * c[l] * c[m]); // of W by E_k, E_l, E_m
        if (k == m)
          third -= 2 * b_2(k, l) / (c[k] * c[k] * c[l]);
        if (l == m)
          third -= 2 * b_2(k, l) / (c[k] * c[l] * c[l]);
        if (k == l)
          third -= 2 * b_2(k, m) / (c[k] * c[k] * c[m]);
        if (k == l && k == m)
          third += 8 * b[k] / (c[k] * c[k] * c[k]);
        K[k][k][l][l] += third * X[m][m];
        if (k == l)
          continue;
        const double slope = slope_of_difference(k, l, m);
        K[k][l][k][l] += slope * X[m][m] / 2;
        K[k][l][l][k] += slope * X[m][m] / 2;
        K[m][m][k][l] += slope * X[k][l];
        K[k][l][m][m] += slope * X[k][l];
      }
      if (k == l)
        continue;
      const unsigned int m = 3 - k - l; // turns of all three axes
      const double value = difference(0, 1, 2) / 2 * X[k][m];
      K[k][l][l][m] += value;
      K[l][k][l][m] += value;
      K[k][l][m][l] += value;
      K[l][k][m][l] += value;
    }
  return K;
}

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<Ogden>(
    "Ogden", "Rubber-like solid for large strains, by powers of the principal stretches.");
}

} // namespace dovetail
