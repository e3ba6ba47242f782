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
struct alignas(64) Lanes
{
  static constexpr unsigned int size = 8;

  Lanes() = default;
  explicit Lanes(const double value) { values.fill(value); }
  double &operator[](const unsigned int lane) { return values[lane]; }
  double operator[](const unsigned int lane) const { return values[lane]; }
  Lanes &operator+=(const Lanes &other)
  {
    for (unsigned int lane = 0; lane < size; ++lane)
      values[lane] += other[lane];
    return *this;
  }
  Lanes &operator*=(const Lanes &other)
  {
    for (unsigned int lane = 0; lane < size; ++lane)
      values[lane] *= other[lane];
    return *this;
  }
  Lanes &operator*=(const double factor) { return *this *= Lanes(factor); }
  friend Lanes operator+(Lanes a, const Lanes &b) { return a += b; }
  friend Lanes operator*(Lanes a, const Lanes &b) { return a *= b; }
  friend Lanes operator*(Lanes a, const double b) { return a *= b; }

  std::array<double, size> values{};
};

/// Polynomials of a degree on a line, as many as points: their values, and the slopes of the polynomials that
/// are one at one of the points and zero at the others.
struct LineTable
{
  explicit LineTable(unsigned int degree); ///< from 1 to 4; at Gauss points, in the order of the line
  unsigned int n;
  std::vector<double> values, slopes;                       ///< [point][polynomial]
  std::vector<double> transposed_values, transposed_slopes; ///< [polynomial][point]
};

/// Fills values [component][point] and gradients in the unit cell [component][direction][point] from the
/// coefficients [component][function] of tensor products of dim lines, each by lane.
void evaluate_in_cells(unsigned int dim, unsigned int n_components, const LineTable &line,
                       const double *coefficients, double *values, double *gradients);

/// The transpose: coefficients = sums over the points of gradients, and of values unless @p has_values is
/// false. Overwrites values and gradients.
void integrate_in_cells(unsigned int dim, unsigned int n_components, const LineTable &line, bool has_values,
                        double *values, double *gradients, double *coefficients);

/// Sums by row of a small matrix at every point, or of the same one at all of them.
struct PointSums
{
  struct Term
  {
    unsigned int from, entry;
    double factor;
  };
  void add_row() { begin_of_row.push_back(terms.size()); } ///< the terms of the last row are complete
  unsigned int n_rows() const { return begin_of_row.size() - 1; }

  std::vector<Term> terms;
  std::vector<unsigned int> begin_of_row = {0}; ///< and the end of the last one
};

/// y[row][point] = sum factor A[entry][point] x[from][point], each by lane.
void multiply_at_points(const PointSums &sums, std::size_t n_points, const double *A, const double *x,
                        double *y);
/// y[row][point] = weight[point] sum factor A[entry] x[from][point], each by lane.
void multiply_at_points(const PointSums &sums, const std::vector<double> &weights, const double *A,
                        const double *x, double *y);

} // namespace dovetail
