// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Faces of the other side are projected to the chart of the own face, where they are clipped: as polygons or,
// where that is not exact in 3D, as regions with curved edges.

#include <dovetail/domain/quadrature.h>
#include <dovetail/pairing/chart.h>
#include <dovetail/pairing/face_points.h>
#include <dovetail/pairing/region.h>

#include <deal.II/numerics/rtree.h>

#include <boost/iterator/function_output_iterator.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace dovetail {

using namespace dealii;

namespace {

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
    const auto known = rules_of_degree.find(degree);
    if (known != rules_of_degree.end())
      return known->second;
    return rules_of_degree.emplace(degree, make(degree)).first->second;
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

  std::map<unsigned int, Quadrature<structdim>> rules_of_degree;
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
    bool is_tied = true, is_rest = false;
  };

  /// The same with curved edges, in 3D.
  struct CurvedSegment
  {
    CurvedRegion region;
    Segment tied;
  };

  using FaceBoxes = RTree<std::pair<BoundingBox<dim>, unsigned int>>; ///< of faces of the other side
  using Boxes = RTree<std::pair<BoundingBox<dim - 1>, unsigned int>>; ///< of regions
  static BoundingBox<dim - 1> box_of(const Region<dim - 1> &region);
  static std::vector<unsigned int> overlapping(const Boxes &boxes, const Region<dim - 1> &region);
  static std::vector<Region<dim - 1>> rest_of(const Region<dim - 1> &region,
                                              const std::vector<Segment> &segments);
  static void collect_rest(const Region<dim - 1> &region, const Boxes &boxes,
                           const std::vector<Segment> &segments, std::vector<Region<dim - 1>> &rest);

  void add_face(unsigned int face, const std::vector<unsigned int> &nearby);
  bool is_near(const SurfacePoint<dim> &middle, const NearbyFace &face, Segment &segment) const;
  Segment nearest_face(const SurfacePoint<dim> &middle, const FaceBoxes &face_boxes) const;
  bool needs_rim_tolerance(const SurfacePoint<dim> &middle, const NearbyFace &face) const;
  typename FaceLocator<dim>::Query query_at(const SurfacePoint<dim> &point) const;
  bool is_coplanar(const Chart<dim> &chart, const NearbyFace &face) const;
  bool has_curves(const Chart<dim> &chart, const std::vector<unsigned int> &nearby,
                  const std::vector<Segment> &segments) const;
  bool add_curved_face(const Chart<dim> &chart, const std::vector<unsigned int> &nearby);
  void add_curved_rest(CurvedWindow &window, const std::vector<CurvedSegment> &segments, double area,
                       const FaceBoxes &face_boxes);
  void add_reference_region(const Region<dim - 1> &region, const FaceBoxes &face_boxes);
  FaceBoxes boxes_of(const std::vector<unsigned int> &nearby) const;
  double area_of_current_face() const;
  void integrate(const Chart<dim> &chart, CurvedWindow &window, const CurvedSegment &segment);
  void keep_nearest(const Chart<dim> &chart, std::vector<Segment> &segments) const;
  void add_rest(const Chart<dim> &chart, const std::vector<unsigned int> &nearby,
                std::vector<Segment> &segments);
  void integrate(const Chart<dim> &chart, const Segment &segment);
  bool is_aligned_box(const Chart<dim> &chart, const Region<dim - 1> &region,
                      const NearbyFace &partner) const;
  void add_piece(const Chart<dim> &chart, const std::vector<Point<dim - 1>> &corners,
                 const Quadrature<dim - 1> &rule, const Segment &segment);
  void add_point(const SurfacePoint<dim> &point, double JxW, const Segment &segment);
  void add_piece_of_rest(const Chart<dim> &chart, const std::vector<Point<dim - 1>> &corners,
                         const Point<dim - 1> &s, double share, double weight);
  void begin_piece(const std::vector<Point<dim>> &vertices, unsigned int n_points);
  bool is_affine(const Chart<dim> &chart, const Segment &segment) const;
  unsigned int degree_of_rule(const Chart<dim> &chart, const Segment &segment) const;
  Match match(const NearbyFace &partner, const typename FaceLocator<dim>::Query &query) const;

  const SideFaces<dim> &own;
  const FaceLocator<dim> &locator;
  const FaceShape<dim> &partner_shape;
  const FaceShape<dim> bilinear_own;
  const Interpolation edges_of_partner;
  const unsigned int degree; ///< of the elements, the larger one
  const bool has_quadrilaterals;
  typename FaceLocator<dim>::NearbyFaces others;
  FaceBoxes boxes_of_rest; ///< of the faces near the current one, if it has a rest
  Rules<dim - 1> rules;
  unsigned int current_face = 0;
  FacePoints<dim> points;
};

template <int dim>
Segmentation<dim>::Segmentation(const SideFaces<dim> &own, const FaceLocator<dim> &partner,
                                const unsigned int own_degree, const unsigned int partner_degree)
    : own(own), locator(partner), partner_shape(partner.side().shape), bilinear_own(own.shape.cell(), 1),
      edges_of_partner(partner_shape.degree()), degree(std::max(own_degree, partner_degree)),
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
    add_face(current_face, others.faces_in_box[current_face]);
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
    const Region<dim - 1> other_region = oriented(corners);
    Segment segment;
    segment.region = clip(other_region, chart.window);
    if (segment.region.empty())
      continue;
    const double area = measure(segment.region);
    if (area > chart.negligible * std::min(whole, measure(other_region)) &&
        is_near(chart.evaluate(centroid(chart.to_integration(segment.region))), other, segment)) {
      segments.push_back(segment);
      covered += area;
      largest_distance = std::max(largest_distance, segment.distance);
    }
  }
  // faces that touch this one do not overlap
  bool have_overlap = false;
  if (largest_distance > 1e-9 * own.faces[face].size || covered > whole * (1 + 1e-9)) {
    const double before = covered;
    keep_nearest(chart, segments);
    covered =
        std::accumulate(segments.begin(), segments.end(), 0., [](const double sum, const Segment &segment) {
          return sum + measure(segment.region);
        });
    have_overlap = before - covered > 1e-9 * whole;
  }
  if (!have_overlap && has_curves(chart, nearby, segments) && add_curved_face(chart, nearby))
    return;
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
  result.face_size = partner.size;
  result.rim_tolerance = partner.rim_tolerance;
  result.set(partner_shape, partner.face_no, query, partner_shape.closest(partner.nodes.data(), query.X));
  return result;
}

template <int dim>
typename FaceLocator<dim>::Query Segmentation<dim>::query_at(const SurfacePoint<dim> &point) const
{
  const Tensor<1, dim> N = own.shape.normal(own.faces[current_face].face_no, point);
  return {point.X, N / N.norm(), own.faces[current_face].size};
}

/// Whether a face of the other side is opposite to a point of the own face and within reach; then it is the
/// segment's partner.
template <int dim>
bool Segmentation<dim>::is_near(const SurfacePoint<dim> &middle, const NearbyFace &face,
                                Segment &segment) const
{
  const auto query = query_at(middle);
  const Match match = this->match(face, query);
  segment.partner = &face;
  segment.distance = match.distance;
  return locator.is_partner(query, match);
}

/// Whether a face is a partner only because two curved rims approximate one curve.
template <int dim>
bool Segmentation<dim>::needs_rim_tolerance(const SurfacePoint<dim> &middle, const NearbyFace &face) const
{
  const auto query = query_at(middle);
  Match match = this->match(face, query);
  match.rim_tolerance = 0;
  return !locator.is_partner(query, match);
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

/// What the segments leave of a region.
template <int dim>
std::vector<Region<dim - 1>> Segmentation<dim>::rest_of(const Region<dim - 1> &region,
                                                        const std::vector<Segment> &segments)
{
  Boxes boxes;
  for (unsigned int i = 0; i < segments.size(); ++i)
    boxes.insert({box_of(segments[i].region), i});
  std::vector<Region<dim - 1>> rest;
  collect_rest(region, boxes, segments, rest);
  return rest;
}

/// A region with many segments is halved first, so that the cost is not that of all pairs of parts and
/// segments.
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
  boxes_of_rest = boxes_of(nearby);
  const double least = chart.negligible * measure(chart.window);
  for (const auto &part : rest_of(chart.window, segments))
    if (measure(part) > least) {
      segments.push_back(nearest_face(chart.evaluate(centroid(chart.to_integration(part))), boxes_of_rest));
      segments.back().region = part;
      segments.back().is_rest = true;
    }
}

template <int dim>
typename Segmentation<dim>::FaceBoxes
Segmentation<dim>::boxes_of(const std::vector<unsigned int> &nearby) const
{
  std::vector<std::pair<BoundingBox<dim>, unsigned int>> faces_with_boxes;
  for (const unsigned int i : nearby)
    faces_with_boxes.emplace_back(partner_shape.box(others.faces[i].nodes.data()), i);
  return pack_rtree(faces_with_boxes);
}

/// The nearest one that is a partner of a point of the own face, or else the nearest one.
template <int dim>
typename Segmentation<dim>::Segment Segmentation<dim>::nearest_face(const SurfacePoint<dim> &middle,
                                                                    const FaceBoxes &face_boxes) const
{
  Segment best{{}, nullptr, std::numeric_limits<double>::infinity(), false};
  std::vector<unsigned int> closest;
  face_boxes.query(boost::geometry::index::nearest(middle.X, 8),
                   boost::make_function_output_iterator(
                       [&](const auto &box_and_face) { closest.push_back(box_and_face.second); }));
  std::sort(closest.begin(), closest.end(), [&](const unsigned int i, const unsigned int j) {
    return others.faces[i].key < others.faces[j].key;
  });
  for (const unsigned int i : closest) {
    Segment candidate = best;
    candidate.is_tied = is_near(middle, others.faces[i], candidate);
    if (std::make_pair(!candidate.is_tied, candidate.distance) < std::make_pair(!best.is_tied, best.distance))
      best = candidate;
  }
  return best;
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

/// Whether products of shape functions are polynomials on a segment.
template <int dim>
bool Segmentation<dim>::is_affine(const Chart<dim> &chart, const Segment &segment) const
{
  return chart.is_affine && segment.partner != nullptr &&
         partner_shape.is_affine(segment.partner->nodes.data());
}

/// Exact for products of shape functions where both faces are affine. Rational integrands converge fast with
/// the degree; in 3D every point costs memory. Points without partner only count for the area.
template <int dim>
unsigned int Segmentation<dim>::degree_of_rule(const Chart<dim> &chart, const Segment &segment) const
{
  const bool is_affine = this->is_affine(chart, segment);
  if (dim == 2)
    return 2 * degree + 1 + (is_affine ? 0 : 2 * std::max(own.shape.degree(), partner_shape.degree()));
  if (!segment.is_tied)
    return chart.is_flat ? 1 : 2 * own.shape.degree();
  return 2 * degree * (has_quadrilaterals ? 2 : 1) + (is_affine ? 0 : chart.is_flat ? 4 : 2);
}

template <int dim>
void Segmentation<dim>::integrate(const Chart<dim> &chart, const Segment &segment)
{
  if (segment.is_tied)
    ++points.n_segments;
  const Region<dim - 1> region = chart.to_integration(segment.region);
  if (measure(region) <= 0) // of a strongly distorted curved face
    return;
  if constexpr (dim == 2)
    add_piece(chart, region, rules.simplex(degree_of_rule(chart, segment)), segment);
  else if (segment.is_tied && is_aligned_box(chart, segment.region, *segment.partner))
    add_piece(chart, {region[0], region[1], region[3], region[2]}, QGauss<2>(degree + 1), segment);
  else {
    const auto &rule = rules.simplex(degree_of_rule(chart, segment));
    if (region.size() == 3)
      return add_piece(chart, region, rule, segment);
    if (!segment.is_tied || is_affine(chart, segment)) {
      for (unsigned int i = 1; i + 1 < region.size(); ++i)
        add_piece(chart, {region[0], region[i], region[i + 1]}, rule, segment);
      return;
    }
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
  if (determinant == 0) // negative: what a fan that leaves the region takes back
    return;

  const bool is_tied_rest = segment.is_tied && segment.is_rest;
  std::vector<Point<dim>> vertices;
  for (const auto &corner : corners)
    vertices.push_back(chart.evaluate(corner).X);
  if (!is_tied_rest)
    begin_piece(vertices, rule.size());
  for (unsigned int q = 0; q < rule.size(); ++q) {
    Point<dim - 1> s = corners[0];
    for (unsigned int k = 0; k < dim - 1; ++k)
      s += rule.point(q)[k] * edge[k];
    const double weight = rule.weight(q) * determinant;
    if (is_tied_rest)
      add_piece_of_rest(chart, corners, s, rule.weight(q) * (dim == 3 ? 2 : 1), weight);
    else {
      const SurfacePoint<dim> point = chart.evaluate(s);
      add_point(point, weight * chart.jacobian(point), segment);
    }
  }
}

/// A rest may be a sliver along several faces of the other side: each point has the nearest one.
/// @param share of the area of the corners, those of a line or triangle, that the point has
template <int dim>
void Segmentation<dim>::add_piece_of_rest(const Chart<dim> &chart, const std::vector<Point<dim - 1>> &corners,
                                          const Point<dim - 1> &s, const double share, const double weight)
{
  Point<dim - 1> centre;
  for (const auto &corner : corners)
    centre += (1. / corners.size()) * (corner - Point<dim - 1>());
  std::vector<Point<dim>> vertices;
  for (const auto &corner : corners)
    vertices.push_back(chart.evaluate(s + (dim == 3 ? std::sqrt(share) : share) * (corner - centre)).X);
  begin_piece(vertices, 1);
  const SurfacePoint<dim> point = chart.evaluate(s);
  Segment nearest = nearest_face(point, boxes_of_rest);
  nearest.is_tied = true;
  add_point(point, weight * chart.jacobian(point), nearest);
}

template <int dim>
void Segmentation<dim>::begin_piece(const std::vector<Point<dim>> &vertices, const unsigned int n_points)
{
  typename FacePoints<dim>::Piece piece;
  piece.begin = points.size();
  piece.end = piece.begin + n_points;
  piece.n_vertices = vertices.size();
  std::copy(vertices.begin(), vertices.end(), piece.vertices.begin());
  points.pieces.push_back(piece);
}

template <int dim>
void Segmentation<dim>::add_point(const SurfacePoint<dim> &point, const double JxW, const Segment &segment)
{
  points.add(own, current_face, point, JxW);
  points.matches.push_back(segment.partner != nullptr ? match(*segment.partner, points.queries.back())
                                                      : Match());
  points.matches.back().found = segment.is_tied;
}

/// Whether the nodes of a face of the other side lie in the plane of the own face.
template <int dim>
bool Segmentation<dim>::is_coplanar(const Chart<dim> &chart, const NearbyFace &face) const
{
  return std::all_of(face.nodes.begin(), face.nodes.end(),
                     [&](const Point<dim> &X) { return chart.is_in_plane(X); });
}

/// Whether polygons would not do although all is plane: the own face is not flat, or edges are not straight.
template <int dim>
bool Segmentation<dim>::has_curves(const Chart<dim> &chart, const std::vector<unsigned int> &nearby,
                                   const std::vector<Segment> &segments) const
{
  if constexpr (dim == 3) {
    if (chart.is_flat && partner_shape.degree() == 1)
      return false;
    for (unsigned int a = 0; a < own.shape.n_nodes(); ++a)
      if (!chart.is_in_plane(own.nodes(current_face)[a]))
        return false;
    if (std::any_of(segments.begin(), segments.end(),
                    [&](const Segment &segment) { return !is_coplanar(chart, *segment.partner); }))
      return false;
    if (!chart.is_flat)
      return true;
    const CurvedWindow window(chart);
    for (const unsigned int i : nearby)
      if (is_coplanar(chart, others.faces[i]))
        for (const Arc &arc : window.project(partner_shape, others.faces[i].nodes.data(), edges_of_partner))
          if (arc.degree > 1)
            return true;
  }
  return false;
}

/// The segments of a face with curved edges. @return false, and nothing is added, if that cannot be done.
template <int dim>
bool Segmentation<dim>::add_curved_face(const Chart<dim> &chart, const std::vector<unsigned int> &nearby)
{
  if constexpr (dim == 3) {
    CurvedWindow window(chart);
    std::vector<CurvedSegment> segments;
    double covered = 0;
    for (const unsigned int i : nearby) {
      const NearbyFace &other = others.faces[i];
      if (!is_coplanar(chart, other))
        continue;
      CurvedSegment segment;
      segment.region = window.clip(window.project(partner_shape, other.nodes.data(), edges_of_partner));
      if (window.has_failed())
        return false;
      if (segment.region.size() < 2)
        continue;
      const double area = window.measure(segment.region);
      if (area > chart.negligible * window.measure() &&
          is_near(chart.evaluate(window.centroid(segment.region)), other, segment.tied)) {
        segments.push_back(segment);
        covered += area;
      }
    }
    if (window.has_failed() || covered > window.measure() * (1 + 1e-6))
      return false;
    const unsigned int first = points.size();
    for (const CurvedSegment &segment : segments)
      integrate(chart, window, segment);
    const double area = area_of_current_face();
    const double rest = area - std::accumulate(points.JxW.begin() + first, points.JxW.end(), 0.);
    if (rest > 1e-9 * area)
      add_curved_rest(window, segments, rest, boxes_of(nearby));
  }
  return dim == 3;
}

/// A fan X = C + u (c(v) - C) with an arc c(v) about the centroid, or about a corner of a polygon whose faces
/// are affine: Gauss points for u and v, or those of a triangle where the arc is straight.
template <int dim>
void Segmentation<dim>::integrate(const Chart<dim> &chart, CurvedWindow &window, const CurvedSegment &segment)
{
  if constexpr (dim == 3) {
    ++points.n_segments;
    const unsigned int degree = degree_of_rule(chart, segment.tied);
    const auto is_straight = [&](const Arc &arc) { return window.is_straight(arc); };
    const bool is_polygon = is_affine(chart, segment.tied) &&
                            std::all_of(segment.region.begin(), segment.region.end(), is_straight);
    const Arc &first = segment.region.front();
    const Point<2> centre =
        is_polygon ? window.evaluate(first, first.begin).s : window.centroid(segment.region);
    for (const Arc &arc : segment.region) {
      const Point<2> from = window.evaluate(arc, arc.begin).s, to = window.evaluate(arc, arc.end).s;
      if (is_polygon && std::min(from.distance(centre), to.distance(centre)) < 1e-13)
        continue;
      if (is_polygon || is_straight(arc)) {
        add_piece(chart, {centre, from, to}, rules.simplex(degree), segment.tied);
        continue;
      }
      const QGauss<1> along(degree / 2 + 1 + arc.degree), across(degree / 2 + 1);
      begin_piece({chart.evaluate(centre).X, chart.evaluate(from).X, chart.evaluate(to).X},
                  along.size() * across.size());
      for (unsigned int i = 0; i < along.size(); ++i) {
        const auto end = window.evaluate(arc, arc.begin + (arc.end - arc.begin) * along.point(i)[0]);
        const Tensor<1, 2> r = end.s - centre;
        const double weight =
            along.weight(i) * (arc.end - arc.begin) * (r[0] * end.derivative[1] - r[1] * end.derivative[0]);
        for (unsigned int j = 0; j < across.size(); ++j) {
          const double u = across.point(j)[0];
          const SurfacePoint<dim> point = chart.evaluate(centre + u * r);
          add_point(point, across.weight(j) * u * weight * chart.jacobian(point), segment.tied);
        }
      }
    }
  }
}

/// What the segments leave of the face, @p area, goes to the nearest faces or is not tied. It is cut into
/// polygons in reference coordinates, with points on the curves as corners, and their weights are scaled so
/// that their sum is exact.
template <int dim>
void Segmentation<dim>::add_curved_rest(CurvedWindow &window, const std::vector<CurvedSegment> &segments,
                                        const double area, const FaceBoxes &face_boxes)
{
  if constexpr (dim == 3) {
    std::vector<Segment> triangles;
    for (const CurvedSegment &segment : segments) {
      const Point<2> centre = window.reference_point(window.centroid(segment.region));
      for (const Arc &arc : segment.region) {
        const std::vector<Point<2>> corners = window.reference_points(arc);
        for (unsigned int i = 0; i + 1 < corners.size(); ++i) {
          Segment triangle;
          triangle.region = {centre, corners[i], corners[i + 1]};
          if (measure(triangle.region) > 1e-14)
            triangles.push_back(triangle);
        }
      }
    }
    const unsigned int first = points.size();
    for (const Region<2> &part : rest_of(window.reference_corners(), triangles))
      if (measure(part) > 1e-10)
        add_reference_region(part, face_boxes);
    const double sum = std::accumulate(points.JxW.begin() + first, points.JxW.end(), 0.);
    for (unsigned int q = first; q < points.size(); ++q)
      points.JxW[q] *= area / sum;
  }
}

/// A convex region in reference coordinates of the face.
template <int dim>
void Segmentation<dim>::add_reference_region(const Region<dim - 1> &region, const FaceBoxes &face_boxes)
{
  if constexpr (dim == 3) {
    const Point<dim> *nodes = own.nodes(current_face);
    const Point<2> centre = centroid(region);
    Segment segment = nearest_face(own.shape.evaluate(nodes, centre), face_boxes);
    if (segment.is_tied && needs_rim_tolerance(own.shape.evaluate(nodes, centre), *segment.partner))
      for (const Point<2> &corner : region) // a strip of a face that goes on beyond the rim is none
        segment.is_tied =
            segment.is_tied && nearest_face(own.shape.evaluate(nodes, corner), face_boxes).is_tied;
    const auto &rule = rules.simplex(segment.is_tied ? 2 * degree + 2 : 2 * own.shape.degree());
    for (unsigned int i = 1; i + 1 < region.size(); ++i) {
      const Tensor<1, 2> a = region[i] - region[0], b = region[i + 1] - region[0];
      begin_piece({own.shape.evaluate(nodes, region[0]).X, own.shape.evaluate(nodes, region[i]).X,
                   own.shape.evaluate(nodes, region[i + 1]).X},
                  rule.size());
      for (unsigned int q = 0; q < rule.size(); ++q) {
        const SurfacePoint<dim> point =
            own.shape.evaluate(nodes, region[0] + rule.point(q)[0] * a + rule.point(q)[1] * b);
        add_point(point,
                  rule.weight(q) * (a[0] * b[1] - a[1] * b[0]) *
                      cross_product_3d(point.tangent[0], point.tangent[1]).norm(),
                  segment);
      }
    }
  }
}

/// By the rule of Gauss that is exact where the face is flat.
template <int dim>
double Segmentation<dim>::area_of_current_face() const
{
  const auto rule = gauss_rule<dim - 1>(own.shape.is_triangle() ? ReferenceCells::Triangle
                                                                : ReferenceCells::get_hypercube<dim - 1>(),
                                        own.shape.degree() + 3);
  double area = 0;
  for (unsigned int q = 0; q < rule.size(); ++q)
    area += rule.weight(q) * own.shape
                                 .normal(own.faces[current_face].face_no,
                                         own.shape.evaluate(own.nodes(current_face), rule.point(q)))
                                 .norm();
  return area;
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
