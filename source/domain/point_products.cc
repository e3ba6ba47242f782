// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/point_products.h>
#include <dovetail/widest_vectors.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

DOVETAIL_WIDEST_VECTORS void combine(const unsigned int n_rows, const double *const *const rows,
                                     const double *const x, const std::size_t n, double *const y)
{
  constexpr unsigned int width = 8;
  std::size_t i = 0;
  for (; i + width <= n; i += width) {
    double s[width] = {};
    for (unsigned int a = 0; a < n_rows; ++a) {
      const double factor = x[a];
      const double *const __restrict__ row = rows[a] + i;
      for (unsigned int k = 0; k < width; ++k)
        s[k] += factor * row[k];
    }
    for (unsigned int k = 0; k < width; ++k)
      y[i + k] = s[k];
  }
  for (; i < n; ++i) {
    double s = 0;
    for (unsigned int a = 0; a < n_rows; ++a)
      s += x[a] * rows[a][i];
    y[i] = s;
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

void combine_rows(const unsigned int n_rows, const double *const *const rows, const double *const x,
                  const std::size_t n, double *const y)
{
  combine(n_rows, rows, x, n, y);
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

constexpr unsigned int block = ShapeTable::block;

/// Of a block of functions, with the rows of phi @p n apart.
template <unsigned int dim>
[[gnu::always_inline]] inline void
add_forces_of_block(const std::size_t n_points, const std::size_t n, const double *phi, const double *A,
                    double *const __restrict__ sums, double *const __restrict__ sizes)
{
  double s[block] = {}, size[block] = {};
  for (std::size_t q = 0; q < n_points; ++q, phi += dim * n, A += dim) {
    double force[block] = {};
    for (unsigned int d = 0; d < dim; ++d)
      for (unsigned int b = 0; b < block; ++b)
        force[b] += A[d] * phi[d * n + b];
    for (unsigned int b = 0; b < block; ++b) {
      s[b] += force[b];
      size[b] += std::abs(force[b]);
    }
  }
  for (unsigned int b = 0; b < block; ++b) {
    sums[b] = s[b];
    sizes[b] = size[b];
  }
}

DOVETAIL_WIDEST_VECTORS void add_forces_of_block(const std::size_t n_points, const unsigned int dim,
                                                 const std::size_t n, const double *const phi,
                                                 const double *const A, double *const sums,
                                                 double *const sizes)
{
  if (dim == 3)
    add_forces_of_block<3>(n_points, n, phi, A, sums, sizes);
  else
    add_forces_of_block<2>(n_points, n, phi, A, sums, sizes);
}

/// y = sum_I D_IJ phi_I for all directions J of the columns, at every point, where both have dim of them.
template <unsigned int dim>
[[gnu::always_inline]] inline void multiply_gradients(const std::size_t n_points, const std::size_t n,
                                                      const double *D, const double *phi, double *y)
{
  for (std::size_t q = 0; q < n_points; ++q, phi += dim * n, D += dim * dim, y += dim * n)
    for (std::size_t a = 0; a < n; a += block) {
      double s[dim][block] = {};
      for (unsigned int I = 0; I < dim; ++I)
        for (unsigned int J = 0; J < dim; ++J)
          for (unsigned int b = 0; b < block; ++b)
            s[J][b] += D[I * dim + J] * phi[I * n + a + b];
      for (unsigned int J = 0; J < dim; ++J)
        for (unsigned int b = 0; b < block; ++b)
          y[J * n + a + b] = s[J][b];
    }
}

/// Likewise of any numbers of directions. A block of functions stays in the registers.
DOVETAIL_WIDEST_VECTORS void multiply_rows(const std::size_t n_points, const std::size_t n_rows,
                                           const std::size_t n_columns, const std::size_t n, const double *D,
                                           const double *phi, double *y)
{
  if (n_rows == 3 && n_columns == 3)
    return multiply_gradients<3>(n_points, n, D, phi, y);
  if (n_rows == 2 && n_columns == 2)
    return multiply_gradients<2>(n_points, n, D, phi, y);
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
                                       double (&__restrict__ sums)[n_rows_of_block][block])
{
  double s[n_rows_of_block][block] = {};
  for (std::size_t k = 0; k < n; ++k)
    for (unsigned int a = 0; a < n_rows_of_block; ++a)
      for (unsigned int b = 0; b < block; ++b)
        s[a][b] += x[k * stride_of_x + a] * y[k * stride_of_y + b];
  for (unsigned int a = 0; a < n_rows_of_block; ++a)
    for (unsigned int b = 0; b < block; ++b)
      sums[a][b] = s[a][b];
}

} // namespace

void add_forces(const ShapeTable &gradients, const double *const A, double *const sums, double *const sizes)
{
  double s[block], size[block];
  for (unsigned int a = 0; a < gradients.n_functions; a += block) {
    add_forces_of_block(gradients.n_points, gradients.n_directions, gradients.stride, gradients.row(0, 0) + a,
                        A, s, size);
    for (unsigned int b = 0; b < std::min(block, gradients.n_functions - a); ++b) {
      sums[a + b] += s[b];
      sizes[a + b] += size[b];
    }
  }
}

void add_cell_matrix(const ShapeTable &rows, const ShapeTable &columns, const std::vector<double> &D,
                     const bool is_symmetric, double *const C, const std::size_t row_length)
{
  thread_local std::vector<double> D_rows;
  const std::size_t n = std::size_t(rows.n_points) * columns.n_directions;
  D_rows.resize((n + 1) * rows.stride); // loops of gcc 12 read, and do not use, the row behind the last one
  multiply_rows(rows.n_points, rows.n_directions, columns.n_directions, rows.stride, D.data(),
                rows.values.data(), D_rows.data());
  double sums[n_rows_of_block][block];
  for (unsigned int a = 0; a < rows.n_functions; a += n_rows_of_block)
    for (unsigned int b = 0; b < columns.n_functions; b += block) {
      if (is_symmetric && b + block <= a)
        continue;
      sum_block(n, D_rows.data() + a, rows.stride, columns.values.data() + b, columns.stride, sums);
      // what is skipped below the diagonal is the mirror image of the blocks behind that of the rows
      const bool is_mirrored = is_symmetric && b > a / block * block;
      const unsigned int n_a = std::min(n_rows_of_block, rows.n_functions - a),
                         n_b = std::min(block, columns.n_functions - b);
      double *const entries = C + a * row_length + b, *const mirror = C + b * row_length + a;
      for (unsigned int i = 0; i < n_a; ++i)
        for (unsigned int j = 0; j < n_b; ++j)
          entries[i * row_length + j] += sums[i][j];
      for (unsigned int j = 0; is_mirrored && j < n_b; ++j)
        for (unsigned int i = 0; i < n_a; ++i)
          mirror[j * row_length + i] += sums[i][j];
    }
}

} // namespace dovetail
