// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Clipping is done in the coordinates of a chart of the own face: in 2D its reference coordinate, in 3D
// coordinates in the plane through its corners in units of its size. Straight edges of plane faces are then
// straight, so the segments are exact. A face that is not plane is integrated over its reference
// coordinates, to which the corners of its segments are mapped.

#include <dovetail/domain/quadrature.h>
#include <dovetail/interface/face_points.h>
#include <dovetail/interface/region.h>

#include <deal.II/numerics/rtree.h>

#include <boost/iterator/function_output_iterator.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace dovetail {

using namespace dealii;

namespace {

/// Coordinates s on a face: for clipping and, unless the face is curved in 3D, for integration too.
template <int dim>
class Chart
{
public:
  /// @p offset: rounding is relative to this distance from the origin, or to that of the face if it is
  /// larger.
  Chart(const FaceShape<dim> &shape, const FaceShape<dim> &bilinear, const Point<dim> *nodes, double size,
        double offset);

  Region<dim - 1> window;                 ///< the face itself; empty if it has no area
  std::vector<Point<dim>> nodes_of_plane; ///< of the plane face through the corners
  bool is_flat, is_affine;
  double negligible; ///< regions below this fraction of a face are rounding

  /// The projection of a point of the other side.
  Point<dim - 1> project(const Point<dim> &X) const;
  /// From the coordinates of the clipping to those of the integration.
  Region<dim - 1> to_integration(const Region<dim - 1> &region) const;
  SurfacePoint<dim> evaluate(const Point<dim - 1> &s) const; ///< s of the integration
  double jacobian(const SurfacePoint<dim> &point) const;     ///< dA / ds there

private:
  Point<dim> lift(const Point<dim - 1> &s) const; ///< the point of the plane
  Point<dim - 1> xi_of(const Point<dim - 1> &s) const;
  void improve(const Point<dim - 1> &s, Point<dim - 1> &xi) const;

  const FaceShape<dim> &shape, &bilinear;
  const Point<dim> *nodes;
  double size;
  Point<dim> origin;
  std::array<Tensor<1, dim>, dim - 1> axis;
  Tensor<2, dim - 1> inverse; ///< dxi / ds of an affine face
};

template <int dim>
Chart<dim>::Chart(const FaceShape<dim> &shape, const FaceShape<dim> &bilinear, const Point<dim> *nodes,
                  const double size, const double offset)
    : is_flat(shape.is_flat(nodes)), is_affine(is_flat && shape.is_affine(nodes)), shape(shape),
      bilinear(bilinear), nodes(nodes), size(size)
{
  origin = shape.corner(nodes, 0);
  negligible = is_flat ? std::max(1e-13, 4e-15 * std::max(origin.norm(), offset) / size) : 1e-11;
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
      for (unsigned int i : {0, 1, 3, 2}) // lexicographic
        nodes_of_plane.push_back(lift(window[i]));
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
    if (shape.degree() > 1)
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
      Tensor<2, 2> J; // ds / dxi
      for (unsigned int k = 0; k < 2; ++k)
        for (unsigned int l = 0; l < 2; ++l)
          J[k][l] = axis[k] * point.tangent[l] / size;
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

Region<1> box_region(const Point<1> &lower, const Point<1> &upper)
{
  return {lower, upper};
}

Region<2> box_region(const Point<2> &lower, const Point<2> &upper)
{
  return {lower, Point<2>(upper[0], lower[1]), upper, Point<2>(lower[0], upper[1])};
}

template <int dim>
std::vector<Region<dim>> subtract_from_all(const std::vector<Region<dim>> &parts, const Region<dim> &hole)
{
  std::vector<Region<dim>> left;
  for (const auto &part : parts)
    for (const auto &outside : subtract(part, hole))
      left.push_back(outside);
  return left;
}

/// The rules by the degree that they must integrate.
template <int structdim>
class Rules
{
public:
  /// Exact for degree @p degree in total, on the unit interval or triangle.
  const Quadrature<structdim> &simplex(const unsigned int degree)
  {
    const auto known = of_degree.find(degree);
    if (known != of_degree.end())
      return known->second;
    return of_degree.emplace(degree, make(degree)).first->second;
  }

private:
  static Quadrature<structdim> make(const unsigned int degree)
  {
    if constexpr (structdim == 1)
      return QGauss<1>(degree / 2 + 1);
    else if (degree > 14)
      return gauss_rule<2>(ReferenceCells::Triangle, degree / 2 + 1);
    else // rules of even and of odd degree
      return QWitherdenVincentSimplex<2>(std::max(1u, (degree + 1) / 2), degree % 2 == 1 || degree == 0);
  }

  std::map<unsigned int, Quadrature<structdim>> of_degree;
};

/// The quadrature of all segments of one side.
template <int dim>
class Segmentation
{
public:
  Segmentation(const SideFaces<dim> &own, const FaceLocator<dim> &partner, unsigned int own_degree,
               unsigned int partner_degree);
  FacePoints<dim> run();

private:
  using NearbyFace = typename FaceLocator<dim>::NearbyFace;
  using Match = typename FaceLocator<dim>::Match;

  /// What a face shares with one of the other side.
  struct Segment
  {
    Region<dim - 1> region;
    const NearbyFace *partner; ///< or, if it is not tied, the nearest face; nullptr: there is none
    double distance;           ///< at the centroid
    bool is_tied = true;
  };

  using Boxes = RTree<std::pair<BoundingBox<dim - 1>, unsigned int>>; ///< of regions
  static BoundingBox<dim - 1> box_of(const Region<dim - 1> &region);
  static std::vector<unsigned int> overlapping(const Boxes &boxes, const Region<dim - 1> &region);
  static void collect_rest(const Region<dim - 1> &region, const Boxes &boxes,
                           const std::vector<Segment> &segments, std::vector<Region<dim - 1>> &rest);

  void add_face(unsigned int face, const std::vector<unsigned int> &nearby);
  bool is_near(const Chart<dim> &chart, const Region<dim - 1> &region, const NearbyFace &face,
               Segment &segment);
  void keep_nearest(const Chart<dim> &chart, std::vector<Segment> &segments) const;
  void add_rest(const Chart<dim> &chart, const std::vector<unsigned int> &nearby,
                std::vector<Segment> &segments);
  void integrate(const Chart<dim> &chart, const Segment &segment);
  bool is_aligned_box(const Chart<dim> &chart, const Region<dim - 1> &region,
                      const NearbyFace &partner) const;
  void add_piece(const Chart<dim> &chart, const std::vector<Point<dim - 1>> &corners,
                 const Quadrature<dim - 1> &rule, const Segment &segment);
  Match match(const NearbyFace &partner, const typename FaceLocator<dim>::Query &query) const;

  const SideFaces<dim> &own;
  const FaceLocator<dim> &locator;
  const FaceShape<dim> &partner_shape;
  const FaceShape<dim> bilinear_own;
  const unsigned int degree; ///< of the elements, the larger one
  const bool has_quadrilaterals;
  typename FaceLocator<dim>::NearbyFaces others;
  Rules<dim - 1> rules;
  unsigned int current_face = 0;
  FacePoints<dim> points;
};

template <int dim>
Segmentation<dim>::Segmentation(const SideFaces<dim> &own, const FaceLocator<dim> &partner,
                                const unsigned int own_degree, const unsigned int partner_degree)
    : own(own), locator(partner), partner_shape(partner.side().shape), bilinear_own(own.shape.cell(), 1),
      degree(std::max(own_degree, partner_degree)),
      has_quadrilaterals(dim == 3 && !(own.shape.is_triangle() && partner_shape.is_triangle()))
{
}

template <int dim>
FacePoints<dim> Segmentation<dim>::run()
{
  std::vector<BoundingBox<dim>> boxes;
  std::vector<double> sizes;
  for (unsigned int face = 0; face < own.faces.size(); ++face) {
    boxes.push_back(own.shape.box(own.nodes(face)));
    sizes.push_back(own.faces[face].size);
  }
  others = locator.faces_near(boxes, sizes);
  for (current_face = 0; current_face < own.faces.size(); ++current_face)
    add_face(current_face, others.of_box[current_face]);
  return std::move(points);
}

template <int dim>
void Segmentation<dim>::add_face(const unsigned int face, const std::vector<unsigned int> &nearby)
{
  const double offset = std::max(own.shift.norm(), locator.side().shift.norm());
  const Chart<dim> chart(own.shape, bilinear_own, own.nodes(face), own.faces[face].size, offset);
  const double whole = measure(chart.window);
  if (!(whole > 0))
    return;
  std::vector<Segment> segments;
  double covered = 0, largest_distance = 0;
  Region<dim - 1> corners(partner_shape.n_corners());
  for (const unsigned int i : nearby) {
    const NearbyFace &other = others.faces[i];
    for (unsigned int c = 0; c < corners.size(); ++c)
      corners[c] = chart.project(partner_shape.corner(other.nodes.data(), c));
    const Region<dim - 1> of_other = oriented(corners);
    Segment segment;
    segment.region = clip(of_other, chart.window);
    if (segment.region.empty())
      continue;
    const double area = measure(segment.region);
    if (area > chart.negligible * std::min(whole, measure(of_other)) &&
        is_near(chart, segment.region, other, segment)) {
      segments.push_back(segment);
      covered += area;
      largest_distance = std::max(largest_distance, segment.distance);
    }
  }
  // faces that touch this one do not overlap
  if (largest_distance > 1e-9 * own.faces[face].size || covered > whole * (1 + 1e-9)) {
    keep_nearest(chart, segments);
    covered =
        std::accumulate(segments.begin(), segments.end(), 0., [](const double sum, const Segment &segment) {
          return sum + measure(segment.region);
        });
  }
  if (covered < whole * (1 - 2 * chart.negligible))
    add_rest(chart, nearby, segments);
  for (const Segment &segment : segments)
    integrate(chart, segment);
}

template <int dim>
typename FaceLocator<dim>::Match Segmentation<dim>::match(const NearbyFace &partner,
                                                          const typename FaceLocator<dim>::Query &query) const
{
  Match result;
  result.found = true;
  result.rank = partner.rank;
  result.face = partner.index;
  result.set(partner_shape, partner.face_no, partner.size, query,
             partner_shape.closest(partner.nodes.data(), query.X));
  return result;
}

/// Whether the face is opposite to a region of the own face and within reach; then it is the segment's
/// partner.
template <int dim>
bool Segmentation<dim>::is_near(const Chart<dim> &chart, const Region<dim - 1> &region,
                                const NearbyFace &face, Segment &segment)
{
  const SurfacePoint<dim> middle = chart.evaluate(centroid(chart.to_integration(region)));
  const Tensor<1, dim> N = own.shape.normal(own.faces[current_face].face_no, middle);
  const typename FaceLocator<dim>::Query query{middle.X, N / N.norm(), own.faces[current_face].size};
  const Match match = this->match(face, query);
  segment.partner = &face;
  segment.distance = match.distance;
  return locator.is_partner(query, match);
}

template <int dim>
BoundingBox<dim - 1> Segmentation<dim>::box_of(const Region<dim - 1> &region)
{
  return BoundingBox<dim - 1>(region);
}

template <int dim>
std::vector<unsigned int> Segmentation<dim>::overlapping(const Boxes &boxes, const Region<dim - 1> &region)
{
  std::vector<unsigned int> found;
  boxes.query(boost::geometry::index::intersects(box_of(region)),
              boost::make_function_output_iterator(
                  [&](const auto &box_and_index) { found.push_back(box_and_index.second); }));
  std::sort(found.begin(), found.end());
  return found;
}

/// What the segments leave of a region. A region with many of them is halved first, so that the cost is not
/// that of all pairs of parts and segments.
template <int dim>
void Segmentation<dim>::collect_rest(const Region<dim - 1> &region, const Boxes &boxes,
                                     const std::vector<Segment> &segments, std::vector<Region<dim - 1>> &rest)
{
  const std::vector<unsigned int> found = overlapping(boxes, region);
  const auto [lower, upper] = box_of(region).get_boundary_points();
  unsigned int axis = 0;
  for (unsigned int k = 1; k < dim - 1; ++k)
    if (upper[k] - lower[k] > upper[axis] - lower[axis])
      axis = k;
  if (found.size() <= 32 || upper[axis] - lower[axis] < 1e-6) {
    std::vector<Region<dim - 1>> parts = {region};
    for (const unsigned int i : found)
      parts = subtract_from_all(parts, segments[i].region);
    rest.insert(rest.end(), parts.begin(), parts.end());
    return;
  }
  for (const unsigned int half : {0, 1}) {
    Point<dim - 1> from = lower, to = upper;
    (half == 0 ? to : from)[axis] = (lower[axis] + upper[axis]) / 2;
    const auto part = clip(region, box_region(from, to));
    if (!part.empty())
      collect_rest(part, boxes, segments, rest);
  }
}

/// Where regions overlap the nearest face wins, and of equally near ones the first.
template <int dim>
void Segmentation<dim>::keep_nearest(const Chart<dim> &chart, std::vector<Segment> &segments) const
{
  std::stable_sort(segments.begin(), segments.end(), [&](const Segment &one, const Segment &other) {
    const double quantum = distance_quantum(own.faces[current_face].size);
    return std::nearbyint(one.distance / quantum) < std::nearbyint(other.distance / quantum);
  });
  std::vector<Segment> result;
  Boxes boxes;
  for (const Segment &segment : segments) {
    std::vector<Region<dim - 1>> parts = {segment.region};
    for (const unsigned int i : overlapping(boxes, segment.region))
      parts = subtract_from_all(parts, result[i].region);
    const double least = chart.negligible * measure(segment.region);
    for (const auto &part : parts)
      if (measure(part) > least) {
        boxes.insert({box_of(part), static_cast<unsigned int>(result.size())});
        result.push_back({part, segment.partner, segment.distance});
      }
  }
  segments = result;
}

/// What no face covers in projection is given to the closest face if that is no farther off sideways than
/// along the normal (the rim of a gapped, curved interface) or than 1e-6 of its size; else it has no partner.
template <int dim>
void Segmentation<dim>::add_rest(const Chart<dim> &chart, const std::vector<unsigned int> &nearby,
                                 std::vector<Segment> &segments)
{
  Boxes boxes;
  for (unsigned int i = 0; i < segments.size(); ++i)
    boxes.insert({box_of(segments[i].region), i});
  std::vector<Region<dim - 1>> rest;
  collect_rest(chart.window, boxes, segments, rest);
  std::vector<std::pair<BoundingBox<dim>, unsigned int>> faces_with_boxes;
  for (const unsigned int i : nearby)
    faces_with_boxes.emplace_back(partner_shape.box(others.faces[i].nodes.data()), i);
  const auto face_boxes = pack_rtree(faces_with_boxes);
  std::vector<unsigned int> closest;
  const double least = chart.negligible * measure(chart.window);
  for (const auto &part : rest)
    if (measure(part) > least) {
      Segment best{part, nullptr, std::numeric_limits<double>::infinity(), false};
      closest.clear();
      face_boxes.query(
          boost::geometry::index::nearest(chart.evaluate(centroid(chart.to_integration(part))).X, 8),
          boost::make_function_output_iterator(
              [&](const auto &box_and_face) { closest.push_back(box_and_face.second); }));
      std::sort(closest.begin(), closest.end(), [&](const unsigned int i, const unsigned int j) {
        return others.faces[i].key < others.faces[j].key;
      });
      for (const unsigned int i : closest) {
        Segment candidate = best;
        candidate.is_tied = is_near(chart, part, others.faces[i], candidate);
        if (std::make_pair(!candidate.is_tied, candidate.distance) <
            std::make_pair(!best.is_tied, best.distance))
          best = candidate;
      }
      segments.push_back(best);
    }
}

/// Whether the edges of a quadrilateral region are along those of both affine faces: then shape functions
/// are polynomials of their degree in each of its directions.
template <int dim>
bool Segmentation<dim>::is_aligned_box(const Chart<dim> &chart, const Region<dim - 1> &region,
                                       const NearbyFace &partner) const
{
  if constexpr (dim == 3) {
    if (region.size() != 4 || own.shape.is_triangle() || partner_shape.is_triangle() || !chart.is_affine ||
        !partner_shape.is_affine(partner.nodes.data()))
      return false;
    const auto are_parallel = [](const Tensor<1, 2> &a, const Tensor<1, 2> &b) {
      return std::abs(a[0] * b[1] - a[1] * b[0]) <= 1e-12 * a.norm() * b.norm();
    };
    const Tensor<1, 2> u = region[1] - region[0], v = region[3] - region[0];
    const auto has_edges_along = [&](const Tensor<1, 2> &a, const Tensor<1, 2> &b) {
      return (are_parallel(u, a) && are_parallel(v, b)) || (are_parallel(u, b) && are_parallel(v, a));
    };
    const auto corner = [&](const unsigned int i) {
      return chart.project(partner_shape.corner(partner.nodes.data(), i));
    };
    return are_parallel(region[2] - region[3], u) && are_parallel(region[2] - region[1], v) &&
           has_edges_along(chart.window[1] - chart.window[0], chart.window[3] - chart.window[0]) &&
           has_edges_along(corner(1) - corner(0), corner(3) - corner(0));
  }
  return false;
}

template <int dim>
void Segmentation<dim>::integrate(const Chart<dim> &chart, const Segment &segment)
{
  if (segment.is_tied)
    ++points.n_segments;
  const Region<dim - 1> region = chart.to_integration(segment.region);
  if (measure(region) <= 0) // of a strongly distorted curved face
    return;
  const bool is_affine =
      chart.is_affine && segment.partner != nullptr && partner_shape.is_affine(segment.partner->nodes.data());
  // rational integrands converge fast with the degree; in 3D every point costs memory
  const unsigned int mapping_degree = std::max(own.shape.degree(), partner_shape.degree());
  const unsigned int more = is_affine ? 0 : dim == 2 ? 2 * mapping_degree : chart.is_flat ? 4 : 2;
  if constexpr (dim == 2)
    add_piece(chart, region, rules.simplex(2 * degree + 1 + more), segment);
  else if (segment.is_tied && is_aligned_box(chart, segment.region, *segment.partner))
    add_piece(chart, {region[0], region[1], region[3], region[2]}, QGauss<2>(degree + 1), segment);
  else {
    const auto &rule = rules.simplex(2 * degree * (has_quadrilaterals ? 2 : 1) + more);
    if (region.size() == 3)
      return add_piece(chart, region, rule, segment);
    const Point<2> centre = centroid(region);
    for (unsigned int i = 0; i < region.size(); ++i)
      add_piece(chart, {centre, region[i], region[(i + 1) % region.size()]}, rule, segment);
  }
}

template <int dim>
void Segmentation<dim>::add_piece(const Chart<dim> &chart, const std::vector<Point<dim - 1>> &corners,
                                  const Quadrature<dim - 1> &rule, const Segment &segment)
{
  // corners of a line, triangle or parallelogram
  std::array<Tensor<1, dim - 1>, dim - 1> edge;
  for (unsigned int k = 0; k < dim - 1; ++k)
    edge[k] = corners[k + 1] - corners[0];
  double determinant = edge[0][0];
  if constexpr (dim == 3)
    determinant = edge[0][0] * edge[1][1] - edge[0][1] * edge[1][0];
  if (determinant <= 0)
    return;

  typename FacePoints<dim>::Piece piece;
  piece.begin = points.size();
  piece.end = piece.begin + rule.size();
  piece.n_vertices = 0;
  for (const auto &corner : corners)
    piece.vertices[piece.n_vertices++] = chart.evaluate(corner).X;
  points.pieces.push_back(piece);
  for (unsigned int q = 0; q < rule.size(); ++q) {
    Point<dim - 1> s = corners[0];
    for (unsigned int k = 0; k < dim - 1; ++k)
      s += rule.point(q)[k] * edge[k];
    const SurfacePoint<dim> point = chart.evaluate(s);
    points.add(own, current_face, point, rule.weight(q) * determinant * chart.jacobian(point));
    points.matches.push_back(segment.partner != nullptr ? match(*segment.partner, points.queries.back())
                                                        : Match());
    points.matches.back().found = segment.is_tied;
  }
}

} // namespace

template <int dim>
FacePoints<dim> segments(const SideFaces<dim> &own, const FaceLocator<dim> &partner,
                         const unsigned int own_degree, const unsigned int partner_degree)
{
  return Segmentation<dim>(own, partner, own_degree, partner_degree).run();
}

template FacePoints<2> segments(const SideFaces<2> &, const FaceLocator<2> &, unsigned int, unsigned int);
template FacePoints<3> segments(const SideFaces<3> &, const FaceLocator<3> &, unsigned int, unsigned int);

} // namespace dovetail
