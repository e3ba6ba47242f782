// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rubber that hardly changes its volume, whose free sides are found, against the closed forms of
// incompressible rubber (Treloar, The Physics of Rubber Elasticity, 1975, chapter 5): the nominal stress of
// simple tension 2 (l - l^-2) (W_1 + W_2/l), of equibiaxial tension 2 (l - l^-5) (W_1 + l^2 W_2), of pure
// shear 2 (l - l^-3) (W_1 + W_2), and simple shear 2 g (W_1 + W_2); by principal stretches for Ogden's law.
// Ogden's fit (1972) against the simple tension of Treloar (1944): at most 14 % off up to the stretch 7.4.

#include "law_check.h"

namespace {

/// W_1 and W_2 at I_1 and I_2.
struct Slopes
{
  double first, second;
};

const double kappa = 1e5, allowed = 3e-4; // moduli of shear are about 1

/// The nominal stress along x where the sides are free. @param along of y, 0: free
double nominal_stress(const Material<3> &material, const double stretch, const double along)
{
  double low = 0.05, high = 3;
  Tensor<2, 3> P;
  for (unsigned int i = 0; i < 200; ++i) {
    const double side = (low + high) / 2;
    P = stress(material, Tensor<2, 3>({{stretch, 0, 0}, {0, along > 0 ? along : side, 0}, {0, 0, side}}), 1);
    (P[2][2] > 0 ? high : low) = side;
  }
  return P[0][0];
}

/// @param slopes of W at I_1, I_2
void check(const std::string &name, const std::string &law,
           const std::function<Slopes(double, double)> &slopes)
{
  const Material<3> material = make_material<3>("set Type = " + law, conducts);
  double error = 0;
  for (const double l : {0.6, 0.9, 1.3, 2., 3.}) {
    const auto compare = [&](const double stress, const double exact) {
      error = std::max(error, std::abs(stress / exact - 1));
    };
    const Slopes tension = slopes(l * l + 2 / l, 2 * l + 1 / (l * l));
    compare(nominal_stress(material, l, 0), 2 * (l - 1 / (l * l)) * (tension.first + tension.second / l));
    const double l2 = l * l, l4 = l2 * l2;
    if (l < 2.5) { // the thickness
      const Slopes both = slopes(2 * l2 + 1 / l4, l4 + 2 / l2);
      compare(nominal_stress(material, l, l), 2 * (l - 1 / (l * l4)) * (both.first + l2 * both.second));
    }
    const Slopes pure = slopes(l2 + 1 + 1 / l2, l2 + 1 + 1 / l2);
    compare(nominal_stress(material, l, 1), 2 * (l - 1 / (l * l2)) * (pure.first + pure.second));
    Tensor<2, 3> F = dealii::unit_symmetric_tensor<3>();
    F[0][1] = l;
    const Slopes shear = slopes(3 + l2, 3 + l2);
    compare(stress(material, F, 1)[0][1], 2 * l * (shear.first + shear.second));
  }
  report(name, error, allowed);
}

void check_treloar()
{
  const Material<3> material = make_material<3>("set Type = Ogden\nset Moduli = 0.63, 0.0012, -0.01\n"
                                                "set Exponents = 1.3, 5, -2\nset Bulk modulus = 1e5",
                                                conducts);
  const std::vector<std::pair<double, double>> measured = {
      {1.125, 0.137}, {1.24, 0.23}, {1.39, 0.32}, {1.61, 0.41}, {1.89, 0.50}, {2.17, 0.58},
      {2.42, 0.67},   {3.01, 0.85}, {3.58, 1.04}, {4.03, 1.21}, {4.76, 1.58}, {5.36, 1.94},
      {5.76, 2.29},   {6.16, 2.67}, {6.4, 3.02},  {6.62, 3.39}, {6.87, 3.75}, {7.05, 4.12},
      {7.16, 4.47},   {7.27, 4.85}, {7.4, 5.21}}; // stretch, MPa
  double largest = 0, formula_error = 0;
  for (const auto &[l, value] : measured) {
    double exact = 0;
    for (const auto &[mu, alpha] :
         std::vector<std::pair<double, double>>{{0.63, 1.3}, {0.0012, 5}, {-0.01, -2}})
      exact += mu * (std::pow(l, alpha - 1) - std::pow(l, -alpha / 2 - 1));
    const double stress = nominal_stress(material, l, 0);
    formula_error = std::max(formula_error, std::abs(stress / exact - 1));
    largest = std::max(largest, std::abs(stress / value - 1));
  }
  report("Ogden's formula", formula_error, allowed);
  report("Treloar's rubber", largest, 0.14);
}

} // namespace

int main()
{
  const std::string bulk = "\nset Bulk modulus = 1e5", modulus = "\nset Shear modulus = 0.9" + bulk;
  check("neo-Hookean", "neo-Hookean" + modulus, [](double, double) { return Slopes{0.45, 0}; });
  check("Mooney-Rivlin", "Mooney-Rivlin\nset C10 = 0.4\nset C01 = 0.1" + bulk, [](double, double) {
    return Slopes{0.4, 0.1};
  });
  check("Yeoh", "Yeoh\nset C10 = 0.5\nset C20 = -0.01\nset C30 = 0.002" + bulk, [](const double I, double) {
    return Slopes{0.5 - 0.02 * (I - 3) + 0.006 * (I - 3) * (I - 3), 0};
  });
  check("Gent", "Gent\nset Limit = 40" + modulus, [](const double I, double) {
    return Slopes{0.45 * 40 / (43 - I), 0};
  });
  check("energy",
        "energy\nset Energy = 0.4*(I1_bar - 3) + 0.01*(I2_bar - 3)^2 + 0.05*(I2_bar - 3) + 5e4*(J - 1)^2",
        [](double, const double I) {
          return Slopes{0.4, 0.05 + 0.02 * (I - 3)};
        });
  check("Ogden", "Ogden\nset Moduli = 0.8, -0.2\nset Exponents = 2, -2" + bulk, [](double, double) {
    return Slopes{0.4, 0.1};
  });
  check_treloar();
}
