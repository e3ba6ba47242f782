// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/sum_factorisation.h>

#include <dovetail/widest_vectors.h>

#include <deal.II/base/exceptions.h>
#include <deal.II/base/polynomial.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_tools.h>

namespace dovetail {

LineTable::LineTable(const unsigned int degree) : n(degree + 1)
{
  AssertThrow(n >= 2 && n <= 5, dealii::ExcMessage("The loops are compiled for degrees from 1 to 4."));
  const dealii::QGauss<1> points(n);
  const dealii::FE_Q<1> element(degree);
  const auto node = dealii::FETools::lexicographic_to_hierarchic_numbering<1>(degree);
  const auto polynomials = dealii::Polynomials::generate_complete_Lagrange_basis(points.get_points());
  for (unsigned int q = 0; q < n; ++q)
    for (unsigned int i = 0; i < n; ++i) {
      std::vector<double> value_and_slope(2);
      polynomials[i].value(points.point(q)[0], value_and_slope);
      values.push_back(element.shape_value(node[i], points.point(q)));
      slopes.push_back(value_and_slope[1]);
    }
  for (unsigned int i = 0; i < n; ++i)
    for (unsigned int q = 0; q < n; ++q) {
      transposed_values.push_back(values[q * n + i]);
      transposed_slopes.push_back(slopes[q * n + i]);
    }
}

namespace {

constexpr std::size_t L = Lanes::size;

/// Half of the lanes, in a register of most processors: arrays, which the compiler unrolls and puts together
/// again, it leaves apart in some of the loops below.
typedef double Half __attribute__((vector_size(32), aligned(8), may_alias));
constexpr std::size_t width = sizeof(Half) / sizeof(double);

/// Along lines of n numbers that are @p stride apart: out = m in, or added to it.
template <std::size_t n, bool adds>
DOVETAIL_PART_OF_CALLER void sweep(const double *const m, const std::size_t stride, const std::size_t n_outer,
                                   const double *const __restrict__ in, double *const __restrict__ out)
{
  for (std::size_t o = 0; o < n_outer; ++o)
    for (std::size_t k = 0; k < stride; k += width) {
      const double *const __restrict__ from = in + o * n * stride + k;
      double *const __restrict__ to = out + o * n * stride + k;
      Half x[n];
      for (std::size_t i = 0; i < n; ++i)
        x[i] = *reinterpret_cast<const Half *>(from + i * stride);
      for (std::size_t q = 0; q < n; ++q) {
        Half &y = *reinterpret_cast<Half *>(to + q * stride);
        Half s = m[q * n] * x[0];
        for (std::size_t i = 1; i < n; ++i)
          s += m[q * n + i] * x[i];
        y = adds ? y + s : s;
      }
    }
}

template <std::size_t n>
DOVETAIL_PART_OF_CALLER void evaluate(const unsigned int dim, const unsigned int n_components,
                                      const double *const line_values, const double *const line_slopes,
                                      const double *const coefficients, double *const values,
                                      double *const gradients)
{
  const std::size_t face = dim == 2 ? n : n * n, size = n * face * L;
  for (std::size_t c = 0; c < n_components; ++c) {
    double *const v = values + c * size, *const g = gradients + c * dim * size;
    sweep<n, false>(line_values, L, face, coefficients + c * size, g);
    if (dim == 2)
      sweep<n, false>(line_values, n * L, 1, g, v);
    else {
      sweep<n, false>(line_values, n * L, n, g, g + size);
      sweep<n, false>(line_values, n * n * L, 1, g + size, v);
    }
    sweep<n, false>(line_slopes, L, face, v, g);
    sweep<n, false>(line_slopes, n * L, face / n, v, g + size);
    if (dim == 3)
      sweep<n, false>(line_slopes, n * n * L, 1, v, g + 2 * size);
  }
}

template <std::size_t n>
DOVETAIL_PART_OF_CALLER void integrate(const unsigned int dim, const unsigned int n_components,
                                       const double *const line_values, const double *const line_slopes,
                                       const bool has_values, double *const values, double *const gradients,
                                       double *const coefficients)
{
  const std::size_t face = dim == 2 ? n : n * n, size = n * face * L;
  for (std::size_t c = 0; c < n_components; ++c) {
    double *const v = values + c * size, *const g = gradients + c * dim * size;
    if (has_values)
      sweep<n, true>(line_slopes, L, face, g, v);
    else
      sweep<n, false>(line_slopes, L, face, g, v);
    sweep<n, true>(line_slopes, n * L, face / n, g + size, v);
    if (dim == 2)
      sweep<n, false>(line_values, n * L, 1, v, g);
    else {
      sweep<n, true>(line_slopes, n * n * L, 1, g + 2 * size, v);
      sweep<n, false>(line_values, n * n * L, 1, v, g + size);
      sweep<n, false>(line_values, n * L, n, g + size, g);
    }
    sweep<n, false>(line_values, L, face, g, coefficients + c * size);
  }
}

DOVETAIL_WIDEST_VECTORS void evaluate_any(const unsigned int dim, const unsigned int n_components,
                                          const std::size_t n, const double *const line_values,
                                          const double *const line_slopes, const double *const coefficients,
                                          double *const values, double *const gradients)
{
  if (n == 2)
    evaluate<2>(dim, n_components, line_values, line_slopes, coefficients, values, gradients);
  else if (n == 3)
    evaluate<3>(dim, n_components, line_values, line_slopes, coefficients, values, gradients);
  else if (n == 4)
    evaluate<4>(dim, n_components, line_values, line_slopes, coefficients, values, gradients);
  else
    evaluate<5>(dim, n_components, line_values, line_slopes, coefficients, values, gradients);
}

DOVETAIL_WIDEST_VECTORS void integrate_any(const unsigned int dim, const unsigned int n_components,
                                           const std::size_t n, const double *const line_values,
                                           const double *const line_slopes, const bool has_values,
                                           double *const values, double *const gradients,
                                           double *const coefficients)
{
  if (n == 2)
    integrate<2>(dim, n_components, line_values, line_slopes, has_values, values, gradients, coefficients);
  else if (n == 3)
    integrate<3>(dim, n_components, line_values, line_slopes, has_values, values, gradients, coefficients);
  else if (n == 4)
    integrate<4>(dim, n_components, line_values, line_slopes, has_values, values, gradients, coefficients);
  else
    integrate<5>(dim, n_components, line_values, line_slopes, has_values, values, gradients, coefficients);
}

DOVETAIL_WIDEST_VECTORS void sum_at_points(const PointSums::Term *const begin,
                                           const PointSums::Term *const end, const std::size_t n_points,
                                           const double *const A, const double *const x, double *const y)
{
  for (std::size_t q = 0; q < n_points; ++q) {
    double s[L] = {};
    for (const PointSums::Term *term = begin; term < end; ++term) {
      const double *const __restrict__ a = A + (term->entry * n_points + q) * L;
      const double *const __restrict__ from = x + (term->from * n_points + q) * L;
      const double factor = term->factor;
      for (std::size_t l = 0; l < L; ++l)
        s[l] += factor * a[l] * from[l];
    }
    double *const __restrict__ to = y + q * L;
    for (std::size_t l = 0; l < L; ++l)
      to[l] = s[l];
  }
}

DOVETAIL_WIDEST_VECTORS void sum_with_weights(const PointSums::Term *const begin,
                                              const PointSums::Term *const end, const std::size_t n_points,
                                              const double *const weights, const double *const A,
                                              const double *const x, double *const y)
{
  for (std::size_t q = 0; q < n_points; ++q) {
    double s[L] = {};
    for (const PointSums::Term *term = begin; term < end; ++term) {
      const double *const __restrict__ a = A + term->entry * L;
      const double *const __restrict__ from = x + (term->from * n_points + q) * L;
      const double factor = term->factor;
      for (std::size_t l = 0; l < L; ++l)
        s[l] += factor * a[l] * from[l];
    }
    double *const __restrict__ to = y + q * L;
    const double weight = weights[q];
    for (std::size_t l = 0; l < L; ++l)
      to[l] = weight * s[l];
  }
}

} // namespace

void evaluate_in_cells(const unsigned int dim, const unsigned int n_components, const LineTable &line,
                       const double *const coefficients, double *const values, double *const gradients)
{
  evaluate_any(dim, n_components, line.n, line.values.data(), line.slopes.data(), coefficients, values,
               gradients);
}

void integrate_in_cells(const unsigned int dim, const unsigned int n_components, const LineTable &line,
                        const bool has_values, double *const values, double *const gradients,
                        double *const coefficients)
{
  integrate_any(dim, n_components, line.n, line.transposed_values.data(), line.transposed_slopes.data(),
                has_values, values, gradients, coefficients);
}

void multiply_at_points(const PointSums &sums, const std::size_t n_points, const double *const A,
                        const double *const x, double *const y)
{
  for (unsigned int row = 0; row < sums.n_rows(); ++row)
    sum_at_points(sums.terms.data() + sums.begin_of_row[row], sums.terms.data() + sums.begin_of_row[row + 1],
                  n_points, A, x, y + row * n_points * L);
}

void multiply_at_points(const PointSums &sums, const std::vector<double> &weights, const double *const A,
                        const double *const x, double *const y)
{
  for (unsigned int row = 0; row < sums.n_rows(); ++row)
    sum_with_weights(sums.terms.data() + sums.begin_of_row[row],
                     sums.terms.data() + sums.begin_of_row[row + 1], weights.size(), weights.data(), A, x,
                     y + row * weights.size() * L);
}

} // namespace dovetail
