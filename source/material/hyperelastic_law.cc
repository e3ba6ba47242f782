// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/hyperelastic_law.h>
#include <dovetail/scene/undefined.h>

#include <cmath>

namespace dovetail {

using dealii::Tensor;

namespace {
/// (D:F)_iJ = D_iJkL F_kL
Tensor<2, 3> contract(const Tensor<4, 3> &D, const Tensor<2, 3> &F)
{
  Tensor<2, 3> result;
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int J = 0; J < 3; ++J)
      result[i][J] = scalar_product(D[i][J], F);
  return result;
}

/// H_e = F/s - I: the part of H that is not free expansion.
Tensor<2, 3> elastic_part(const Tensor<2, 3> &H, const double e)
{
  if (e == 0)
    return H;
  Tensor<2, 3> H_e = H;
  for (unsigned int i = 0; i < 3; ++i)
    H_e[i][i] -= e;
  return H_e / (1 + e);
}
} // namespace

Tensor<4, 3> turned(Tensor<4, 3> T, const Tensor<2, 3> &N)
{
  for (unsigned int turn = 0; turn < 4; ++turn) { // each time the first index becomes the last one
    Tensor<4, 3> next;
    for (unsigned int a = 0; a < 3; ++a)
      for (unsigned int b = 0; b < 3; ++b)
        for (unsigned int c = 0; c < 3; ++c)
          for (unsigned int d = 0; d < 3; ++d)
            for (unsigned int i = 0; i < 3; ++i)
              next[b][c][d][i] += N[i][a] * T[a][b][c][d];
    T = next;
  }
  return T;
}

Deformation::Deformation(const Tensor<2, 3> &H, const SolidLaw::Place &place) : H(H), F(H), place(place)
{
  for (unsigned int i = 0; i < 3; ++i)
    F[i][i] += 1;
  const double minors = H[0][0] * H[1][1] - H[0][1] * H[1][0] + H[0][0] * H[2][2] - H[0][2] * H[2][0] +
                        H[1][1] * H[2][2] - H[1][2] * H[2][1];
  J_minus_1 = trace(H) + minors + determinant(H);
  J = 1 + J_minus_1;
}

Tensor<2, 3> Deformation::green_strain() const
{
  return 0.5 * (H + transpose(H) + transpose(H) * H);
}

double Deformation::trace_of_green_strain() const
{
  return trace(H) + H.norm_square() / 2;
}

// With the elastic part F_e = F/s, P_e and D = dP_e/dF_e, and dF_e/de = -F_e/s:
//   P = s² P_e,  dP/dF = s D,  dP/de = 2 s P_e - s D:F_e.
bool HyperelasticLaw::evaluate(const Tensor<2, 3> &H, double e, bool with_derivatives,
                               Response &response) const
{
  const double s = 1 + e;
  const Deformation elastic(elastic_part(H, e), response);
  if (!(s > 0))
    return undefined("the free thermal strain is " + in_words(e) + ", but must be greater than -1");
  if (!(elastic.J > 0 && std::isfinite(elastic.J)))
    return undefined("the change of volume J = det F is " + in_words(elastic.J * s * s * s) +
                     ", but must be positive");

  if (!is_defined(elastic))
    return false;
  elastic_response(elastic, response.P, with_derivatives ? &response.dP_dF : nullptr);
  if (with_derivatives && response.needs_dP_de)
    response.dP_de = s * (2. * response.P - contract(response.dP_dF, elastic.F));
  if (with_derivatives && e != 0)
    response.dP_dF *= s;
  if (e != 0)
    response.P *= s * s;
  return std::isfinite(response.P.norm_square()) || undefined("the stress is not a finite number");
}

// With T = d²(w:P_e)/dF_e²:
//   FF = T,  Fe = w:D - T:F_e,  ee = 2 w:P_e - 2 w:D:F_e + F_e:T:F_e.
SolidLaw::Curvature HyperelasticLaw::curvature(const Tensor<2, 3> &H, double e, const Tensor<2, 3> &w,
                                               const Place &place) const
{
  const Deformation elastic(elastic_part(H, e), place);
  const Tensor<2, 3> &F_e = elastic.F;
  Assert(elastic.J > 0, dealii::ExcMessage("The curvature exists only where evaluate() succeeds."));

  Tensor<2, 3> P;
  Tensor<4, 3> D;
  elastic_response(elastic, P, &D);
  const Tensor<2, 3> w_D = contract(D, w); // D has major symmetry

  Curvature result;
  result.FF = elastic_curvature(elastic, w);
  const Tensor<2, 3> T_F = contract(result.FF, F_e);
  result.Fe = w_D - T_F;
  result.ee = 2 * scalar_product(w, P) - 2 * scalar_product(w_D, F_e) + scalar_product(F_e, T_F);
  return result;
}

void HyperelasticLaw::add_material_stiffness(const Tensor<2, 3> &A, const Tensor<2, 3> &B,
                                             const Tensor<4, 3> &C, Tensor<4, 3> &D)
{
  for (unsigned int J = 0; J < 3; ++J)
    for (unsigned int L = 0; L < 3; ++L) {
      Tensor<2, 3> block;
      for (unsigned int M = 0; M < 3; ++M)
        for (unsigned int N = 0; N < 3; ++N)
          block[M][N] = C[M][J][N][L];
      block = A * block * transpose(B);
      for (unsigned int i = 0; i < 3; ++i)
        for (unsigned int k = 0; k < 3; ++k)
          D[i][J][k][L] += block[i][k];
    }
}

void HyperelasticLaw::add_geometric_stiffness(const Tensor<2, 3> &S, Tensor<4, 3> &D)
{
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int J = 0; J < 3; ++J)
      D[i][J][i] += S[J];
}

} // namespace dovetail
