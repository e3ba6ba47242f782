// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/hyperelastic_law.h>

#include <cmath>

namespace dovetail {

using dealii::Tensor;

namespace {
/// (D:G)_iJ = D_iJkL G_kL
Tensor<2, 3> contract(const Tensor<4, 3> &D, const Tensor<2, 3> &G)
{
  Tensor<2, 3> result;
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int J = 0; J < 3; ++J)
      result[i][J] = scalar_product(D[i][J], G);
  return result;
}
} // namespace

// With G = F/s, P_e and D = dP_e/dG at G, and dG/de = -G/s:
//   P = s² P_e,  dP/dF = s D,  dP/de = 2 s P_e - s D:G.
bool HyperelasticLaw::evaluate(const Tensor<2, 3> &F, double e, bool with_derivatives,
                               Response &response) const
{
  const double s = 1 + e;
  const Tensor<2, 3> G = e == 0 ? F : F / s;
  const double J = determinant(G);
  if (!(s > 0 && J > 0 && std::isfinite(J)))
    return false;

  elastic_response(G, J, response.P, with_derivatives ? &response.dP_dF : nullptr);
  if (with_derivatives) {
    response.dP_de = s * (2. * response.P - contract(response.dP_dF, G));
    if (e != 0)
      response.dP_dF *= s;
  }
  if (e != 0)
    response.P *= s * s;
  return std::isfinite(response.P.norm_square());
}

// With T = d²(w:P_e)/dG²:
//   FF = T,  Fe = w:D - T:G,  ee = 2 w:P_e - 2 w:D:G + G:T:G.
SolidLaw::Curvature HyperelasticLaw::curvature(const Tensor<2, 3> &F, double e, const Tensor<2, 3> &w) const
{
  const Tensor<2, 3> G = F / (1 + e);
  const double J = determinant(G);
  Assert(J > 0, dealii::ExcMessage("The curvature exists only where evaluate() succeeds."));

  Tensor<2, 3> P;
  Tensor<4, 3> D;
  elastic_response(G, J, P, &D);
  const Tensor<2, 3> w_D = contract(D, w); // D has major symmetry

  Curvature result;
  result.FF = elastic_curvature(G, J, w);
  const Tensor<2, 3> T_G = contract(result.FF, G);
  result.Fe = w_D - T_G;
  result.ee = 2 * scalar_product(w, P) - 2 * scalar_product(w_D, G) + scalar_product(G, T_G);
  return result;
}

} // namespace dovetail
