// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/pairing/curved_region.h>

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/lac/full_matrix.h>

#include <boost/math/tools/minima.hpp>
#include <boost/math/tools/toms748_solve.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace dovetail {

using dealii::Point;
using dealii::Tensor;

namespace {

/// Distances below this are none.
constexpr double smallest_distance = 1e-13;

double snapped(const double distance)
{
  return std::abs(distance) <= smallest_distance ? 0. : distance;
}

/// The zero between two parameters with values of different signs.
template <typename Function>
double zero_between(const Function &f, double a, double f_a, double b, double f_b)
{
  if (a > b) {
    std::swap(a, b);
    std::swap(f_a, f_b);
  }
  const auto snapped_to_zero = [&](const double v) {
    const double value = f(v);
    return std::abs(value) < 1e-16 ? 0. : value;
  };
  std::uintmax_t n_evaluations = 60;
  const auto bracket = boost::math::tools::toms748_solve(
      snapped_to_zero, a, b, f_a, f_b, boost::math::tools::eps_tolerance<double>(51), n_evaluations);
  return (bracket.first + bracket.second) / 2;
}

/// The parameter between a and b at which |f| is least.
template <typename Function>
double least_between(const Function &f, const double a, const double b)
{
  const int bits = std::numeric_limits<double>::digits / 2; // half of them is all that a minimum shows
  return boost::math::tools::brent_find_minima([&](const double v) { return std::abs(f(v)); }, std::min(a, b),
                                               std::max(a, b), bits)
      .first;
}

/// Where the distance of an arc's points changes its sign, in the order of the arc, with both ends of the
/// arc. Between two samples of one sign it may come and go: then the sample before or after is the least of
/// its neighbours.
std::vector<double> crossings(const Arc &arc, const WindowSide &side)
{
  const auto f = [&](const double v) { return snapped(side.distance(arc, v)); };
  const unsigned int n = arc.degree == 1 && side.is_line ? 1 : 4 * arc.degree + 4;
  std::vector<double> v, d;
  for (unsigned int i = 0; i <= n; ++i) {
    v.push_back(i == n ? arc.end : arc.begin + (arc.end - arc.begin) * i / n);
    d.push_back(f(v.back()));
  }
  for (unsigned int i = 1; i < v.size() - 1; ++i) {
    const bool is_least = d[i - 1] * d[i] > 0 && d[i] * d[i + 1] > 0 &&
                          std::abs(d[i]) <= std::abs(d[i - 1]) && std::abs(d[i]) <= std::abs(d[i + 1]) &&
                          std::abs(d[i]) < std::abs(d[i - 1] - d[i]) + std::abs(d[i + 1] - d[i]);
    if (!is_least)
      continue;
    const double between = least_between(f, v[i - 1], v[i + 1]), least = f(between);
    if (least * d[i] < 0) {
      const bool is_before = (between < v[i]) == (arc.begin < arc.end);
      v.insert(v.begin() + i + (is_before ? 0 : 1), between);
      d.insert(d.begin() + i + (is_before ? 0 : 1), least);
      ++i;
    }
  }
  std::vector<double> result = {arc.begin};
  for (unsigned int i = 0; i + 1 < v.size(); ++i) {
    if (i > 0 && d[i] == 0)
      result.push_back(v[i]);
    if (d[i] * d[i + 1] < 0)
      result.push_back(zero_between([&](const double w) { return side.distance(arc, w); }, v[i], d[i],
                                    v[i + 1], d[i + 1]));
  }
  result.push_back(arc.end);
  return result;
}

/// The parts of an arc on the inner side.
void keep_inside(const Arc &arc, const WindowSide &side, CurvedRegion &parts)
{
  const std::vector<double> ends = crossings(arc, side);
  bool continues = false;
  for (unsigned int i = 0; i + 1 < ends.size(); ++i) {
    const bool is_inside = snapped(side.distance(arc, (ends[i] + ends[i + 1]) / 2)) >= 0;
    if (is_inside && continues)
      parts.back().end = ends[i + 1];
    else if (is_inside) {
      parts.push_back(arc);
      parts.back().begin = ends[i];
      parts.back().end = ends[i + 1];
    }
    continues = is_inside;
  }
}

} // namespace

Point<2> Arc::at(const double v) const
{
  Tensor<1, 2> X = coefficients[degree];
  for (unsigned int k = degree; k-- > 0;)
    X = coefficients[k] + v * X;
  return Point<2>(X);
}

Tensor<1, 2> Arc::derivative(const double v) const
{
  Tensor<1, 2> result = double(degree) * coefficients[degree];
  for (unsigned int k = degree; k-- > 1;)
    result = double(k) * coefficients[k] + v * result;
  return result;
}

Arc straight_arc(const Point<2> &from, const Point<2> &to)
{
  Arc arc;
  arc.coefficients[0] = from;
  arc.coefficients[1] = to - from;
  return arc;
}

Interpolation::Interpolation(const unsigned int degree) : monomials(degree + 1)
{
  const auto nodes =
      degree == 0 ? std::vector<Point<1>>(1) : dealii::QGaussLobatto<1>(degree + 1).get_points();
  dealii::FullMatrix<double> powers(degree + 1);
  for (unsigned int i = 0; i <= degree; ++i)
    for (unsigned int k = 0; k <= degree; ++k)
      powers(i, k) = std::pow(nodes[i][0], k);
  powers.gauss_jordan();
  for (unsigned int k = 0; k <= degree; ++k)
    for (unsigned int i = 0; i <= degree; ++i)
      monomials[k].push_back(powers(k, i));
}

Arc Interpolation::arc(const std::vector<Point<2>> &points) const
{
  Arc result;
  result.degree = monomials.size() - 1;
  for (unsigned int k = 0; k <= result.degree; ++k) {
    result.coefficients[k] = k == 0 ? points[0] : Point<2>();
    for (unsigned int i = 0; k > 0 && i < points.size(); ++i)
      result.coefficients[k] += monomials[k][i] * (points[i] - points[0]);
  }
  return result;
}

Arc simplified(const Arc &arc)
{
  const Point<2> from = arc.at(arc.begin), to = arc.at(arc.end);
  const Tensor<1, 2> chord = to - from;
  const double length = chord.norm();
  for (unsigned int i = 1; i <= arc.degree && arc.degree > 1; ++i) {
    const Tensor<1, 2> r = arc.at(arc.begin + (arc.end - arc.begin) * i / (arc.degree + 1.)) - from;
    if (std::abs(chord[0] * r[1] - chord[1] * r[0]) > 1e-12 * length * std::max(1., length))
      return arc;
  }
  return arc.degree == 1 ? arc : straight_arc(from, to);
}

WindowSide left_of(const Point<2> &a, const Point<2> &b)
{
  const Tensor<1, 2> along = (b - a) / b.distance(a);
  return {[=](const Arc &arc, const double v) {
            const Tensor<1, 2> r = arc.at(v) - a;
            return along[0] * r[1] - along[1] * r[0];
          },
          [](const Arc &from, const double v, const Arc &to, const double w) {
            return straight_arc(from.at(v), to.at(w));
          },
          true};
}

CurvedRegion clip(const CurvedRegion &region, const WindowSide &side)
{
  CurvedRegion parts;
  for (const Arc &arc : region)
    keep_inside(arc, side, parts);
  CurvedRegion result;
  for (unsigned int i = 0; i < parts.size(); ++i) {
    const Arc &part = parts[i], &next = parts[(i + 1) % parts.size()];
    result.push_back(part);
    if (part.at(part.end).distance(next.at(next.begin)) > smallest_distance)
      result.push_back(side.join(part, part.end, next, next.begin));
  }
  return result;
}

CurvedRegion reversed(const CurvedRegion &region)
{
  CurvedRegion result(region.rbegin(), region.rend());
  for (Arc &arc : result)
    std::swap(arc.begin, arc.end);
  return result;
}

} // namespace dovetail
