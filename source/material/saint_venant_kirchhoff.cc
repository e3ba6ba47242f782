// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Hooke's law in the Green strain E = (F^T F - I)/2 = (H + H^T + H^T H)/2: large rotations, moderate strains
// (it softens in compression).
//
//     W_e = lambda/2 (tr E)^2 + mu E:E
//     P_e = F S,   S = lambda tr(E) I + 2 mu E
//
// Reference: Holzapfel, Nonlinear Solid Mechanics (2000), section 6.5, eq. (6.151).
//
//     subsection Solid
//       set Type          = Saint Venant-Kirchhoff
//       set Young modulus = 210e9    # Pa
//       set Poisson ratio = 0.3
//     end

#include <dovetail/material/coefficient.h>
#include <dovetail/material/hyperelastic_law.h>
#include <dovetail/scene/catalogue.h>

namespace dovetail {

using dealii::Tensor;

class SaintVenantKirchhoff : public HyperelasticLaw
{
public:
  explicit SaintVenantKirchhoff(const Section &section) : moduli(*this, section) {}

protected:
  // D_iJkL = delta_ik S_LJ + lambda F_iJ F_kL + mu (F_iL F_kJ + (F F^T)_ik delta_JL)
  void elastic_response(const Deformation &deformation, Tensor<2, 3> &P, Tensor<4, 3> *D) const override
  {
    const IsotropicModuli m = moduli.at(deformation.place);
    const double lambda = m.lame(), mu = m.shear;
    const Tensor<2, 3> &F = deformation.F;
    const Tensor<2, 3> S = stress(deformation);
    P = F * S;
    if (D == nullptr)
      return;

    const Tensor<2, 3> mu_b = mu * F * transpose(F);
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int J = 0; J < 3; ++J)
        for (unsigned int k = 0; k < 3; ++k) {
          Tensor<1, 3> &row = (*D)[i][J][k];
          row = lambda * F[i][J] * F[k] + mu * F[k][J] * F[i];
          row[J] += mu_b[i][k];
          if (i == k)
            row += S[J];
        }
  }

  // w:D = w S + lambda (w:F) F + mu (F w^T F + F F^T w), and its derivative by F_mN:
  // lambda (w_kL F_mN + F_kL w_mN) + mu (w_kN F_mL + F_kN w_mL)
  // + delta_km (lambda w:F I + mu (w^T F + F^T w))_NL + delta_LN mu (w F^T + F w^T)_km
  Tensor<4, 3> elastic_curvature(const Deformation &deformation, const Tensor<2, 3> &w) const override
  {
    const IsotropicModuli m = moduli.at(deformation.place);
    const double lambda = m.lame(), mu = m.shear;
    const Tensor<2, 3> &F = deformation.F;
    const Tensor<2, 3> a = mu * (w * transpose(F) + F * transpose(w));
    Tensor<2, 3> b = mu * (transpose(w) * F + transpose(F) * w);
    for (unsigned int i = 0; i < 3; ++i)
      b[i][i] += lambda * scalar_product(w, F);

    Tensor<4, 3> result;
    for (unsigned int k = 0; k < 3; ++k)
      for (unsigned int L = 0; L < 3; ++L)
        for (unsigned int m = 0; m < 3; ++m) {
          Tensor<1, 3> &row = result[k][L][m];
          row = lambda * (w[k][L] * F[m] + F[k][L] * w[m]) + mu * (F[m][L] * w[k] + w[m][L] * F[k]);
          row[L] += a[k][m];
          if (k == m)
            row += b[L];
        }
    return result;
  }

private:
  Tensor<2, 3> stress(const Deformation &deformation) const
  {
    const IsotropicModuli m = moduli.at(deformation.place);
    Tensor<2, 3> S = 2 * m.shear * deformation.green_strain();
    for (unsigned int i = 0; i < 3; ++i)
      S[i][i] += m.lame() * deformation.trace_of_green_strain();
    return S;
  }

  const VaryingModuli moduli;
};

namespace {
[[maybe_unused]] const bool registered = Catalogue<SolidLaw>::add<SaintVenantKirchhoff>(
    "Saint Venant-Kirchhoff", "Hooke's law in the Green strain: large rotations and moderate strains.");
}

} // namespace dovetail
