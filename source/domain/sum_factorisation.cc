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

template <typename Number>
LineTable<Number>::LineTable(const unsigned int degree) : n(degree + 1)
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
      values.push_back(static_cast<Number>(element.shape_value(node[i], points.point(q))));
      slopes.push_back(static_cast<Number>(value_and_slope[1]));
    }
  for (unsigned int i = 0; i < n; ++i)
    for (unsigned int q = 0; q < n; ++q) {
      transposed_values.push_back(values[q * n + i]);
      transposed_slopes.push_back(slopes[q * n + i]);
    }
}

template struct LineTable<double>;
template struct LineTable<float>;

namespace {

constexpr std::size_t L = Lanes::size;

template <typename Number>
using Part = typename WideRegister<Number>::Part;
template <typename Number>
constexpr std::size_t width = sizeof(Part<Number>) / sizeof(Number);

/// Along lines of n numbers that are @p stride apart: out = m in, or added to it.
template <std::size_t n, bool adds, typename Number>
DOVETAIL_PART_OF_CALLER void sweep(const Number *const m, const std::size_t stride, const std::size_t n_outer,
                                   const Number *const __restrict__ in, Number *const __restrict__ out)
{
  for (std::size_t o = 0; o < n_outer; ++o)
    for (std::size_t k = 0; k < stride; k += width<Number>) {
      const Number *const __restrict__ from = in + o * n * stride + k;
      Number *const __restrict__ to = out + o * n * stride + k;
      Part<Number> x[n];
      for (std::size_t i = 0; i < n; ++i)
        x[i] = *reinterpret_cast<const Part<Number> *>(from + i * stride);
      for (std::size_t q = 0; q < n; ++q) {
        Part<Number> &y = *reinterpret_cast<Part<Number> *>(to + q * stride);
        Part<Number> s = m[q * n] * x[0];
        for (std::size_t i = 1; i < n; ++i)
          s += m[q * n + i] * x[i];
        y = adds ? y + s : s;
      }
    }
}

template <std::size_t n, typename Number>
DOVETAIL_PART_OF_CALLER void evaluate(const LineTable<Number> &line, const CellNumbers<Number> &numbers)
{
  const unsigned int dim = numbers.dim;
  const Number *const values = line.values.data(), *const slopes = line.slopes.data();
  const std::size_t face = dim == 2 ? n : n * n, size = n * face * L;
  for (std::size_t c = 0; c < numbers.n_components; ++c) {
    Number *const v = numbers.values + c * size, *const g = numbers.gradients + c * dim * size;
    sweep<n, false>(values, L, face, numbers.coefficients + c * size, g);
    if (dim == 2)
      sweep<n, false>(values, n * L, 1, g, v);
    else {
      sweep<n, false>(values, n * L, n, g, g + size);
      sweep<n, false>(values, n * n * L, 1, g + size, v);
    }
    sweep<n, false>(slopes, L, face, v, g);
    sweep<n, false>(slopes, n * L, face / n, v, g + size);
    if (dim == 3)
      sweep<n, false>(slopes, n * n * L, 1, v, g + 2 * size);
  }
}

template <std::size_t n, typename Number>
DOVETAIL_PART_OF_CALLER void integrate(const LineTable<Number> &line, const bool has_values,
                                       const CellNumbers<Number> &numbers)
{
  const unsigned int dim = numbers.dim;
  const Number *const values = line.transposed_values.data(), *const slopes = line.transposed_slopes.data();
  const std::size_t face = dim == 2 ? n : n * n, size = n * face * L;
  for (std::size_t c = 0; c < numbers.n_components; ++c) {
    Number *const v = numbers.values + c * size, *const g = numbers.gradients + c * dim * size;
    if (has_values)
      sweep<n, true>(slopes, L, face, g, v);
    else
      sweep<n, false>(slopes, L, face, g, v);
    sweep<n, true>(slopes, n * L, face / n, g + size, v);
    if (dim == 2)
      sweep<n, false>(values, n * L, 1, v, g);
    else {
      sweep<n, true>(slopes, n * n * L, 1, g + 2 * size, v);
      sweep<n, false>(values, n * n * L, 1, v, g + size);
      sweep<n, false>(values, n * L, n, g + size, g);
    }
    sweep<n, false>(values, L, face, g, numbers.coefficients + c * size);
  }
}

template <typename Number>
DOVETAIL_PART_OF_CALLER void evaluate_any(const LineTable<Number> &line, const CellNumbers<Number> &numbers)
{
  if (line.n == 2)
    evaluate<2>(line, numbers);
  else if (line.n == 3)
    evaluate<3>(line, numbers);
  else if (line.n == 4)
    evaluate<4>(line, numbers);
  else
    evaluate<5>(line, numbers);
}

template <typename Number>
DOVETAIL_PART_OF_CALLER void integrate_any(const LineTable<Number> &line, const bool has_values,
                                           const CellNumbers<Number> &numbers)
{
  if (line.n == 2)
    integrate<2>(line, has_values, numbers);
  else if (line.n == 3)
    integrate<3>(line, has_values, numbers);
  else if (line.n == 4)
    integrate<4>(line, has_values, numbers);
  else
    integrate<5>(line, has_values, numbers);
}

DOVETAIL_PART_OF_CALLER void load(const double *const lanes, Part<double> &result)
{
  result = *reinterpret_cast<const Part<double> *>(lanes);
}

DOVETAIL_PART_OF_CALLER void load(const double *const lanes, Part<float> &result)
{
  typedef double All __attribute__((vector_size(64), aligned(8), may_alias));
  result = __builtin_convertvector(*reinterpret_cast<const All *>(lanes), Part<float>);
}

/// Some parts that follow each other: numbers of one or several points.
template <typename Number, unsigned int n>
struct Parts
{
  Part<Number> all[n];

  DOVETAIL_PART_OF_CALLER void load_from(const double *const lanes)
  {
    for (unsigned int i = 0; i < n; ++i)
      load(lanes + i * width<Number>, all[i]);
  }
};

/// x = x J by component, J by row with entries @p stride apart; or x J^T.
template <unsigned int dim, bool transposed, typename Number, unsigned int n>
DOVETAIL_PART_OF_CALLER void transform(const double *const J, const std::size_t stride,
                                       const unsigned int n_slopes, Parts<Number, n> *const x)
{
  for (unsigned int i = 0; i < n; ++i) {
    Part<Number> entries[dim * dim];
    for (unsigned int e = 0; e < dim * dim; ++e)
      load(J + e * stride + i * width<Number>, entries[e]);
    for (unsigned int c = 0; c < n_slopes; c += dim) {
      Part<Number> sums[dim];
      for (unsigned int j = 0; j < dim; ++j) {
        sums[j] = x[c].all[i] * entries[transposed ? j : j * dim];
        for (unsigned int l = 1; l < dim; ++l)
          sums[j] += x[c + l].all[i] * entries[transposed ? l * dim + j : j * dim + l];
      }
      for (unsigned int j = 0; j < dim; ++j)
        x[c + j].all[i] = sums[j];
    }
  }
}

/// Of n parts, from number @p first of all lanes of all points on.
template <unsigned int dim, unsigned int n, typename Number>
DOVETAIL_PART_OF_CALLER void multiply_parts(const PointMatrices &matrices, const unsigned int n_slopes,
                                            const std::size_t first, Number *const numbers)
{
  const unsigned int most_rows = 12, n_rows = matrices.sums.n_rows();
  const std::size_t stride = matrices.n_points * L;
  const double *const J = matrices.J == nullptr ? nullptr : matrices.J->values.data() + first;
  Parts<Number, n> x[most_rows], y[most_rows], factor;
  for (unsigned int row = 0; row < n_rows; ++row)
    for (unsigned int i = 0; i < n; ++i)
      x[row].all[i] =
          *reinterpret_cast<const Part<Number> *>(numbers + row * stride + first + i * width<Number>);
  if (J != nullptr) {
    transform<dim, false>(J, stride, n_slopes, x);
    factor.load_from(J + dim * dim * stride);
  } else
    for (unsigned int i = 0; i < n; ++i) {
      const std::size_t q = (first + i * width<Number>) / L;
      factor.all[i] =
          Part<Number>{} + static_cast<Number>(matrices.weights == nullptr ? 1. : matrices.weights[q]);
    }
  const PointSums::Term *term = matrices.sums.terms.data();
  for (unsigned int row = 0; row < n_rows; ++row) {
    Parts<Number, n> sum{};
    for (const auto *const end = matrices.sums.terms.data() + matrices.sums.begin_of_row[row + 1]; term < end;
         ++term) {
      const Parts<Number, n> &from = x[term->from];
      Parts<Number, n> entry;
      if (!matrices.are_equal)
        entry.load_from(matrices.entries->values.data() + term->entry * stride + first);
      else
        for (unsigned int i = 0; i < n; ++i)
          load(matrices.entries[term->entry].values.data() + (first + i * width<Number>) % L, entry.all[i]);
      for (unsigned int i = 0; i < n; ++i)
        sum.all[i] += entry.all[i] * from.all[i];
    }
    for (unsigned int i = 0; i < n; ++i)
      y[row].all[i] = static_cast<Number>(matrices.sums.factor) * factor.all[i] * sum.all[i];
  }
  if (J != nullptr)
    transform<dim, true>(J, stride, n_slopes, y);
  for (unsigned int row = 0; row < n_rows; ++row)
    for (unsigned int i = 0; i < n; ++i)
      *reinterpret_cast<Part<Number> *>(numbers + row * stride + first + i * width<Number>) = y[row].all[i];
}

/// Several parts at a time, because each term costs its look-up.
template <unsigned int dim, typename Number>
DOVETAIL_PART_OF_CALLER void multiply_points(const PointMatrices &matrices, const unsigned int n_slopes,
                                             Number *const numbers)
{
  constexpr unsigned int n = 4;
  const std::size_t end = matrices.n_points * L;
  std::size_t first = 0;
  for (; first + n * width<Number> <= end; first += n * width<Number>)
    multiply_parts<dim, n>(matrices, n_slopes, first, numbers);
  for (; first < end; first += width<Number>)
    multiply_parts<dim, 1>(matrices, n_slopes, first, numbers);
}

template <typename Number>
DOVETAIL_PART_OF_CALLER void multiply_any(const PointMatrices &matrices, const unsigned int dim,
                                          const unsigned int n_slopes, Number *const x)
{
  if (dim == 2)
    multiply_points<2>(matrices, n_slopes, x);
  else
    multiply_points<3>(matrices, n_slopes, x);
}

// not templates, of which clang makes no versions

DOVETAIL_WIDEST_VECTORS void run_evaluate(const LineTable<double> &line, const CellNumbers<double> &numbers)
{
  evaluate_any(line, numbers);
}

DOVETAIL_WIDEST_VECTORS void run_evaluate(const LineTable<float> &line, const CellNumbers<float> &numbers)
{
  evaluate_any(line, numbers);
}

DOVETAIL_WIDEST_VECTORS void run_integrate(const LineTable<double> &line, const bool has_values,
                                           const CellNumbers<double> &numbers)
{
  integrate_any(line, has_values, numbers);
}

DOVETAIL_WIDEST_VECTORS void run_integrate(const LineTable<float> &line, const bool has_values,
                                           const CellNumbers<float> &numbers)
{
  integrate_any(line, has_values, numbers);
}

DOVETAIL_WIDEST_VECTORS void run_multiply(const PointMatrices &matrices, const unsigned int dim,
                                          const unsigned int n_slopes, double *const x)
{
  multiply_any(matrices, dim, n_slopes, x);
}

DOVETAIL_WIDEST_VECTORS void run_multiply(const PointMatrices &matrices, const unsigned int dim,
                                          const unsigned int n_slopes, float *const x)
{
  multiply_any(matrices, dim, n_slopes, x);
}

} // namespace

template <typename Number>
void evaluate_in_cells(const LineTable<Number> &line, const CellNumbers<Number> &numbers)
{
  run_evaluate(line, numbers);
}

template <typename Number>
void integrate_in_cells(const LineTable<Number> &line, const bool has_values,
                        const CellNumbers<Number> &numbers)
{
  run_integrate(line, has_values, numbers);
}

template <typename Number>
void multiply_at_points(const PointMatrices &matrices, const unsigned int dim, const unsigned int n_slopes,
                        Number *const x)
{
  run_multiply(matrices, dim, n_slopes, x);
}

template void evaluate_in_cells(const LineTable<double> &, const CellNumbers<double> &);
template void evaluate_in_cells(const LineTable<float> &, const CellNumbers<float> &);
template void integrate_in_cells(const LineTable<double> &, bool, const CellNumbers<double> &);
template void integrate_in_cells(const LineTable<float> &, bool, const CellNumbers<float> &);
template void multiply_at_points(const PointMatrices &, unsigned int, unsigned int, double *);
template void multiply_at_points(const PointMatrices &, unsigned int, unsigned int, float *);

} // namespace dovetail
