// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Solids around an axis: derivatives of the flux against differences, off the axis and on it (x <= 0 here);
// flux and source against the stress of the same law in 3D with H_33 = u_r/r, which has the limit H_11 on the
// axis; and the strain that is shown.

#include "law_check.h"

namespace {

void check_against_3d(const std::string &type)
{
  const std::string law = "set Type = " + type + moduli + expansion;
  const Material<2> material = make_material<2>(law, conducts, "", "set Geometry = axisymmetric\n");
  const Material<3> full = make_material<3>(law, conducts);
  Random random;
  double flux_error = 0, source_error = 0, strain_error = 0;
  for (const double r : {0.7, 2.5, 0.}) {
    State<2> state = random.state(material);
    state.X[0] = r;
    state.value[0] = 0.2 * r; // not of the size of the temperature
    Response<2> response(3);
    material.evaluate(state, false, response);
    Tensor<2, 3> F = dealii::unit_symmetric_tensor<3>();
    for (unsigned int i = 0; i < 2; ++i)
      for (unsigned int j = 0; j < 2; ++j)
        F[i][j] += state.gradient[i][j];
    const double hoop = r > 0 ? 0.2 : state.gradient[0][0];
    F[2][2] += hoop;
    const Tensor<2, 3> P = stress(full, F, state.value[2]);
    for (unsigned int i = 0; i < 2; ++i)
      for (unsigned int j = 0; j < 2; ++j)
        flux_error = std::max(flux_error, std::abs(response.flux[i][j] - P[i][j]));
    source_error = std::max(source_error, std::abs(response.source[0] - (r > 0 ? P[2][2] / r : 0)));
    strain_error = std::max(strain_error, std::abs(material.displacement_gradient(state)[2][2] - hoop));
  }
  report(type + ", flux", flux_error, 1e-13);
  report(type + ", source", source_error, 1e-13);
  report(type + ", strain", strain_error, 1e-15);
}

} // namespace

int main()
{
  const std::string axisymmetric = "set Geometry = axisymmetric\n";
  for (const std::string type : {"linear elastic", "Saint Venant-Kirchhoff", "neo-Hookean"}) {
    check_differences(type, make_material<2>("set Type = " + type + moduli, "", "", axisymmetric));
    check_differences(type + ", expanding", make_material<2>("set Type = " + type + moduli + expansion,
                                                             conducts, "", axisymmetric));
    check_against_3d(type);
  }
}
