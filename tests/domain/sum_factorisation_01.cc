// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Values and gradients of a polynomial at the points of cells, one polynomial for each lane, against
// formulas; integration is the transpose of evaluation. Small matrices at the points, with J and without,
// against sums. In single precision all agree with double precision.

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
  const LineTable<double> line(degree);
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
  const auto numbers = [](std::vector<Lanes> &c, std::vector<Lanes> &v, std::vector<Lanes> &g) {
    return CellNumbers<double>{dim, n_components, c.data()->values.data(), v.data()->values.data(),
                               g.data()->values.data()};
  };
  evaluate_in_cells(line, numbers(coefficients, values, gradients));
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
  integrate_in_cells(line, true, numbers(sums, their_values, their_gradients));
  for (unsigned int i = 0; i < sums.size(); ++i)
    for (unsigned int lane = 0; lane < Lanes::size; ++lane)
      transposed += sums[i][lane] * coefficients[i][lane];
  std::cout << dim << "D, degree " << degree << ": formulas " << (error < 1e-12 ? "ok" : "WRONG")
            << ", transpose " << (std::abs(transposed - product) < 1e-10 ? "ok" : "WRONG") << std::endl;
}

double noise(const unsigned int seed)
{
  return std::sin(1e3 * (1. + seed));
}

/// x by a small matrix at each point, and what it should be.
template <int dim, typename Number>
double error_of_matrices(const bool are_equal, const bool has_J)
{
  const unsigned int n_slopes = 2 * dim, n_rows = n_slopes + 2, n_points = 7; // not a multiple of four
  PointSums sums;
  sums.factor = 0.5;
  for (unsigned int row = 0; row < n_rows; ++row) {
    for (unsigned int column = row % 2; column < n_rows; ++column)
      sums.terms.push_back({column, (row * n_rows + column) % 11});
    sums.add_row();
  }
  std::vector<Lanes> entries(11 * (are_equal ? 1 : n_points)), J((dim * dim + 1) * n_points);
  std::vector<double> weights;
  std::vector<LanesOf<Number>> x(n_rows * n_points);
  for (unsigned int q = 0; q < n_points; ++q)
    weights.push_back(1. + q);
  for (unsigned int lane = 0; lane < Lanes::size; ++lane) {
    for (unsigned int i = 0; i < entries.size(); ++i)
      entries[i][lane] = noise(3 * i + lane);
    for (unsigned int i = 0; i < J.size(); ++i)
      J[i][lane] = noise(5 * i + lane);
    for (unsigned int i = 0; i < x.size(); ++i)
      x[i][lane] = static_cast<Number>(noise(7 * i + lane));
  }
  const std::vector<LanesOf<Number>> given(x);
  multiply_at_points({sums, n_points, entries.data(), are_equal, has_J ? nullptr : weights.data(),
                      has_J ? J.data() : nullptr},
                     dim, n_slopes, x.data()->values.data());
  double error = 0;
  for (unsigned int lane = 0; lane < Lanes::size; ++lane)
    for (unsigned int q = 0; q < n_points; ++q) {
      // slopes of the unit cell by those in space: the matrix is transformed from both sides
      const auto factor = [&](const unsigned int in_space, const unsigned int in_unit_cell) {
        if (in_space >= n_slopes || in_unit_cell >= n_slopes || !has_J)
          return in_space == in_unit_cell ? 1. : 0.;
        return in_space / dim == in_unit_cell / dim
                   ? J[(in_space % dim * dim + in_unit_cell % dim) * n_points + q][lane]
                   : 0.;
      };
      std::vector<double> of_space(n_rows), response(n_rows), result(n_rows);
      for (unsigned int i = 0; i < n_rows; ++i)
        for (unsigned int j = 0; j < n_rows; ++j)
          of_space[i] += factor(i, j) * static_cast<double>(given[j * n_points + q][lane]);
      for (unsigned int row = 0; row < n_rows; ++row)
        for (unsigned int t = sums.begin_of_row[row]; t < sums.begin_of_row[row + 1]; ++t)
          response[row] +=
              0.5 * (has_J ? J[dim * dim * n_points + q][lane] : weights[q]) * of_space[sums.terms[t].from] *
              entries[are_equal ? sums.terms[t].entry : sums.terms[t].entry * n_points + q][lane];
      for (unsigned int i = 0; i < n_rows; ++i) {
        for (unsigned int j = 0; j < n_rows; ++j)
          result[i] += factor(j, i) * response[j];
        error = std::max(error, std::abs(result[i] - static_cast<double>(x[i * n_points + q][lane])));
      }
    }
  return error;
}

template <int dim>
void check_matrices()
{
  for (const bool are_equal : {false, true})
    for (const bool has_J : {false, true}) {
      const double error = error_of_matrices<dim, double>(are_equal, has_J),
                   rough = error_of_matrices<dim, float>(are_equal, has_J);
      std::cout << dim << "D, " << (are_equal ? "one matrix" : "matrices of points") << (has_J ? ", J" : "")
                << ": " << (error < 1e-12 ? "ok" : "WRONG") << ", single precision "
                << (rough < 1e-4 ? "ok" : "WRONG") << std::endl;
    }
}

/// Single precision against double precision, of what a product of a cell does.
template <int dim>
void check_single_precision(const unsigned int degree)
{
  std::size_t n_points = 1;
  for (unsigned int d = 0; d < dim; ++d)
    n_points *= degree + 1;
  std::vector<Lanes> c(n_points), v(n_points), g(dim * n_points);
  std::vector<LanesOf<float>> c_rough(n_points), v_rough(n_points), g_rough(dim * n_points);
  for (unsigned int i = 0; i < n_points; ++i)
    for (unsigned int lane = 0; lane < Lanes::size; ++lane)
      c[i][lane] = c_rough[i][lane] = static_cast<float>(noise(i + 3 * lane));
  const CellNumbers<double> numbers = {dim, 1, c[0].values.data(), v[0].values.data(), g[0].values.data()};
  const CellNumbers<float> rough_numbers = {dim, 1, c_rough[0].values.data(), v_rough[0].values.data(),
                                            g_rough[0].values.data()};
  evaluate_in_cells(LineTable<double>(degree), numbers);
  evaluate_in_cells(LineTable<float>(degree), rough_numbers);
  integrate_in_cells(LineTable<double>(degree), true, numbers);
  integrate_in_cells(LineTable<float>(degree), true, rough_numbers);
  double error = 0, largest = 0;
  for (unsigned int i = 0; i < n_points; ++i)
    for (unsigned int lane = 0; lane < Lanes::size; ++lane) {
      error = std::max(error, std::abs(c[i][lane] - static_cast<double>(c_rough[i][lane])));
      largest = std::max(largest, std::abs(c[i][lane]));
    }
  std::cout << dim << "D, degree " << degree << ": single precision "
            << (error < 1e-5 * largest ? "ok" : "WRONG") << std::endl;
}

int main()
{
  for (const unsigned int degree : {1, 2, 3, 4}) {
    check<2>(degree);
    check<3>(degree);
  }
  for (const unsigned int degree : {1, 2, 3, 4}) {
    check_single_precision<2>(degree);
    check_single_precision<3>(degree);
  }
  check_matrices<2>();
  check_matrices<3>();
}
