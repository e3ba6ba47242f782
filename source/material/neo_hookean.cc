// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rubber-like solid for large strains. With J = det F, C = F^T F = I + 2E, Q = F^-T and a = mu J^(-2/3):
//
//     W_e = mu/2 (J^(-2/3) tr C - 3) + kappa/4 (J^2 - 1 - 2 ln J)
//     P_e = a F + p Q,   p = kappa/2 (J^2 - 1) - a tr(C)/3
//         = a (H + Q H^T) + (p + a) Q,   p + a = kappa/2 (J - 1) (J + 1) - 2/3 a tr E
//
// The second form has the same value and vanishes with H = F - I term by term.
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
  // D_iJkL = a delta_ik delta_JL - 2/3 a (F_iJ Q_kL + Q_iJ F_kL) + q Q_iJ Q_kL - p Q_iL Q_kJ,
  // where dp/dF = q Q - 2/3 a F
  void elastic_response(const Deformation &deformation, Tensor<2, 3> &P, Tensor<4, 3> *D) const override
  {
    const Letters l(deformation, moduli);
    const Tensor<2, 3> &F = deformation.F, &H = deformation.H, &Q = l.Q;
    P = l.a * (H + Q * transpose(H)) + l.p_plus_a * Q;
    if (D == nullptr)
      return;

    const Tensor<2, 3> dp = l.q * Q - 2. / 3. * l.a * F;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int M = 0; M < 3; ++M)
        for (unsigned int k = 0; k < 3; ++k) {
          const double F_iM = -2. / 3. * l.a * F[i][M], Q_iM = Q[i][M], Q_kM = -l.p * Q[k][M];
          Tensor<1, 3> &row = (*D)[i][M][k];
          for (unsigned int L = 0; L < 3; ++L)
            row[L] = F_iM * Q[k][L] + Q_iM * dp[k][L] + Q_kM * Q[i][L];
          if (i == k)
            row[M] += l.a;
        }
  }

  // With Y = Q w^T Q (so that d(w:Q)/dF = -Y), w_F = w:F and w_Q = w:Q, the derivative of
  //   w:D = a w - 2/3 a (w_F Q + w_Q F) + q w_Q Q - p Y
  // by F_mN is, both ways round where two tensors differ,
  //   - 2/3 a w_Q delta_km delta_LN + (2/3 a w_F - q w_Q) Q_kN Q_mL + p (Q_kN Y_mL + Y_kN Q_mL)
  //   + Q (x) (4/9 a w_Q F - 2/3 a w - q Y) + 2/3 a F (x) Y + (4/9 a w_F + r w_Q) Q (x) Q
  Tensor<4, 3> elastic_curvature(const Deformation &deformation, const Tensor<2, 3> &w) const override
  {
    const Letters l(deformation, moduli);
    const Tensor<2, 3> &F = deformation.F, &Q = l.Q;
    const Tensor<2, 3> Y = Q * transpose(w) * Q;
    const double b = 2. / 3. * l.a, w_F = scalar_product(w, F), w_Q = scalar_product(w, Q);
    const Tensor<2, 3> Z = 2. / 3. * b * w_Q * F - b * w - l.q * Y + (b * w_F / 3 + l.r * w_Q / 2) * Q;
    const double c = b * w_F - l.q * w_Q;

    Tensor<4, 3> result;
    for (unsigned int k = 0; k < 3; ++k)
      for (unsigned int L = 0; L < 3; ++L)
        for (unsigned int m = 0; m < 3; ++m) {
          Tensor<1, 3> &row = result[k][L][m];
          for (unsigned int N = 0; N < 3; ++N)
            row[N] = Q[k][L] * Z[m][N] + Z[k][L] * Q[m][N] + b * (F[k][L] * Y[m][N] + Y[k][L] * F[m][N]) +
                     Q[k][N] * (c * Q[m][L] + l.p * Y[m][L]) + l.p * Y[k][N] * Q[m][L];
          if (k == m)
            row[L] -= b * w_Q;
        }
    return result;
  }

private:
  /// The letters of the formulas above; q and r are those of dp/dF = q Q - 2/3 a F and dq/dF = r Q + 4/9 a F.
  struct Letters
  {
    Letters(const Deformation &deformation, const IsotropicModuli &moduli)
        : Q(transpose(invert(deformation.F))), a(moduli.shear / std::cbrt(deformation.J * deformation.J))
    {
      const double J = deformation.J, tr_E = deformation.trace_of_green_strain();
      const double a_tr_C = a * (3 + 2 * tr_E), kappa_J2 = moduli.bulk * J * J;
      p_plus_a = moduli.bulk / 2 * deformation.J_minus_1 * (J + 1) - 2. / 3. * a * tr_E;
      p = p_plus_a - a;
      q = kappa_J2 + 2. / 9. * a_tr_C;
      r = 2 * kappa_J2 - 4. / 27. * a_tr_C;
    }
    Tensor<2, 3> Q;
    double a, p, p_plus_a, q, r;
  };

  const IsotropicModuli moduli;
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<NeoHookean>(
    "neo-Hookean", "Rubber-like solid for large strains, with a separate resistance to changes of volume.");
}

} // namespace dovetail
