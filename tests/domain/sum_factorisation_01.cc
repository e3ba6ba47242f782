// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Values and gradients of a polynomial at the points of cells, one polynomial for each lane, against
// formulas; integration is the transpose of evaluation.

#include <dovetail/domain/sum_factorisation.h>

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_tools.h>

#include <cmath>
#include <iostream>

using namespace dovetail;

template <int dim>
void check(const unsigned int degree)
{
  const unsigned int n_components = 2;
  const LineTable line(degree);
  const dealii::FE_Q<dim> element(degree);
  const dealii::QGauss<dim> points(degree + 1);
  const auto node = dealii::FETools::lexicographic_to_hierarchic_numbering<dim>(degree);
  const unsigned int n = points.size();
  // f = (1 + lane + c) x^p + x y + y^p of component c, with z in place of x in 3D
  const auto f = [&](const dealii::Point<dim> &x, const unsigned int c, const unsigned int lane) {
    return (1. + lane + c) * std::pow(x[dim - 1], degree) + x[0] * x[1] + std::pow(x[1], degree);
  };
  const auto slope = [&](const dealii::Point<dim> &x, const unsigned int c, const unsigned int lane,
                         const unsigned int d) {
    return (d == dim - 1 ? (1. + lane + c) * degree * std::pow(x[d], degree - 1) : 0.) +
           (d == 0 ? x[1] : 0.) + (d == 1 ? x[0] + degree * std::pow(x[1], degree - 1) : 0.);
  };
  std::vector<Lanes> coefficients(n_components * n), values(coefficients), gradients(dim * n_components * n);
  for (unsigned int c = 0; c < n_components; ++c)
    for (unsigned int a = 0; a < n; ++a)
      for (unsigned int lane = 0; lane < Lanes::size; ++lane)
        coefficients[c * n + a][lane] = f(element.get_unit_support_points()[node[a]], c, lane);
  evaluate_in_cells(dim, n_components, line, coefficients.data()->values.data(), values.data()->values.data(),
                    gradients.data()->values.data());
  double error = 0, product = 0, transposed = 0;
  std::vector<Lanes> their_values(values), their_gradients(gradients), sums(coefficients);
  for (unsigned int c = 0; c < n_components; ++c)
    for (unsigned int q = 0; q < n; ++q)
      for (unsigned int lane = 0; lane < Lanes::size; ++lane) {
        error = std::max(error, std::abs(values[c * n + q][lane] - f(points.point(q), c, lane)));
        their_values[c * n + q][lane] = std::sin(1. + 7 * q + 3 * c + lane);
        product += their_values[c * n + q][lane] * values[c * n + q][lane];
        for (unsigned int d = 0; d < dim; ++d) {
          const unsigned int k = (c * dim + d) * n + q;
          error = std::max(error, std::abs(gradients[k][lane] - slope(points.point(q), c, lane, d)));
          their_gradients[k][lane] = std::cos(1. + 5 * q + 2 * c + lane + d);
          product += their_gradients[k][lane] * gradients[k][lane];
        }
      }
  integrate_in_cells(dim, n_components, line, true, their_values.data()->values.data(),
                     their_gradients.data()->values.data(), sums.data()->values.data());
  for (unsigned int i = 0; i < sums.size(); ++i)
    for (unsigned int lane = 0; lane < Lanes::size; ++lane)
      transposed += sums[i][lane] * coefficients[i][lane];
  std::cout << dim << "D, degree " << degree << ": formulas " << (error < 1e-12 ? "ok" : "WRONG")
            << ", transpose " << (std::abs(transposed - product) < 1e-10 ? "ok" : "WRONG") << std::endl;
}

int main()
{
  for (const unsigned int degree : {1, 2, 3, 4}) {
    check<2>(degree);
    check<3>(degree);
  }
}
