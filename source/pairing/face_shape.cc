// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The closest point of a face solves  min 1/2 |X(xi) - Y|^2  over the reference face,  X(xi) = sum_a
// phi_a(xi) X_a. With r = X - Y the gradient is g_k = r.X_,k and the Hessian H_kl = X_,k.X_,l + r.X_,kl.
// Each Newton step minimises the quadratic model over the box or the triangle of xi exactly, so that on a
// flat parallelogram or triangle the first step arrives, also at its rim.

#include <dovetail/pairing/face_shape.h>

#include <deal.II/base/exceptions.h>
#include <deal.II/base/geometry_info.h>
#include <deal.II/base/quadrature_lib.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

using namespace dealii;

namespace {

/// Position relative to the query point, tangents and second derivatives of a face, at one of its points. The
/// second derivatives are those by (0,0), (0,1), (1,1); in 2D only the first.
template <int dim>
struct Jet
{
  Tensor<1, dim> r;
  std::array<Tensor<1, dim>, dim - 1> tangent;
  std::array<Tensor<1, dim>, dim *(dim - 1) / 2> second;
};

/// A face of a mapping of degree 1, as seen from a point: r = a + b xi_0 (+ c xi_1 + d xi_0 xi_1). Everything
/// is relative to that point, so rounding is relative to the face and not to the distance from the origin.
template <int dim>
class LinearSurface
{
public:
  LinearSurface(const Point<dim> *nodes, const Point<dim> &Y) : a(nodes[0] - Y), b(nodes[1] - nodes[0])
  {
    if constexpr (dim == 3) {
      c = nodes[2] - nodes[0];
      d = (nodes[3] - nodes[2]) - b;
    }
  }

  Point<dim - 1> start() const
  {
    Point<dim - 1> centre;
    for (unsigned int k = 0; k < dim - 1; ++k)
      centre[k] = 0.5;
    return centre;
  }

  void evaluate(const Point<dim - 1> &xi, Jet<dim> &jet) const
  {
    jet.r = a + xi[0] * b;
    jet.tangent[0] = b;
    if constexpr (dim == 3) {
      jet.tangent[0] += xi[1] * d;
      jet.tangent[1] = c + xi[0] * d;
      jet.r += xi[1] * jet.tangent[1];
      jet.second[1] = d;
    }
  }

private:
  Tensor<1, dim> a, b, c, d;
};

/// A face of any degree, as seen from a point.
template <int dim, typename Basis>
class PolynomialSurface
{
public:
  /// The arrays are memory for the evaluation.
  PolynomialSurface(const Basis &basis, const Point<dim> *nodes, const Point<dim> &Y,
                    std::vector<Tensor<1, dim>> &offsets, std::vector<double> &values,
                    std::vector<Tensor<1, dim - 1>> &gradients, std::vector<Tensor<2, dim - 1>> &hessians)
      : basis(basis), offsets(offsets), values(values), gradients(gradients), hessians(hessians)
  {
    for (unsigned int i = 0; i < basis.size(); ++i)
      offsets[i] = nodes[i] - Y;
  }

  /// The closest support point: a strongly curved face may have several local minima.
  Point<dim - 1> start() const
  {
    const auto closest =
        std::min_element(offsets.begin(), offsets.end(), [](const auto &one, const auto &other) {
          return one.norm_square() < other.norm_square();
        });
    return basis.support_points()[closest - offsets.begin()];
  }

  void evaluate(const Point<dim - 1> &xi, Jet<dim> &jet) const
  {
    basis.evaluate(xi, values, gradients, hessians);
    jet = Jet<dim>();
    for (unsigned int i = 0; i < basis.size(); ++i) {
      const Tensor<1, dim> &offset = offsets[i];
      jet.r += values[i] * offset;
      for (unsigned int k = 0, kl = 0; k < dim - 1; ++k) {
        jet.tangent[k] += gradients[i][k] * offset;
        for (unsigned int l = k; l < dim - 1; ++l, ++kl)
          jet.second[kl] += hessians[i][k][l] * offset;
      }
    }
  }

private:
  const Basis &basis;
  std::vector<Tensor<1, dim>> &offsets;
  std::vector<double> &values;
  std::vector<Tensor<1, dim - 1>> &gradients;
  std::vector<Tensor<2, dim - 1>> &hessians;
};

/// The quadratic model g.d + 1/2 d.H.d of the squared distance; H has the entries (0,0), (0,1), (1,1).
template <int dim>
struct QuadraticModel
{
  std::array<double, dim - 1> g;
  std::array<double, dim *(dim - 1) / 2> H;
  bool is_exact;

  explicit QuadraticModel(const Jet<dim> &jet)
  {
    std::array<double, dim *(dim - 1) / 2> G;
    for (unsigned int k = 0, kl = 0; k < dim - 1; ++k) {
      g[k] = jet.r * jet.tangent[k];
      for (unsigned int l = k; l < dim - 1; ++l, ++kl) {
        G[kl] = jet.tangent[k] * jet.tangent[l];
        H[kl] = G[kl] + jet.r * jet.second[kl];
      }
    }
    // Gauss-Newton where the squared distance is not safely convex.
    constexpr double fraction = 0.01;
    is_exact = H[0] > fraction * G[0];
    if constexpr (dim == 3)
      is_exact = is_exact && H[2] > fraction * G[2] &&
                 H[0] * H[2] - H[1] * H[1] > fraction * fraction * (G[0] * G[2] - G[1] * G[1]);
    if (!is_exact)
      H = G;
  }

  double value(const Tensor<1, dim - 1> &d) const
  {
    if constexpr (dim == 2)
      return d[0] * (g[0] + 0.5 * H[0] * d[0]);
    else
      return d[0] * (g[0] + 0.5 * H[0] * d[0] + H[1] * d[1]) + d[1] * (g[1] + 0.5 * H[2] * d[1]);
  }

  /// In 3D: to the minimum of the model.
  Tensor<1, 2> free_step() const
  {
    const double determinant = H[0] * H[2] - H[1] * H[1];
    return Tensor<1, 2>(
        {(H[1] * g[1] - H[2] * g[0]) / determinant, (H[1] * g[0] - H[0] * g[1]) / determinant});
  }

  /// In 3D: g + H d, and d.H d.
  Tensor<1, 2> derivative(const Tensor<1, 2> &d) const
  {
    return Tensor<1, 2>({g[0] + H[0] * d[0] + H[1] * d[1], g[1] + H[1] * d[0] + H[2] * d[1]});
  }
  double curvature(const Tensor<1, 2> &d) const
  {
    return d[0] * (H[0] * d[0] + 2 * H[1] * d[1]) + H[2] * d[1] * d[1];
  }
};

/// The reference line or square, 0 <= xi <= 1.
template <int dim>
struct UnitBox
{
  static void enter(Point<dim - 1> &xi)
  {
    for (unsigned int k = 0; k < dim - 1; ++k)
      xi[k] = std::clamp(xi[k], 0., 1.);
  }

  /// The step d that minimises the model under 0 <= xi + d <= 1.
  static Tensor<1, 1> step(const QuadraticModel<2> &model, const Point<1> &xi)
  {
    Tensor<1, 1> d;
    d[0] = std::clamp(-model.g[0] / model.H[0], -xi[0], 1 - xi[0]);
    return d;
  }

  static Tensor<1, 2> step(const QuadraticModel<3> &model, const Point<2> &xi)
  {
    // A convex quadratic whose minimum is outside has its minimum over the box on one of the violated sides.
    const auto &g = model.g;
    const auto &H = model.H;
    const Tensor<1, 2> free = model.free_step();
    Tensor<1, 2> best = free;
    double best_value = std::numeric_limits<double>::max();
    for (unsigned int k = 0; k < 2; ++k) {
      const double bound = std::clamp(free[k], -xi[k], 1 - xi[k]);
      if (bound == free[k])
        continue;
      const unsigned int l = 1 - k;
      Tensor<1, 2> d;
      d[k] = bound;
      d[l] = std::clamp(-(g[l] + H[1] * bound) / H[2 * l], -xi[l], 1 - xi[l]);
      if (const double value = model.value(d); value < best_value) {
        best_value = value;
        best = d;
      }
    }
    return best;
  }
};

/// The reference triangle, xi_0, xi_1 >= 0, xi_0 + xi_1 <= 1.
struct UnitTriangle
{
  static void enter(Point<2> &xi)
  {
    for (unsigned int k = 0; k < 2; ++k)
      xi[k] = std::clamp(xi[k], 0., 1.);
    if (const double sum = xi[0] + xi[1]; sum > 1)
      xi /= sum;
  }

  /// The step d that minimises the model: inside, or else on one of the three sides.
  static Tensor<1, 2> step(const QuadraticModel<3> &model, const Point<2> &xi)
  {
    const Tensor<1, 2> free = model.free_step();
    if (const Point<2> end = xi + free; end[0] >= 0 && end[1] >= 0 && end[0] + end[1] <= 1)
      return free;
    const std::array<Point<2>, 3> corner{{Point<2>(0, 0), Point<2>(1, 0), Point<2>(0, 1)}};
    Tensor<1, 2> best;
    double best_value = std::numeric_limits<double>::max();
    for (unsigned int i = 0; i < 3; ++i) {
      // along xi + d = corner + t side
      const Tensor<1, 2> start = corner[i] - xi, side = corner[(i + 1) % 3] - corner[i];
      const double t = std::clamp(-(model.derivative(start) * side) / model.curvature(side), 0., 1.);
      const Tensor<1, 2> d = start + t * side;
      if (const double value = model.value(d); value < best_value) {
        best_value = value;
        best = d;
      }
    }
    return best;
  }
};

/// Follow a step so short that the second order is below rounding.
template <int dim>
void extrapolate(Jet<dim> &jet, const Tensor<1, dim - 1> &d)
{
  for (unsigned int k = 0; k < dim - 1; ++k)
    jet.r += d[k] * jet.tangent[k];
  jet.tangent[0] += d[0] * jet.second[0];
  if constexpr (dim == 3) {
    jet.tangent[0] += d[1] * jet.second[1];
    jet.tangent[1] += d[0] * jet.second[1] + d[1] * jet.second[2];
  }
}

/// Newton's method for the closest point; on return @p jet belongs to the result.
template <int dim, typename Reference, typename Surface>
Point<dim - 1> closest_point(const Surface &surface, Jet<dim> &jet)
{
  Point<dim - 1> xi = surface.start();
  surface.evaluate(xi, jet);
  for (unsigned int iteration = 0; iteration < 100; ++iteration) {
    const QuadraticModel<dim> model(jet);
    Tensor<1, dim - 1> d = Reference::step(model, xi);
    // After an exact Newton step of 1e-8 the error is 1e-16; Gauss-Newton converges linearly.
    if (d.norm_square() <= (model.is_exact ? 1e-16 : 1e-28)) {
      extrapolate(jet, d);
      xi += d;
      break;
    }

    // Halve until the squared distance decreases (Armijo); its rounding is that of the tangents squared.
    const double f = jet.r.norm_square();
    double slope = 0, rounding = 0;
    for (unsigned int k = 0; k < dim - 1; ++k) {
      slope += 2 * model.g[k] * d[k];
      rounding += 1e-15 * (f + jet.tangent[k].norm_square());
    }
    const Point<dim - 1> last = xi;
    for (unsigned int halving = 0; halving < 30; ++halving, d *= 0.5, slope *= 0.5) {
      xi = last + d;
      Reference::enter(xi);
      surface.evaluate(xi, jet);
      if (jet.r.norm_square() <= f + 1e-4 * slope + rounding)
        break;
    }
  }
  Reference::enter(xi);
  return xi;
}

/// What differences of coordinates near X may be off by.
template <int dim>
double rounding(const Point<dim> &X)
{
  return 1e-15 * X.norm();
}

/// The closest point of a plane triangle a + b xi_0 + c xi_1 to the origin.
Point<2> closest_of_triangle(const Tensor<1, 3> &a, const Tensor<1, 3> &b, const Tensor<1, 3> &c)
{
  const double bb = b * b, bc = b * c, cc = c * c, ab = a * b, ac = a * c;
  const double determinant = bb * cc - bc * bc;
  const Point<2> free((bc * ac - cc * ab) / determinant, (bc * ab - bb * ac) / determinant);
  if (free[0] >= 0 && free[1] >= 0 && free[0] + free[1] <= 1)
    return free;
  Point<2> best;
  double least = std::numeric_limits<double>::max();
  const auto compare = [&](const Point<2> &xi) {
    const double square = (a + xi[0] * b + xi[1] * c).norm_square();
    if (square < least) {
      least = square;
      best = xi;
    }
  };
  compare({std::clamp(-ab / bb, 0., 1.), 0});
  compare({0, std::clamp(-ac / cc, 0., 1.)});
  const double s = std::clamp((bb + ab - bc - ac) / (bb - 2 * bc + cc), 0., 1.); // from corner 1 to corner 2
  compare({1 - s, s});
  return best;
}

} // namespace

template <int dim>
FaceShape<dim>::FaceShape(const ReferenceCell &cell, const unsigned int mapping_degree)
    : reference_cell(cell), mapping_degree(mapping_degree), triangle(cell == ReferenceCells::Tetrahedron),
      basis(mapping_degree), simplex_basis(triangle ? mapping_degree : 1), offsets(n_nodes()),
      values(n_nodes()), gradients(n_nodes()), hessians(n_nodes())
{
  AssertThrow(cell.is_hyper_cube() || cell.is_simplex(), ExcNotImplemented());
  if (dim == 3)
    find_edges();
  for (const unsigned int f : cell.face_indices()) {
    Frame frame;
    if (cell.is_hyper_cube()) {
      // the cell's own coordinates in increasing order, whatever orientation the face has in the
      // triangulation
      const unsigned int axis = f / 2;
      frame.origin[axis] = f % 2;
      for (unsigned int d = 0, k = 0; d < dim; ++d)
        if (d != axis)
          frame.direction[k++][d] = 1;
    } else {
      const auto vertex = [&](const unsigned int v) {
        return cell.template vertex<dim>(cell.face_to_cell_vertices(f, v, 1));
      };
      frame.origin = vertex(0);
      for (unsigned int k = 0; k < dim - 1; ++k)
        frame.direction[k] = vertex(k + 1) - vertex(0);
    }
    // Jacobians of cells are positive in deal.II, so the sign is that on the reference cell.
    Tensor<1, dim> product, inside;
    if constexpr (dim == 2)
      product = cross_product_2d(frame.direction[0]);
    else
      product = cross_product_3d(frame.direction[0], frame.direction[1]);
    for (const unsigned int v : cell.vertex_indices())
      inside += (cell.template vertex<dim>(v) - frame.origin) / cell.n_vertices();
    frame.orientation = product * inside > 0 ? -1 : 1;
    frames.push_back(frame);
  }
}

/// By the positions of the nodes.
template <int dim>
void FaceShape<dim>::find_edges()
{
  points_of_edge = QGaussLobatto<1>(mapping_degree + 1).get_points();
  const auto &points = triangle ? simplex_basis.support_points() : basis.support_points();
  for (unsigned int i = 0; i < n_corners(); ++i) {
    const Point<dim - 1> from = corner(i), to = corner((i + 1) % n_corners());
    std::vector<std::pair<double, unsigned int>> on_edge;
    for (unsigned int a = 0; a < points.size(); ++a)
      if (std::abs(from.distance(points[a]) + points[a].distance(to) - from.distance(to)) < 1e-10)
        on_edge.emplace_back(from.distance(points[a]), a);
    std::sort(on_edge.begin(), on_edge.end());
    nodes_of_edge.emplace_back();
    for (const auto &[distance, a] : on_edge)
      nodes_of_edge.back().push_back(a);
  }
}

template <int dim>
std::vector<Point<dim>> FaceShape<dim>::edge(const Point<dim> *nodes, const unsigned int i) const
{
  std::vector<Point<dim>> result;
  if (triangle && mapping_degree > 2) { // equidistant nodes
    const Point<dim - 1> from = corner(i);
    const Tensor<1, dim - 1> along = corner((i + 1) % n_corners()) - from;
    for (const Point<1> &v : points_of_edge)
      result.push_back(evaluate(nodes, from + v[0] * along).X);
  } else
    for (const unsigned int a : nodes_of_edge[i])
      result.push_back(nodes[a]);
  return result;
}

template <int dim>
double FaceShape<dim>::bulge_of_rim(const Point<dim> *nodes) const
{
  double square = 0;
  for (unsigned int i = 0; mapping_degree > 1 && i < nodes_of_edge.size(); ++i) {
    const std::vector<Point<dim>> points = edge(nodes, i);
    const Tensor<1, dim> chord = points.back() - points.front();
    for (const Point<dim> &point : points) {
      const Tensor<1, dim> r = point - points.front();
      const double along = r * chord / std::max(chord.norm_square(), std::numeric_limits<double>::min());
      square = std::max(square, (r - along * chord).norm_square());
    }
  }
  return std::sqrt(square);
}

template <int dim>
std::vector<Point<dim>> FaceShape<dim>::nodes_in_cell(const unsigned int face_no) const
{
  std::vector<Point<dim>> result;
  for (unsigned int i = 0; i < n_nodes(); ++i)
    result.push_back(
        position_in_cell(face_no, triangle ? simplex_basis.support_points()[i] : basis.support_points()[i]));
  return result;
}

template <int dim>
Point<dim> FaceShape<dim>::position_in_cell(const unsigned int face_no, const Point<dim - 1> &xi) const
{
  const Frame &frame = frames[face_no];
  Point<dim> result = frame.origin;
  for (unsigned int k = 0; k < dim - 1; ++k)
    result += xi[k] * frame.direction[k];
  return result;
}

template <int dim>
Point<dim - 1> FaceShape<dim>::centre() const
{
  Point<dim - 1> result;
  for (unsigned int k = 0; k < dim - 1; ++k)
    result[k] = triangle ? 1. / 3 : 0.5;
  return result;
}

template <int dim>
Point<dim - 1> FaceShape<dim>::corner(const unsigned int i) const
{
  Point<dim - 1> result;
  if constexpr (dim == 2)
    result[0] = i;
  else if (triangle)
    result = Point<2>(i == 1, i == 2);
  else
    result = Point<2>(i == 1 || i == 2, i >= 2);
  return result;
}

template <int dim>
Point<dim> FaceShape<dim>::corner(const Point<dim> *nodes, const unsigned int i) const
{
  const unsigned int n = basis.size();
  if constexpr (dim == 2)
    return nodes[i * (n - 1)];
  else {
    if (triangle)
      return nodes[nodes_of_edge[i].front()];
    const unsigned int n_1d = mapping_degree + 1;
    const std::array<unsigned int, 4> around{{0, n_1d - 1, n - 1, n - n_1d}};
    return nodes[around[i]];
  }
}

template <int dim>
SurfacePoint<dim> FaceShape<dim>::evaluate(const Point<dim> *nodes, const Point<dim - 1> &xi) const
{
  SurfacePoint<dim> point;
  point.xi = xi;
  if (triangle && mapping_degree == 1) {
    point.X = nodes[0];
    for (unsigned int k = 0; k < dim - 1; ++k) {
      point.tangent[k] = nodes[k + 1] - nodes[0];
      point.X += xi[k] * point.tangent[k];
    }
    return point;
  }
  if (mapping_degree == 1) {
    Jet<dim> jet;
    LinearSurface<dim>(nodes, nodes[0]).evaluate(xi, jet);
    point.X = nodes[0] + jet.r;
    point.tangent = jet.tangent;
    return point;
  }
  if (triangle)
    simplex_basis.evaluate(xi, values, gradients, no_hessians);
  else
    basis.evaluate(xi, values, gradients, no_hessians);
  Tensor<1, dim> X;
  for (unsigned int i = 0; i < n_nodes(); ++i) {
    X += values[i] * nodes[i];
    for (unsigned int k = 0; k < dim - 1; ++k)
      point.tangent[k] += gradients[i][k] * nodes[i];
  }
  point.X = Point<dim>(X);
  return point;
}

template <int dim>
Tensor<1, dim> FaceShape<dim>::normal(const unsigned int face_no, const SurfacePoint<dim> &point) const
{
  if constexpr (dim == 2)
    return frames[face_no].orientation * cross_product_2d(point.tangent[0]);
  else
    return frames[face_no].orientation * cross_product_3d(point.tangent[0], point.tangent[1]);
}

template <int dim>
SurfacePoint<dim> FaceShape<dim>::closest(const Point<dim> *nodes, const Point<dim> &Y) const
{
  if constexpr (dim == 3)
    if (triangle && mapping_degree == 1)
      return evaluate(nodes, closest_of_triangle(nodes[0] - Y, nodes[1] - nodes[0], nodes[2] - nodes[0]));

  Jet<dim> jet;
  SurfacePoint<dim> point;
  if (triangle) {
    if constexpr (dim == 3)
      point.xi =
          closest_point<dim, UnitTriangle>(PolynomialSurface<dim, SimplexBasis<2>>(
                                               simplex_basis, nodes, Y, offsets, values, gradients, hessians),
                                           jet);
  } else if (mapping_degree == 1)
    point.xi = closest_point<dim, UnitBox<dim>>(LinearSurface<dim>(nodes, Y), jet);
  else
    point.xi = closest_point<dim, UnitBox<dim>>(
        PolynomialSurface<dim, LagrangeBasis<dim - 1>>(basis, nodes, Y, offsets, values, gradients, hessians),
        jet);
  point.X = Y + jet.r;
  point.tangent = jet.tangent;
  return point;
}

template <int dim>
double FaceShape<dim>::diameter(const Point<dim> *nodes) const
{
  double square = 0;
  for (unsigned int i = 0; i < n_nodes(); ++i)
    for (unsigned int j = 0; j < i; ++j)
      square = std::max(square, nodes[i].distance_square(nodes[j]));
  return std::sqrt(square);
}

/// X_a minus the (multi)linear function through the corners, relative to the first corner.
template <int dim>
std::vector<Tensor<1, dim>> FaceShape<dim>::rest_of_linear(const Point<dim> *nodes) const
{
  std::vector<Point<dim>> corners;
  for (unsigned int i = 0; i < n_corners(); ++i)
    corners.push_back(corner(nodes, i));
  if (dim == 3 && !triangle)
    std::swap(corners[2], corners[3]);
  const auto &points = triangle ? simplex_basis.support_points() : basis.support_points();
  std::vector<Tensor<1, dim>> result;
  for (unsigned int i = 0; i < points.size(); ++i) {
    Tensor<1, dim> rest = nodes[i] - corners[0];
    for (unsigned int c = 1; c < corners.size(); ++c)
      rest -= (triangle ? points[i][c - 1] : GeometryInfo<dim - 1>::d_linear_shape_function(points[i], c)) *
              (corners[c] - corners[0]);
    result.push_back(rest);
  }
  return result;
}

/// The box of the (multi)linear part, which lies in the hull of the corners, widened by the rest, sum_a phi_a
/// (X_a - linear part), with sum |phi_a| <= 2 per direction (up to degree 10; triangles: 4 up to degree 3).
template <int dim>
BoundingBox<dim> FaceShape<dim>::box(const Point<dim> *nodes) const
{
  std::vector<Point<dim>> corners;
  for (unsigned int i = 0; i < n_corners(); ++i)
    corners.push_back(corner(nodes, i));
  BoundingBox<dim> result(corners);
  if (mapping_degree == 1)
    return result;
  Tensor<1, dim> bulge;
  for (const Tensor<1, dim> &rest : rest_of_linear(nodes))
    for (unsigned int d = 0; d < dim; ++d)
      bulge[d] = std::max(bulge[d], (1 << (dim - 1)) * std::abs(rest[d]));
  return {{result.get_boundary_points().first - bulge, result.get_boundary_points().second + bulge}};
}

template <int dim>
bool FaceShape<dim>::is_flat(const Point<dim> *nodes) const
{
  if (mapping_degree == 1 && (triangle || dim == 2))
    return true;
  const double tolerance = 1e-12 * diameter(nodes) + rounding(nodes[0]);
  if constexpr (dim == 3)
    if (!triangle) {
      const Point<dim> origin = corner(nodes, 0);
      const Tensor<1, dim> b = corner(nodes, 1) - origin, c = corner(nodes, 2) - origin,
                           d = corner(nodes, 3) - origin, N = cross_product_3d(c, d - b);
      if (std::abs(b * N) > tolerance * N.norm() || std::abs(d * N) > tolerance * N.norm())
        return false;
    }
  const std::vector<Tensor<1, dim>> rest = rest_of_linear(nodes);
  return std::all_of(rest.begin(), rest.end(),
                     [&](const auto &node_vector) { return node_vector.norm() <= tolerance; });
}

template <int dim>
bool FaceShape<dim>::is_affine(const Point<dim> *nodes) const
{
  if (!is_flat(nodes))
    return false;
  if (dim == 2 || triangle)
    return true;
  return ((corner(nodes, 0) - corner(nodes, 1)) + (corner(nodes, 2) - corner(nodes, 3))).norm() <=
         1e-12 * diameter(nodes) + rounding(nodes[0]);
}

template class FaceShape<2>;
template class FaceShape<3>;

} // namespace dovetail
