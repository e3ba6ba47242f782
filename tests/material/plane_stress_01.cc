// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Solids in plane stress: derivatives against differences, Hooke's law against its closed form, and no stress
// across a sheet of rubber, whose Cauchy stress under simple tension is that of the closed form.

#include "law_check.h"

namespace {

Material<2> sheet(const std::string &solid, const std::string &heat = "")
{
  return make_material<2>(solid, heat, "", "set Geometry = plane stress\n");
}

void check_hooke()
{
  const double E = 3, nu = 0.3, alpha = 0.02;
  const Material<2> material =
      sheet("set Type = linear elastic\nset Young modulus = 3\nset Poisson ratio = 0.3\n"
            "set Expansion coefficient = 0.02",
            conducts);
  State<2> state(3);
  state.gradient[0] = Point<2>(0.3, 0.1);
  state.gradient[1] = Point<2>(-0.2, 0.5);
  state.value[2] = 4; // a free strain of 0.08
  Response<2> response(3);
  material.evaluate(state, true, response);
  const double factor = E / (1 - nu * nu), x = 0.3 - 4 * alpha, y = 0.5 - 4 * alpha;
  report("Hooke, along x", std::abs(response.flux[0][0] - factor * (x + nu * y)), 1e-14);
  report("Hooke, along y", std::abs(response.flux[1][1] - factor * (y + nu * x)), 1e-14);
  report("Hooke, shear", std::abs(response.flux[0][1] - E / (2 * (1 + nu)) * (0.1 - 0.2)), 1e-14);
  report("Hooke, derivative", std::abs(response.by_gradient[0][0][0] - factor), 1e-14);
  report("Hooke, linear", material.is_linear(0));
}

/// J of a neo-Hookean bar with the stretch 2, from mu J^(-5/3) (4 - s^2) ... = 0 across: both directions
/// across are free, so the Cauchy stress is the one along the bar alone.
void check_tension()
{
  const Material<2> material =
      sheet("set Type = neo-Hookean\nset Shear modulus = 1.3\nset Bulk modulus = 2.7");
  State<2> state(2);
  state.gradient[0][0] = 1;
  double low = -0.9, high = 0; // of the strain that makes the side free
  Response<2> response(2);
  for (unsigned int i = 0; i < 100; ++i) {
    state.gradient[1][1] = (low + high) / 2;
    material.evaluate(state, false, response);
    (response.flux[1][1] > 0 ? high : low) = state.gradient[1][1];
  }
  const Tensor<2, 3> sigma = material.cauchy_stress(state);
  const double s = 1 + state.gradient[1][1], J = 2 * s * s; // by symmetry both sides are alike
  const double along = 2. / 3 * 1.3 * std::pow(J, -5. / 3) * (4 - s * s) + 2.7 / 2 * (J - 1 / J);
  report("tension, across the sheet", std::abs(sigma[2][2]), 1e-13);
  report("tension, across the bar", std::abs(sigma[1][1]), 1e-13);
  report("tension, along", std::abs(sigma[0][0] - along), 1e-13);
}

} // namespace

int main()
{
  for (const std::string type : {"linear elastic", "Saint Venant-Kirchhoff", "neo-Hookean"}) {
    check_differences(type, sheet("set Type = " + type + moduli));
    check_differences(type + ", expanding", sheet("set Type = " + type + moduli + expansion, conducts));
  }
  check_differences("Mooney-Rivlin", sheet("set Type = Mooney-Rivlin\nset C10 = 0.45\nset C01 = 0.2\n"
                                           "set Bulk modulus = 2.7"));
  check_hooke();
  check_tension();
}
