// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/point_products.h>

#include <algorithm>
#include <cmath>

// One version for each level of the instruction set, of which the loader takes one. Not for the name of a
// processor (arch=haswell), which is of one maker: those of others would get the version without wide
// vectors. Levels are chosen rightly since gcc 12 and clang 18: gcc 11 refuses them, and clang 14 takes the
// default on every processor. A sanitizer cannot look into the choice, which is made before it has started.
#if !defined(__x86_64__) || !defined(__linux__) || defined(__SANITIZE_ADDRESS__)
#define DOVETAIL_WIDEST_VECTORS
#elif defined(__clang__) ? __clang_major__ < 18 : __GNUC__ < 12
#define DOVETAIL_WIDEST_VECTORS __attribute__((target_clones("avx512f", "fma", "default")))
#else
#define DOVETAIL_WIDEST_VECTORS __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#endif

namespace dovetail {

namespace {

// Of functions that no header declares: of others clang 14 makes the first version alone, for all processors.

DOVETAIL_WIDEST_VECTORS void add_terms_at_points(const std::vector<PointTerm> &terms, const std::size_t n,
                                                 const double *const A, const double *const x,
                                                 double *const y)
{
  for (const PointTerm &term : terms) {
    const double *const __restrict__ a = A + term.entry * n;
    const double *const __restrict__ from = x + term.from * n;
    double *const __restrict__ to = y + term.to * n;
    for (std::size_t i = 0; i < n; ++i)
      to[i] += term.factor * a[i] * from[i];
  }
}

DOVETAIL_WIDEST_VECTORS void add_up_sizes_of_rows(const std::size_t n, const double *A, const double *const x,
                                                  double *const sums)
{
  constexpr unsigned int width = 8;
  for (std::size_t i = 0; i < n; ++i, A += n) {
    double s[width] = {};
    std::size_t j = 0;
    for (; j + width <= n; j += width)
      for (unsigned int k = 0; k < width; ++k)
        s[k] += std::abs(A[j + k] * x[j + k]);
    for (; j < n; ++j)
      s[0] += std::abs(A[j] * x[j]);
    for (unsigned int k = 1; k < width; ++k)
      s[0] += s[k];
    sums[i] = s[0];
  }
}

} // namespace

void add_at_points(const std::vector<PointTerm> &terms, const std::size_t n, const double *const A,
                   const double *const x, double *const y)
{
  add_terms_at_points(terms, n, A, x, y);
}

void add_up_sizes(const std::size_t n, const double *const A, const double *const x, double *const sums)
{
  add_up_sizes_of_rows(n, A, x, sums);
}

void ShapeTable::reinit(const unsigned int points, const unsigned int directions,
                        const unsigned int functions)
{
  if (n_points == points && n_directions == directions && n_functions == functions)
    return; // what fills up the rows is zero still
  n_points = points;
  n_directions = directions;
  n_functions = functions;
  stride = (functions + block - 1) / block * block;
  values.assign(std::size_t(n_points) * n_directions * stride, 0.);
}

namespace {

/// y = sum_I D_IJ phi_I for all directions J of the columns, at every point. A block of functions stays in
/// the registers.
DOVETAIL_WIDEST_VECTORS void multiply_rows(const std::size_t n_points, const std::size_t n_rows,
                                           const std::size_t n_columns, const std::size_t n, const double *D,
                                           const double *phi, double *y)
{
  constexpr unsigned int block = ShapeTable::block;
  for (std::size_t q = 0; q < n_points; ++q, phi += n_rows * n, D += n_rows * n_columns)
    for (std::size_t J = 0; J < n_columns; ++J, y += n)
      for (std::size_t a = 0; a < n; a += block) {
        double s[block] = {};
        for (std::size_t I = 0; I < n_rows; ++I) {
          const double factor = D[I * n_columns + J];
          const double *const __restrict__ from = phi + I * n + a;
          for (unsigned int b = 0; b < block; ++b)
            s[b] += factor * from[b];
        }
        double *const __restrict__ to = y + a;
        for (unsigned int b = 0; b < block; ++b)
          to[b] = s[b];
      }
}

constexpr unsigned int n_rows_of_block = 4;

/// sum_k x_k[a] y_k[b] of a block of a and b, where x_k and y_k begin so far apart.
DOVETAIL_WIDEST_VECTORS void sum_block(const std::size_t n, const double *const __restrict__ x,
                                       const std::size_t stride_of_x, const double *const __restrict__ y,
                                       const std::size_t stride_of_y,
                                       double (&__restrict__ sums)[n_rows_of_block][ShapeTable::block])
{
  double s[n_rows_of_block][ShapeTable::block] = {};
  for (std::size_t k = 0; k < n; ++k)
    for (unsigned int a = 0; a < n_rows_of_block; ++a)
      for (unsigned int b = 0; b < ShapeTable::block; ++b)
        s[a][b] += x[k * stride_of_x + a] * y[k * stride_of_y + b];
  for (unsigned int a = 0; a < n_rows_of_block; ++a)
    for (unsigned int b = 0; b < ShapeTable::block; ++b)
      sums[a][b] = s[a][b];
}

} // namespace

void add_cell_matrix(const ShapeTable &rows, const ShapeTable &columns, const std::vector<double> &D,
                     const bool is_symmetric, double *const C, const std::size_t row_length)
{
  thread_local std::vector<double> D_rows;
  const std::size_t n = std::size_t(rows.n_points) * columns.n_directions;
  D_rows.resize(n * rows.stride);
  multiply_rows(rows.n_points, rows.n_directions, columns.n_directions, rows.stride, D.data(),
                rows.values.data(), D_rows.data());
  double sums[n_rows_of_block][ShapeTable::block];
  for (unsigned int a = 0; a < rows.n_functions; a += n_rows_of_block)
    for (unsigned int b = 0; b < columns.n_functions; b += ShapeTable::block) {
      if (is_symmetric && b + ShapeTable::block <= a)
        continue;
      sum_block(n, D_rows.data() + a, rows.stride, columns.values.data() + b, columns.stride, sums);
      // what is skipped below the diagonal is the mirror image of the blocks behind that of the rows
      const bool is_mirrored = is_symmetric && b > a / ShapeTable::block * ShapeTable::block;
      const unsigned int n_a = std::min(n_rows_of_block, rows.n_functions - a),
                         n_b = std::min(ShapeTable::block, columns.n_functions - b);
      double *const block = C + a * row_length + b, *const mirror = C + b * row_length + a;
      for (unsigned int i = 0; i < n_a; ++i)
        for (unsigned int j = 0; j < n_b; ++j)
          block[i * row_length + j] += sums[i][j];
      for (unsigned int j = 0; is_mirrored && j < n_b; ++j)
        for (unsigned int i = 0; i < n_a; ++i)
          mirror[j * row_length + i] += sums[i][j];
    }
}

} // namespace dovetail
