// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rubber-like solid for large strains. With J = det F, C = F^T F, H = F^-T and a = mu J^(-2/3):
//
//     W_e = mu/2 (J^(-2/3) tr C - 3) + kappa/4 (J^2 - 1 - 2 ln J)
//     P_e = a F + p H,   p = kappa/2 (J^2 - 1) - a tr(C)/3
//
// Reference: Simo & Taylor (1982) and Holzapfel, Nonlinear Solid Mechanics (2000), sections 6.4 and 6.5; the
// derivatives in doc/theory/laws.md.
//
//     subsection Solid
//       set Type          = neo-Hookean
//       set Shear modulus = 0.4e6    # Pa
//       set Bulk modulus  = 2e6      # Pa
//     end

#include <dovetail/material/hyperelastic_law.h>
#include <dovetail/scene/catalogue.h>

#include <cmath>

namespace dovetail {

using dealii::Tensor;

class NeoHookean : public HyperelasticLaw
{
public:
  explicit NeoHookean(const Section &section) : moduli(section) {}

protected:
  // D_iJkL = a delta_ik delta_JL - 2/3 a (F_iJ H_kL + H_iJ F_kL) + q H_iJ H_kL - p H_iL H_kJ,
  // where dp/dF = q H - 2/3 a F
  void elastic_response(const Tensor<2, 3> &F, double J, Tensor<2, 3> &P, Tensor<4, 3> *D) const override
  {
    const Letters l(F, J, moduli);
    P = l.a * F + l.p * l.H;
    if (D == nullptr)
      return;

    const Tensor<2, 3> &H = l.H;
    const Tensor<2, 3> dp = l.q * H - 2. / 3. * l.a * F;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int M = 0; M < 3; ++M)
        for (unsigned int k = 0; k < 3; ++k) {
          const double F_iM = -2. / 3. * l.a * F[i][M], H_iM = H[i][M], H_kM = -l.p * H[k][M];
          Tensor<1, 3> &row = (*D)[i][M][k];
          for (unsigned int L = 0; L < 3; ++L)
            row[L] = F_iM * H[k][L] + H_iM * dp[k][L] + H_kM * H[i][L];
          if (i == k)
            row[M] += l.a;
        }
  }

  // With Y = H w^T H (so that d(w:H)/dF = -Y), w_F = w:F and w_H = w:H, the derivative of
  //   w:D = a w - 2/3 a (w_F H + w_H F) + q w_H H - p Y
  // by F_mN is, both ways round where two tensors differ,
  //   - 2/3 a w_H delta_km delta_LN + (2/3 a w_F - q w_H) H_kN H_mL + p (H_kN Y_mL + Y_kN H_mL)
  //   + H (x) (4/9 a w_H F - 2/3 a w - q Y) + 2/3 a F (x) Y + (4/9 a w_F + r w_H) H (x) H
  Tensor<4, 3> elastic_curvature(const Tensor<2, 3> &F, double J, const Tensor<2, 3> &w) const override
  {
    const Letters l(F, J, moduli);
    const Tensor<2, 3> &H = l.H;
    const Tensor<2, 3> Y = H * transpose(w) * H;
    const double b = 2. / 3. * l.a, w_F = scalar_product(w, F), w_H = scalar_product(w, H);
    const Tensor<2, 3> Z = 2. / 3. * b * w_H * F - b * w - l.q * Y + (b * w_F / 3 + l.r * w_H / 2) * H;
    const double c = b * w_F - l.q * w_H;

    Tensor<4, 3> result;
    for (unsigned int k = 0; k < 3; ++k)
      for (unsigned int L = 0; L < 3; ++L)
        for (unsigned int m = 0; m < 3; ++m) {
          Tensor<1, 3> &row = result[k][L][m];
          for (unsigned int N = 0; N < 3; ++N)
            row[N] = H[k][L] * Z[m][N] + Z[k][L] * H[m][N] + b * (F[k][L] * Y[m][N] + Y[k][L] * F[m][N]) +
                     H[k][N] * (c * H[m][L] + l.p * Y[m][L]) + l.p * Y[k][N] * H[m][L];
          if (k == m)
            row[L] -= b * w_H;
        }
    return result;
  }

private:
  /// The letters of the formulas above; q and r are those of dp/dF = q H - 2/3 a F and dq/dF = r H + 4/9 a F.
  struct Letters
  {
    Letters(const Tensor<2, 3> &F, double J, const IsotropicModuli &moduli)
        : H(transpose(invert(F))), a(moduli.shear / std::cbrt(J * J))
    {
      const double a_tr_C = a * F.norm_square(), kappa_J2 = moduli.bulk * J * J;
      p = (kappa_J2 - moduli.bulk) / 2 - a_tr_C / 3;
      q = kappa_J2 + 2. / 9. * a_tr_C;
      r = 2 * kappa_J2 - 4. / 27. * a_tr_C;
    }
    Tensor<2, 3> H;
    double a, p, q, r;
  };

  const IsotropicModuli moduli;
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<NeoHookean>(
    "neo-Hookean", "Rubber-like solid for large strains, with a separate resistance to changes of volume.");
}

} // namespace dovetail
