// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Moduli and expansions that are formulas: derivatives and curvature by the temperature against differences,
// the stress against that of numbers, and what an energy by T as a formula gives.

#include "law_check.h"

const std::string young = "\nset Young modulus = 3 + 0.5*T + 0.2*T^2\nset Poisson ratio = 0.2 + 0.05*sin(T)";
const std::string shear = "\nset Shear modulus = 1 + 0.1*T^2\nset Bulk modulus = 4 - 0.3*T + 0.05*x";
const std::string varying_expansion =
    "\nset Expansion coefficient = 0.01*(1 + 0.2*T^2)\nset Reference temperature = 2.5";

void check(const std::string &type, const std::string &parameters, const std::string &scene = "")
{
  const std::string law = "set Type = " + type + parameters;
  if (scene.empty())
    check_differences(type, make_material<3>(law + varying_expansion, conducts));
  check_differences(type + (scene.empty() ? "" : ", plane stress"),
                    make_material<2>(law + varying_expansion, conducts, "", scene));
}

/// At one temperature a formula is the number that it gives there.
void check_values()
{
  Random random;
  const Material<3> formulas =
      make_material<3>("set Type = neo-Hookean" + shear + varying_expansion, conducts);
  State<3> state = random.state(formulas);
  state.value[3] = 3;
  state.X = Point<3>(0.4, 0, 0);
  Response<3> one(4), other(4);
  formulas.evaluate(state, false, one);
  const Material<3> numbers = make_material<3>(
      "set Type = neo-Hookean\nset Shear modulus = 1.9\nset Bulk modulus = 3.12\nset Expansion coefficient = "
      "0.028\nset Reference temperature = 2.5",
      conducts);
  numbers.evaluate(state, false, other);
  double error = 0;
  for (unsigned int c = 0; c < 3; ++c)
    error = std::max(error, (one.flux[c] - other.flux[c]).norm() / other.flux[c].norm());
  report("a formula is the number that it gives", error, 1e-14);
  report("energy", std::abs(formulas.energy_density(state) / numbers.energy_density(state) - 1), 1e-9);
}

/// Where a modulus leaves its range the law is not defined, and says why.
void check_ranges()
{
  const Material<3> material = make_material<3>(
      "set Type = linear elastic\nset Young modulus = 4 - T\nset Poisson ratio = 0.3", conducts);
  State<3> state(4);
  Response<3> response(4);
  state.value[3] = 3;
  report("defined where the modulus is positive", material.evaluate(state, true, response));
  state.value[3] = 5;
  report("not defined where it is negative", !material.evaluate(state, true, response));
  report("depends on T, so it is not linear", !material.is_linear(0));
  const Material<3> in_space =
      make_material<3>("set Type = linear elastic\nset Young modulus = 4 + x\nset Poisson ratio = 0.3", "");
  report("linear if it depends on x alone", in_space.is_linear(0));
  report("without time", !in_space.depends_on_time());
  report("with time", make_material<3>("set Type = linear elastic\nset Young modulus = 4 + t\nset Poisson "
                                       "ratio = 0.3",
                                       "")
                          .depends_on_time());
}

int main()
{
  check("linear elastic", young);
  check("linear elastic", young, "set Geometry = plane stress\n");
  check("Saint Venant-Kirchhoff", shear);
  check("neo-Hookean", young);
  check("neo-Hookean", shear + "\nset Volumetric = Liu", "set Geometry = plane stress\n");
  check("Gent", shear + "\nset Limit = 20");
  check("Arruda-Boyce", young + "\nset Locking stretch = 3");
  check("Mooney-Rivlin", "\nset C10 = 0.5 + 0.1*T\nset C01 = 0.2*exp(-T)\nset Bulk modulus = 3 + T");
  check("Yeoh", "\nset C10 = 0.5 + 0.1*T\nset C20 = 0.02*T\nset C30 = 0.01\nset Bulk modulus = 3 + T");
  check("energy", "\nset Energy = (0.5 + 0.1*T)*(I1_bar - 3) + 0.1*T^2*(I2_bar - 3) + (2 + T)*(J - 1)^2");
  check("Ogden", "\nset Moduli = 1, 0.3\nset Exponents = 2, 3\nset Bulk modulus = 4");
  check_values();
  check_ranges();
}
