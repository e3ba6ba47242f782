// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Small matrices, one at each point, times small vectors, one at each point, and a cell's matrix of them.

#pragma once

#include <cstddef>
#include <vector>

namespace dovetail {

/// y[i] = sum_a x[a] rows[a][i] for all a < @p n_rows and i < @p n.
void combine_rows(unsigned int n_rows, const double *const *rows, const double *x, std::size_t n, double *y);

/// sums[i] = sum_j |A_ij x_j| of the n x n matrix A.
void add_up_sizes(std::size_t n, const double *A, const double *x, double *sums);

/// Shape functions at the points of a cell: [point][direction][function]; the last direction may be the value
/// itself.
struct ShapeTable
{
  static constexpr unsigned int block = 8; ///< what a row of functions is filled up to, with zeros

  void reinit(unsigned int n_points, unsigned int n_directions, unsigned int n_functions);
  double *row(const unsigned int q, const unsigned int direction)
  {
    return values.data() + (std::size_t(q) * n_directions + direction) * stride;
  }
  const double *row(const unsigned int q, const unsigned int direction) const
  {
    return values.data() + (std::size_t(q) * n_directions + direction) * stride;
  }

  unsigned int n_points = 0, n_directions = 0, n_functions = 0, stride = 0;
  std::vector<double> values;
};

/// sums[a] += sum_q f_a(q) and sizes[a] += sum_q |f_a(q)| with f_a(q) = grad phi_a(q) . A(q), for the flux
/// @p A [point][direction] times the weight of the point.
void add_forces(const ShapeTable &gradients, const double *A, double *sums, double *sizes);

/// C_ab += sum_q phi_a(q)^T D(q) phi_b(q), with @p D [point][direction of phi_a][direction of phi_b] and rows
/// of C that begin @p row_length apart. @p is_symmetric: so is C, and each pair of blocks is computed once.
/// The sums run over blocks of C that fit into the registers, with the widest vectors that the processor has.
void add_cell_matrix(const ShapeTable &rows, const ShapeTable &columns, const std::vector<double> &D,
                     bool is_symmetric, double *C, std::size_t row_length);

} // namespace dovetail
