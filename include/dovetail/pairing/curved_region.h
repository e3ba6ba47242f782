// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Regions of a plane whose edges are polynomial curves.

#pragma once

#include <dovetail/pairing/region.h>

#include <deal.II/base/tensor.h>

#include <array>
#include <functional>
#include <limits>
#include <vector>

namespace dovetail {

/// A part of a polynomial curve, c(v) = sum_k coefficients[k] v^k from begin to end (which may be smaller).
struct Arc
{
  static constexpr unsigned int largest_degree = 4;
  static constexpr unsigned int no_rim = std::numeric_limits<unsigned int>::max();

  std::array<dealii::Tensor<1, 2>, largest_degree + 1> coefficients;
  unsigned int degree = 1;
  double begin = 0, end = 1;
  unsigned int rim = no_rim; ///< the edge of the own face along which it lies, with the face's own parameter

  dealii::Point<2> at(double v) const;
  dealii::Tensor<1, 2> derivative(double v) const;
};

/// The arcs of a closed curve; for clip() each begins where the last one ends. They may run to and fro along
/// one line: integrals over the region are sums over its arcs, in which such parts cancel.
using CurvedRegion = std::vector<Arc>;

Arc straight_arc(const dealii::Point<2> &from, const dealii::Point<2> &to);

/// Arcs through points at the Gauss-Lobatto nodes of the unit interval.
class Interpolation
{
public:
  explicit Interpolation(unsigned int degree);
  Arc arc(const std::vector<dealii::Point<2>> &points) const;

private:
  std::vector<std::vector<double>> monomials; ///< [power][node]
};

/// An arc whose points lie on the line between its ends becomes that line.
Arc simplified(const Arc &arc);

/// One side of a window: where is_inside is positive, and how an arc along its rim joins two points that lie
/// on it.
struct WindowSide
{
  std::function<double(const Arc &arc, double v)> distance; ///< signed; in units of the order of one
  std::function<Arc(const Arc &from, double v, const Arc &to, double w)> join;
  bool is_line; ///< the distance is an affine function of the point
};

/// The left side of the line from a to b.
WindowSide left_of(const dealii::Point<2> &a, const dealii::Point<2> &b);

/// The part of a region on the inner side: Sutherland and Hodgman (1974) with the points where arcs cross the
/// side found by bracketing.
CurvedRegion clip(const CurvedRegion &region, const WindowSide &side);

/// Of the same curve the other way round.
CurvedRegion reversed(const CurvedRegion &region);

} // namespace dovetail
