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
  Chart(const FaceShape<dim> &shape, const FaceShape<dim> &bilinear, const Point<dim> *nodes, double size);

  Region<dim - 1> window;                 ///< the face itself
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

  const FaceShape<dim> &shape, &bilinear;
  const Point<dim> *nodes;
  double size;
  Point<dim> origin;
  std::array<Tensor<1, dim>, dim - 1> axis;
  Tensor<2, dim - 1> inverse; ///< dxi / ds of an affine face
};

template <int dim>
Chart<dim>::Chart(const FaceShape<dim> &shape, const FaceShape<dim> &bilinear, const Point<dim> *nodes,
                  const double size)
    : is_flat(shape.is_flat(nodes)), is_affine(is_flat && shape.is_affine(nodes)), shape(shape),
      bilinear(bilinear), nodes(nodes), size(size)
{
  origin = shape.corner(nodes, 0);
  negligible = is_flat ? std::max(1e-13, 4e-15 * origin.norm() / size) : 1e-11;
  const unsigned int n = shape.n_corners();
  if constexpr (dim == 2) {
    axis[0] = shape.corner(nodes, 1) - origin;
    window = {Point<1>(0.), Point<1>(1.)};
  } else {
    const Tensor<1, dim> N = n == 3 ? cross_product_3d(nodes[1] - nodes[0], nodes[2] - nodes[0])
                                    : cross_product_3d(shape.corner(nodes, 2) - origin,
                                                       shape.corner(nodes, 3) - shape.corner(nodes, 1));
    axis[0] = shape.corner(nodes, 1) - origin;
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
  for (const auto &corner : region)
    result.push_back(xi_of(corner));
  return result;
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
    const NearbyFace *partner; ///< nullptr: none
    double distance;           ///< at the centroid
  };

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
                 const Quadrature<dim - 1> &rule, const NearbyFace *partner);
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
  for (unsigned int face = 0; face < own.faces.size(); ++face)
    boxes.push_back(own.shape.box(own.nodes(face)));
  others = locator.faces_near(boxes);
  for (current_face = 0; current_face < own.faces.size(); ++current_face)
    add_face(current_face, others.of_box[current_face]);
  return std::move(points);
}

template <int dim>
void Segmentation<dim>::add_face(const unsigned int face, const std::vector<unsigned int> &nearby)
{
  const Chart<dim> chart(own.shape, bilinear_own, own.nodes(face), own.faces[face].size);
  const double whole = measure(chart.window);
  std::vector<Segment> segments;
  double covered = 0;
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
    }
  }
  if (covered > whole * (1 + 1e-9)) {
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
  const typename FaceLocator<dim>::Query query{middle.X, N / N.norm()};
  const Match match = this->match(face, query);
  segment.partner = &face;
  segment.distance = match.distance;
  return locator.is_partner(query, match);
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
  for (const Segment &segment : segments) {
    std::vector<Region<dim - 1>> parts = {segment.region};
    for (const Segment &nearer : result) {
      std::vector<Region<dim - 1>> left;
      for (const auto &part : parts)
        for (const auto &outside : subtract(part, nearer.region))
          left.push_back(outside);
      parts = left;
    }
    const double least = chart.negligible * measure(segment.region);
    for (const auto &part : parts)
      if (measure(part) > least)
        result.push_back({part, segment.partner, segment.distance});
  }
  segments = result;
}

/// What no face covers in projection is given to the closest face if that is no farther off sideways than
/// along the normal (the rim of a gapped, curved interface) or than 1e-6 of its size; else it has no partner.
template <int dim>
void Segmentation<dim>::add_rest(const Chart<dim> &chart, const std::vector<unsigned int> &nearby,
                                 std::vector<Segment> &segments)
{
  std::vector<Region<dim - 1>> rest = {chart.window};
  for (const Segment &segment : segments) {
    std::vector<Region<dim - 1>> left;
    for (const auto &part : rest)
      for (const auto &outside : subtract(part, segment.region))
        left.push_back(outside);
    rest = left;
  }
  const double least = chart.negligible * measure(chart.window);
  for (const auto &part : rest)
    if (measure(part) > least) {
      Segment best{part, nullptr, std::numeric_limits<double>::infinity()};
      for (const unsigned int i : nearby) {
        Segment candidate = best;
        if (is_near(chart, part, others.faces[i], candidate) && candidate.distance < best.distance)
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
  if (segment.partner != nullptr)
    ++points.n_segments;
  const Region<dim - 1> region = chart.to_integration(segment.region);
  if (measure(region) <= 0) // of a strongly distorted curved face
    return;
  const bool is_affine =
      chart.is_affine && segment.partner != nullptr && partner_shape.is_affine(segment.partner->nodes.data());
  // rational integrands converge fast with the degree; in 3D every point costs memory
  const unsigned int mapping_degree = std::max(own.shape.degree(), partner_shape.degree());
  const unsigned int more = is_affine ? 0 : dim == 2 ? 2 * mapping_degree : 2;
  if constexpr (dim == 2)
    add_piece(chart, region, rules.simplex(2 * degree + 1 + more), segment.partner);
  else if (segment.partner != nullptr && is_aligned_box(chart, segment.region, *segment.partner))
    add_piece(chart, {region[0], region[1], region[3], region[2]}, QGauss<2>(degree + 1), segment.partner);
  else {
    const auto &rule = rules.simplex(2 * degree * (has_quadrilaterals ? 2 : 1) + more);
    if (region.size() == 3)
      return add_piece(chart, region, rule, segment.partner);
    const Point<2> centre = centroid(region);
    for (unsigned int i = 0; i < region.size(); ++i)
      add_piece(chart, {centre, region[i], region[(i + 1) % region.size()]}, rule, segment.partner);
  }
}

template <int dim>
void Segmentation<dim>::add_piece(const Chart<dim> &chart, const std::vector<Point<dim - 1>> &corners,
                                  const Quadrature<dim - 1> &rule, const NearbyFace *partner)
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
    points.add(own.shape, current_face, own.faces[current_face].face_no, point,
               rule.weight(q) * determinant * chart.jacobian(point));
    points.matches.push_back(partner != nullptr ? match(*partner, points.queries.back()) : Match());
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
