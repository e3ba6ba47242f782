// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/pairing/chart.h>

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/boost_adaptors/point.h>

#include <boost/geometry/algorithms/convex_hull.hpp>
#include <boost/geometry/geometries/multi_point.hpp>
#include <boost/geometry/geometries/ring.hpp>
#include <boost/geometry/strategies/strategies.hpp>

#include <algorithm>
#include <cmath>

namespace dovetail {

using namespace dealii;

template <int dim>
Chart<dim>::Chart(const FaceShape<dim> &shape, const FaceShape<dim> &bilinear, const Point<dim> *nodes,
                  const double size, const double offset)
    : is_flat(shape.is_flat(nodes)), is_affine(is_flat && shape.is_affine(nodes)), shape(shape),
      bilinear(bilinear), nodes(nodes), size(size)
{
  origin = shape.corner(nodes, 0);
  rounding = std::max(1e-14, 4e-15 * std::max(origin.norm(), offset) / size);
  negligible = is_flat ? std::max(1e-13, rounding) : 1e-11;
  const unsigned int n = shape.n_corners();
  if constexpr (dim == 2) {
    axis[0] = shape.corner(nodes, 1) - origin;
    window = {Point<1>(0.), Point<1>(1.)};
  } else {
    const Tensor<1, dim> N = n == 3 ? cross_product_3d(nodes[1] - nodes[0], nodes[2] - nodes[0])
                                    : cross_product_3d(shape.corner(nodes, 2) - origin,
                                                       shape.corner(nodes, 3) - shape.corner(nodes, 1));
    if (N.norm_square() == 0) // the face has no area
      return;
    axis[0] = shape.corner(nodes, 1) - origin;
    if (axis[0].norm() < 1e-6 * size) // an edge of a hexahedron may have no length
      axis[0] = shape.corner(nodes, 2) - origin;
    axis[0] -= (axis[0] * N) / N.norm_square() * N;
    axis[0] /= axis[0].norm();
    axis[1] = cross_product_3d(N / N.norm(), axis[0]);
    for (unsigned int i = 0; i < n; ++i)
      window.push_back(project(shape.corner(nodes, i)));
    if (is_affine) {
      const Tensor<1, 2> a = window[1] - window[0], b = window[n - 1] - window[0];
      Tensor<2, 2> edges;
      for (unsigned int d = 0; d < 2; ++d) {
        edges[d][0] = a[d];
        edges[d][1] = b[d];
      }
      inverse = invert(edges);
    } else {
      nodes_of_plane.resize(n);
      for (unsigned int i = 0; i < n; ++i) // quadrilaterals: lexicographic
        nodes_of_plane[n == 4 && i >= 2 ? 5 - i : i] = lift(window[i]);
    }
  }
}

template <int dim>
Point<dim - 1> Chart<dim>::project(const Point<dim> &X) const
{
  Point<dim - 1> s;
  if constexpr (dim == 2)
    s[0] = is_flat ? (X - origin) * axis[0] / axis[0].norm_square() : shape.closest(nodes, X).xi[0];
  else
    for (unsigned int k = 0; k < dim - 1; ++k)
      s[k] = (X - origin) * axis[k] / size;
  return s;
}

template <int dim>
bool Chart<dim>::is_in_plane(const Point<dim> &X) const
{
  Tensor<1, dim> r = X - origin;
  for (const Tensor<1, dim> &direction : axis)
    r -= (r * direction) * direction;
  return r.norm() <= std::max(1e-9, rounding) * size;
}

template <int dim>
Point<dim> Chart<dim>::lift(const Point<dim - 1> &s) const
{
  Point<dim> X = origin;
  for (unsigned int k = 0; k < dim - 1; ++k)
    X += size * s[k] * axis[k];
  return X;
}

template <int dim>
Point<dim - 1> Chart<dim>::xi_of(const Point<dim - 1> &s) const
{
  if constexpr (dim == 2)
    return s;
  else
    return is_affine ? Point<dim - 1>(inverse * (s - window[0]))
                     : bilinear.closest(nodes_of_plane.data(), lift(s)).xi;
}

template <int dim>
Region<dim - 1> Chart<dim>::to_integration(const Region<dim - 1> &region) const
{
  if (dim == 2 || is_flat)
    return region;
  Region<dim - 1> result;
  for (const auto &corner : region) {
    result.push_back(xi_of(corner));
    if (shape.degree() > 1 && !shape.is_triangle())
      improve(corner, result.back());
  }
  return result;
}

/// Newton's method for project(X(xi)) = s on the true face, from the plane one. On the rim xi stays on the
/// rim, so that the segments still tile the face.
template <int dim>
void Chart<dim>::improve(const Point<dim - 1> &s, Point<dim - 1> &xi) const
{
  if constexpr (dim == 3) {
    const auto is_on_rim = [&xi](const unsigned int k) { return xi[k] < 1e-10 || xi[k] > 1 - 1e-10; };
    const std::array<bool, 2> is_fixed{{is_on_rim(0), is_on_rim(1)}};
    const Point<2> start = xi;
    for (unsigned int iteration = 0; iteration < 10 && !(is_fixed[0] && is_fixed[1]); ++iteration) {
      const SurfacePoint<dim> point = shape.evaluate(nodes, xi);
      const Tensor<1, 2> rest = s - project(point.X);
      const Tensor<2, 2> J = derivative(point);
      Tensor<1, 2> step;
      if (!is_fixed[0] && !is_fixed[1])
        step = invert(J) * rest;
      else {
        const unsigned int l = is_fixed[0] ? 1 : 0;
        const Tensor<1, 2> along({J[0][l], J[1][l]});
        step[l] = along * rest / along.norm_square();
      }
      xi += step;
      if (step.norm() < 1e-14)
        break;
    }
    const bool is_inside = xi[0] >= 0 && xi[0] <= 1 && xi[1] >= 0 && xi[1] <= 1;
    if (!is_inside || (xi - start).norm() > 0.25)
      xi = start; // the face is too strongly curved
  }
}

template <int dim>
SurfacePoint<dim> Chart<dim>::evaluate(const Point<dim - 1> &s) const
{
  return shape.evaluate(nodes, is_flat ? xi_of(s) : s);
}

template <int dim>
double Chart<dim>::jacobian(const SurfacePoint<dim> &point) const
{
  if constexpr (dim == 2)
    return point.tangent[0].norm();
  else
    return is_flat ? size * size : cross_product_3d(point.tangent[0], point.tangent[1]).norm();
}

template <int dim>
Tensor<2, dim - 1> Chart<dim>::derivative(const SurfacePoint<dim> &point) const
{
  Tensor<2, dim - 1> J;
  for (unsigned int k = 0; k < dim - 1; ++k)
    for (unsigned int l = 0; l < dim - 1; ++l)
      J[k][l] = axis[k] * point.tangent[l] / size;
  return J;
}

namespace {

/// For areas and centroids of regions with curved edges.
const QGauss<1> &rule_of_arcs()
{
  static const QGauss<1> rule(10);
  return rule;
}

} // namespace

CurvedWindow::CurvedWindow(const Chart<3> &chart) : chart(chart)
{
  const Interpolation interpolation(chart.shape.degree());
  for (unsigned int i = 0; i < chart.shape.n_corners(); ++i) {
    std::vector<Point<2>> points;
    for (const Point<3> &X : chart.shape.edge(chart.nodes, i))
      points.push_back(chart.project(X));
    rims.push_back(interpolation.arc(points));
    rims.back().rim = i;
  }
  whole = chart.is_flat ? dovetail::measure(chart.window) : chart.shape.is_triangle() ? 0.5 : 1.;
  polygon = chart.is_flat ? chart.window : surroundings();
}

CurvedRegion CurvedWindow::project(const FaceShape<3> &shape, const Point<3> *nodes,
                                   const Interpolation &interpolation) const
{
  CurvedRegion region;
  double twice = 0;
  std::vector<Point<2>> points;
  for (unsigned int i = 0; i < shape.n_corners(); ++i) {
    points.clear();
    for (const Point<3> &X : shape.edge(nodes, i))
      points.push_back(chart.project(X));
    region.push_back(simplified(interpolation.arc(points)));
    for (const unsigned int q : {0, 1})
      twice += cross(points[q == 0 ? 0 : points.size() / 2],
                     points[q == 0 ? points.size() / 2 : points.size() - 1]);
  }
  return twice < 0 ? reversed(region) : region;
}

/// The convex hull of the face, widened, counter-clockwise: reference coordinates are asked for near the face
/// only.
Region<2> CurvedWindow::surroundings() const
{
  namespace bg = boost::geometry;
  bg::model::multi_point<Point<2>> points;
  for (const Arc &rim : rims)
    for (unsigned int i = 0; i < 8; ++i)
      points.push_back(rim.at(i / 8.));
  bg::model::ring<Point<2>, false, false> hull;
  bg::convex_hull(points, hull);
  Region<2> result(hull.begin(), hull.end());
  const Point<2> centre = dovetail::centroid(result);
  for (Point<2> &corner : result)
    corner = centre + 1.1 * (corner - centre);
  return result;
}

CurvedRegion CurvedWindow::clip(const CurvedRegion &region) const
{
  CurvedRegion result = region;
  for (unsigned int i = 0; i < polygon.size() && !result.empty(); ++i)
    if (const Point<2> &a = polygon[i], &b = polygon[(i + 1) % polygon.size()]; a.distance(b) > 1e-14)
      result = dovetail::clip(result, left_of(a, b));
  if (chart.is_flat)
    return result;
  for (unsigned int i = 0; i < rims.size() && !result.empty(); ++i) {
    const auto parameter = [&](const Arc &arc, const double v) { return parameter_of_rim(i, xi_of(arc, v)); };
    const WindowSide side = {[&](const Arc &arc, const double v) {
                               return arc.rim == i ? 0. : distance_from_rim(i, xi_of(arc, v));
                             },
                             [&](const Arc &from, const double v, const Arc &to, const double w) {
                               Arc along = rims[i];
                               along.begin = parameter(from, v);
                               along.end = parameter(to, w);
                               return along;
                             },
                             false};
    result = dovetail::clip(result, side);
  }
  return without_detours(result);
}

/// Where arcs along the rim run to and fro, only what remains of their sum.
CurvedRegion CurvedWindow::without_detours(const CurvedRegion &region) const
{
  CurvedRegion result;
  std::vector<std::vector<std::pair<double, int>>> changes(rims.size()); // how often the rim is passed
  for (const Arc &arc : region)
    if (arc.rim == Arc::no_rim)
      result.push_back(arc);
    else {
      changes[arc.rim].emplace_back(arc.begin, 1);
      changes[arc.rim].emplace_back(arc.end, -1);
    }
  for (unsigned int i = 0; i < rims.size(); ++i) {
    std::sort(changes[i].begin(), changes[i].end());
    int n_passes = 0;
    for (unsigned int j = 0; j + 1 < changes[i].size(); ++j) {
      n_passes += changes[i][j].second;
      if (n_passes == 0 || changes[i][j + 1].first - changes[i][j].first < 1e-14)
        continue;
      Arc arc = rims[i];
      arc.begin = changes[i][j].first;
      arc.end = changes[i][j + 1].first;
      if (n_passes < 0)
        std::swap(arc.begin, arc.end);
      for (int pass = 0; pass < std::abs(n_passes); ++pass)
        result.push_back(arc);
    }
  }
  return result;
}

double CurvedWindow::distance_from_rim(const unsigned int rim, const Point<2> &xi) const
{
  if (chart.shape.is_triangle())
    return rim == 0 ? xi[1] : rim == 1 ? 1 - xi[0] - xi[1] : xi[0];
  return rim == 0 ? xi[1] : rim == 1 ? 1 - xi[0] : rim == 2 ? 1 - xi[1] : xi[0];
}

double CurvedWindow::parameter_of_rim(const unsigned int rim, const Point<2> &xi) const
{
  if (chart.shape.is_triangle())
    return rim == 0 ? xi[0] : rim == 1 ? xi[1] : 1 - xi[1];
  return rim == 0 ? xi[0] : rim == 1 ? xi[1] : rim == 2 ? 1 - xi[0] : 1 - xi[1];
}

Point<2> CurvedWindow::xi_of(const Arc &arc, const double v) const
{
  if (arc.rim == Arc::no_rim)
    return xi_of(arc.at(v));
  const Point<2> from = chart.shape.corner(arc.rim);
  return from + v * (chart.shape.corner((arc.rim + 1) % rims.size()) - from);
}

/// Newton's method for project(X(xi)) = s, from the plane face.
Point<2> CurvedWindow::xi_of(const Point<2> &s) const
{
  if (chart.is_affine)
    return chart.xi_of(s);
  Point<2> xi = chart.xi_of(s);
  for (unsigned int iteration = 0; iteration < 30; ++iteration) {
    const SurfacePoint<3> point = chart.shape.evaluate(chart.nodes, xi);
    const Tensor<2, 2> J = chart.derivative(point);
    const double det = determinant(J);
    if (!(std::abs(det) > 1e-6 * J[0].norm() * J[1].norm()))
      break;
    Tensor<1, 2> step = invert(J) * (s - chart.project(point.X));
    if (step.norm() > 0.5)
      step *= 0.5 / step.norm();
    xi += step;
    if (step.norm() < chart.rounding || (iteration > 6 && step.norm() < 100 * chart.rounding))
      return xi;
  }
  failed = true;
  return xi;
}

CurvedWindow::CurvePoint CurvedWindow::evaluate(const Arc &arc, const double v) const
{
  if (chart.is_flat)
    return {arc.at(v), arc.derivative(v)};
  const Point<2> xi = xi_of(arc, v);
  if (arc.rim != Arc::no_rim)
    return {xi, chart.shape.corner((arc.rim + 1) % rims.size()) - chart.shape.corner(arc.rim)};
  return {xi, invert(chart.derivative(chart.shape.evaluate(chart.nodes, xi))) * arc.derivative(v)};
}

bool CurvedWindow::is_straight(const Arc &arc) const
{
  if (chart.is_flat)
    return arc.degree == 1;
  if (arc.rim != Arc::no_rim)
    return true;
  const Point<2> from = xi_of(arc.at(arc.begin)), to = xi_of(arc.at(arc.end));
  for (const double share : {0.2, 0.55, 0.8}) {
    const Tensor<1, 2> r = xi_of(arc.at(arc.begin + share * (arc.end - arc.begin))) - from;
    if (std::abs(cross(to - from, r)) > 1e-12)
      return false;
  }
  return true;
}

double CurvedWindow::measure(const CurvedRegion &region) const
{
  double twice = 0;
  const Point<2> origin = evaluate(region[0], region[0].begin).s;
  for (const Arc &arc : region)
    for (unsigned int q = 0; q < rule_of_arcs().size(); ++q) {
      const double v = arc.begin + (arc.end - arc.begin) * rule_of_arcs().point(q)[0];
      const CurvePoint point = evaluate(arc, v);
      twice += rule_of_arcs().weight(q) * (arc.end - arc.begin) * cross(point.s - origin, point.derivative);
    }
  return twice / 2;
}

Point<2> CurvedWindow::centroid(const CurvedRegion &region) const
{
  double twice = 0;
  Tensor<1, 2> sum;
  const Point<2> origin = evaluate(region[0], region[0].begin).s;
  for (const Arc &arc : region)
    for (unsigned int q = 0; q < rule_of_arcs().size(); ++q) {
      const double v = arc.begin + (arc.end - arc.begin) * rule_of_arcs().point(q)[0];
      const CurvePoint point = evaluate(arc, v);
      const double part =
          rule_of_arcs().weight(q) * (arc.end - arc.begin) * cross(point.s - origin, point.derivative);
      twice += part;
      sum += part * 2. / 3 * (point.s - origin);
    }
  return origin + sum / twice;
}

Point<2> CurvedWindow::reference_point(const Point<2> &s) const
{
  return chart.is_flat ? xi_of(s) : s;
}

std::vector<Point<2>> CurvedWindow::reference_points(const Arc &arc) const
{
  const bool stays_straight = arc.rim != Arc::no_rim || (arc.degree == 1 && chart.is_affine);
  const unsigned int n = stays_straight ? 1 : 8;
  std::vector<Point<2>> result;
  for (unsigned int i = 0; i <= n; ++i)
    result.push_back(xi_of(arc, arc.begin + (arc.end - arc.begin) * i / n));
  return result;
}

Region<2> CurvedWindow::reference_corners() const
{
  Region<2> result;
  for (unsigned int i = 0; i < rims.size(); ++i)
    result.push_back(chart.shape.corner(i));
  return result;
}

template class Chart<2>;
template class Chart<3>;

} // namespace dovetail
