// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/isochoric_flow.h>
#include <dovetail/scene/undefined.h>

#include <cmath>
#include <limits>

namespace dovetail {

using dealii::Tensor;

double IsochoricFlow::energy(const Tensor<2, 3> &H, const double e, const Place &place) const
{
  Response response;
  static_cast<Place &>(response) = place;
  return evaluate(H, e, false, response) ? moduli.energy_of(response.P)
                                         : std::numeric_limits<double>::quiet_NaN();
}

Tensor<2, 3> IsochoricFlow::deviator(const Tensor<2, 3> &H, const double *const eps_p) const
{
  const double mean = 2. / 3. * trace(H);
  Tensor<2, 3> result;
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int j = 0; j < 3; ++j)
      result[i][j] = moduli.shear * (H[i][j] + H[j][i] - (i == j ? mean : 0.) - 2 * eps_p[3 * i + j]);
  return result;
}

bool IsochoricFlow::set_stress(const Tensor<2, 3> &deviator, const Tensor<2, 3> &H, const double e,
                               Response &response) const
{
  response.P = deviator;
  for (unsigned int i = 0; i < 3; ++i)
    response.P[i][i] += moduli.bulk_of_stress() * (trace(H) - 3 * e);
  return std::isfinite(response.P.norm_square()) || undefined("the stress is not a finite number");
}

void IsochoricFlow::set_derivatives(const Tensor<2, 3> &n, const double c, const double s,
                                    Response &response) const
{
  const double mu = moduli.shear, along_flow = 2 * mu * (s - c);
  Tensor<4, 3> &D = response.dP_dF;
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int j = 0; j < 3; ++j)
      for (unsigned int k = 0; k < 3; ++k)
        D[i][j][k] = along_flow == 0 ? Tensor<1, 3>() : along_flow * n[i][j] * n[k];
  response.dP_de = 0;
  for (unsigned int i = 0; i < 3; ++i) {
    for (unsigned int j = 0; j < 3; ++j) {
      D[i][j][i][j] += mu * c;
      D[i][j][j][i] += mu * c;
      D[i][i][j][j] += moduli.bulk_of_stress() - 2. / 3. * mu * c;
    }
    response.dP_de[i][i] = -3 * moduli.bulk_of_stress();
  }
}

} // namespace dovetail
