// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Orthotropic solids and those with fibres against their energies, in axes that turn with the point;
// engineering constants against a tension test along each axis.

#include "law_check.h"

#include <dovetail/scene/user_error.h>

namespace {

template <typename Number>
Number along(const Matrix<Number> &E, const std::array<double, 3> &a, const std::array<double, 3> &b)
{
  Number result = 0.;
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int j = 0; j < 3; ++j)
      result += E[i][j] * (a[i] * b[j]);
  return result;
}

template <typename Number>
Matrix<Number> green_strain(const Matrix<Number> &F)
{
  Matrix<Number> E = right_cauchy_green(F);
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int j = 0; j < 3; ++j)
      E[i][j] = 0.5 * (E[i][j] - (i == j ? 1. : 0.));
  return E;
}

const std::array<double, 3> a_1 = {{0.6, 0.8, 0}}, a_2 = {{0, 0, 1}}, a_3 = {{0.8, -0.6, 0}};
const std::string constants =
    "\nset Young moduli = 3, 1, 2\nset Poisson ratios = 0.3, 0.2, 0.1\nset Shear moduli = 0.5, 0.7, 0.9";
const std::string axes = "\nset First axis = 3; 4; 0\nset Second axis = 3; 4; 5";

/// E : C : E/2, by the compliance of the axes
struct Orthotropic
{
  template <typename Number>
  Number operator()(const Matrix<Number> &F) const
  {
    const Matrix<Number> E = green_strain(F);
    FullMatrix<double> stiffness(3, 3);
    const double compliance[9] = {1. / 3, -0.1, -0.2 / 3, -0.1, 1, -0.1, -0.2 / 3, -0.1, 0.5};
    stiffness.fill(compliance);
    stiffness.gauss_jordan();
    const std::array<std::array<double, 3>, 3> a = {{a_1, a_2, a_3}};
    Number W =
        2. * (0.5 * along(E, a_1, a_2) * along(E, a_1, a_2) + 0.7 * along(E, a_1, a_3) * along(E, a_1, a_3) +
              0.9 * along(E, a_2, a_3) * along(E, a_2, a_3));
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        W += 0.5 * stiffness(i, j) * along(E, a[i], a[i]) * along(E, a[j], a[j]);
    return W;
  }
};

struct Fibres
{
  template <typename Number>
  Number operator()(const Matrix<Number> &F) const
  {
    const Matrix<Number> C = right_cauchy_green(F), E = green_strain(F);
    const Number J = determinant_of(F), ln_J = log(J);
    Number W = 1.3 / 2 * (exp(-2. / 3. * ln_J) * (C[0][0] + C[1][1] + C[2][2]) - 3.) +
               2.7 / 16 * (exp(-4. * ln_J) - 1. + 4. * ln_J);
    for (const auto &a : {a_1, a_3}) {
      const Number stretch = 2. * along(E, a, a);
      if (stretch > 0.)
        W += 0.9 / (2 * 1.2) * (exp(1.2 * stretch * stretch) - 1.);
    }
    return W;
  }
};

/// P_e at H without anything else, and whether it turns with a rotation after it.
void check_objectivity(const std::string &name, const std::string &law)
{
  const Material<3> material = make_material<3>(law, conducts);
  Random random;
  double error = 0;
  for (unsigned int sample = 0; sample < 5; ++sample) {
    Tensor<2, 3> F = dealii::unit_symmetric_tensor<3>();
    for (unsigned int i = 0; i < 3; ++i)
      F[i] += 0.3 * random.vector<3>();
    const Tensor<2, 3> R = random.rotation(), P = stress(material, F, 1);
    error = std::max(error, (stress(material, R * F, 1) - R * P).norm() / P.norm());
  }
  report(name + ", objectivity", error, 1e-13);
}

/// Tension along the first axis of the linear law.
void check_constants()
{
  const Material<3> material = make_material<3>("set Type = orthotropic elastic" + constants, conducts);
  Tensor<2, 3> F = dealii::unit_symmetric_tensor<3>();
  F[0][0] += 1. / 3, F[1][1] -= 0.1, F[2][2] -= 0.2 / 3;
  F[0][1] += 0.1, F[2][1] += 0.2;
  const Tensor<2, 3> expected({{1, 0.05, 0}, {0.05, 0, 0.18}, {0, 0.18, 0}});
  report("constants", (stress(material, F, 1) - expected).norm(), 1e-15);
  report("linear", material.is_linear(0));
  const Material<3> isotropic = make_material<3>(
      "set Type = orthotropic elastic\nset Young moduli = 3, 3, 3\nset Poisson ratios = 0.25, 0.25, 0.25\n"
      "set Shear moduli = 1.2, 1.2, 1.2\nset First axis = 1; 2; z" +
          expansion,
      conducts);
  const Material<3> hooke = make_material<3>(
      "set Type = linear elastic\nset Young modulus = 3\nset Poisson ratio = 0.25" + expansion, conducts);
  report("isotropic", (stress(isotropic, F, 4) - stress(hooke, F, 4)).norm(), 1e-15);
}

} // namespace

int main()
{
  const std::string large = "set Type = orthotropic Saint Venant-Kirchhoff" + constants + axes,
                    fibres =
                        "set Type = Holzapfel-Gasser-Ogden" + moduli +
                        "\nset Fibre modulus = 0.9\nset Fibre exponent = 1.2\nset First fibre = 3; 4; 0\n"
                        "set Second fibre = 4; -3; 0\nset Volumetric = Ogden\nset Volumetric exponent = 4";
  check_energy(make_material<3>(large + expansion, conducts), Expanding<Orthotropic>());
  check_energy(make_material<3>(fibres + expansion, conducts), Expanding<Fibres>());
  for (const std::string type : {"orthotropic elastic", "orthotropic Saint Venant-Kirchhoff"}) {
    const std::string law = "set Type = " + type + constants;
    check_differences(type, make_material<2>(law + "\nset First axis = x; y" + expansion, conducts));
    check_differences(type,
                      make_material<3>(law + "\nset First axis = x; y; 2\nset Second axis = -y; x; t", ""));
  }
  check_differences("sheet", make_material<2>(large.substr(0, large.find("\nset First")), "", "",
                                              "set Geometry = plane stress\n"));
  check_differences("one family", make_material<2>("set Type = Holzapfel-Gasser-Ogden" + moduli +
                                                       "\nset Fibre modulus = 0.9\nset Fibre exponent = 1.2\n"
                                                       "set First fibre = x; 1; y",
                                                   ""));
  check_objectivity("orthotropic", large);
  check_objectivity("fibres", fibres);
  check_constants();
}
