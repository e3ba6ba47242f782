// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Values and gradients at the points of several quadrilaterals or hexahedra at a time, direction by
// direction.

#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace dovetail {

/// A number of each of the cells that are treated at a time. The numbers follow each other in memory, so that
/// the loops below run with the widest vectors that the processor has, which deal.II's own loops do only
/// where deal.II was built for that processor.
template <typename Number>
struct alignas(8 * sizeof(Number)) LanesOf
{
  static constexpr unsigned int size = 8;

  LanesOf() = default;
  explicit LanesOf(const Number value) { values.fill(value); }
  Number &operator[](const unsigned int lane) { return values[lane]; }
  Number operator[](const unsigned int lane) const { return values[lane]; }
  LanesOf &operator+=(const LanesOf &other)
  {
    for (unsigned int lane = 0; lane < size; ++lane)
      values[lane] += other[lane];
    return *this;
  }
  LanesOf &operator*=(const LanesOf &other)
  {
    for (unsigned int lane = 0; lane < size; ++lane)
      values[lane] *= other[lane];
    return *this;
  }
  LanesOf &operator*=(const Number factor) { return *this *= LanesOf(factor); }
  friend LanesOf operator+(LanesOf a, const LanesOf &b) { return a += b; }
  friend LanesOf operator*(LanesOf a, const LanesOf &b) { return a *= b; }
  friend LanesOf operator*(LanesOf a, const Number b) { return a *= b; }

  std::array<Number, size> values{};
};

using Lanes = LanesOf<double>;

/// Polynomials of a degree on a line, as many as points: their values, and the slopes of the polynomials that
/// are one at one of the points and zero at the others.
template <typename Number>
struct LineTable
{
  explicit LineTable(unsigned int degree); ///< from 1 to 4; at Gauss points, in the order of the line
  unsigned int n;
  std::vector<Number> values, slopes;                       ///< [point][polynomial]
  std::vector<Number> transposed_values, transposed_slopes; ///< [polynomial][point]
};

/// Numbers of the cells that are treated at a time, each by lane, in double or in single precision.
template <typename Number>
struct CellNumbers
{
  unsigned int dim, n_components;
  Number *coefficients; ///< [component][function], of tensor products of dim lines
  Number *values;       ///< [component][point]
  Number *gradients;    ///< in the unit cell: [component][direction][point]
};

/// Fills values and gradients from the coefficients.
template <typename Number>
void evaluate_in_cells(const LineTable<Number> &line, const CellNumbers<Number> &numbers);

/// The transpose: coefficients = sums over the points of gradients, and of values unless @p has_values is
/// false. Overwrites values and gradients.
template <typename Number>
void integrate_in_cells(const LineTable<Number> &line, bool has_values, const CellNumbers<Number> &numbers);

/// Sums by row of a small matrix.
struct PointSums
{
  struct Term
  {
    unsigned int from, entry;
  };
  void add_row() { begin_of_row.push_back(terms.size()); } ///< the terms of the last row are complete
  unsigned int n_rows() const { return begin_of_row.size() - 1; }

  std::vector<Term> terms;
  std::vector<unsigned int> begin_of_row = {0}; ///< and the end of the last one
  double factor = 1;                            ///< of all
};

/// A small matrix at every point of the cells that are treated at a time.
struct PointMatrices
{
  const PointSums &sums;
  std::size_t n_points;
  const Lanes *entries; ///< [entry][point], or [entry] if they are the same at all points
  bool are_equal;
  const double *weights; ///< by point; nullptr: none
  /// Unless nullptr, [entry][point] of J by row, then dV: slopes of the unit cell times J are those that the
  /// matrix multiplies, and its rows of slopes are multiplied by J^T dV, the others by dV.
  const Lanes *J;
};

/// x = weight matrix x with x[row][point], rows of slopes by component first, each by lane. At most 12 rows.
template <typename Number>
void multiply_at_points(const PointMatrices &matrices, unsigned int dim, unsigned int n_slopes, Number *x);

} // namespace dovetail
