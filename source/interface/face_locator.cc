// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The closest point of a face solves  min 1/2 |X(xi) - Y|^2  over xi in [0,1]^(dim-1),  X(xi) = sum_a
// phi_a(xi) X_a. With r = X - Y the gradient is g_k = r.X_,k and the Hessian H_kl = X_,k.X_,l + r.X_,kl. Each
// Newton step minimises the quadratic model over the box exactly, so that on a flat parallelogram the first
// step arrives, also at its rim.

#include <dovetail/interface/face_locator.h>

#include <deal.II/base/bounding_box.h>
#include <deal.II/base/exceptions.h>
#include <deal.II/base/geometry_info.h>
#include <deal.II/base/quadrature.h>
#include <deal.II/fe/fe_nothing.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/grid/cell_id.h>
#include <deal.II/numerics/rtree.h>

#include <boost/iterator/function_output_iterator.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace dovetail {

using namespace dealii;

namespace {

/// Lengths below this fraction of the face size are no distances (see the header).
constexpr double relative_tolerance = 1e-6;

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

/// Memory for the evaluation of faces of higher degree, allocated once per call of locate().
template <int dim>
struct SurfaceScratch
{
  explicit SurfaceScratch(const unsigned int n) : offsets(n), values(n), gradients(n), hessians(n) {}

  std::vector<Tensor<1, dim>> offsets;
  std::vector<double> values;
  std::vector<Tensor<1, dim - 1>> gradients;
  std::vector<Tensor<2, dim - 1>> hessians;
};

/// A face of any degree, as seen from a point.
template <int dim>
class PolynomialSurface
{
public:
  PolynomialSurface(const LagrangeBasis<dim - 1> &basis, const Point<dim> *nodes, const Point<dim> &Y,
                    SurfaceScratch<dim> &scratch)
      : basis(basis), scratch(scratch)
  {
    for (unsigned int i = 0; i < basis.size(); ++i)
      scratch.offsets[i] = nodes[i] - Y;
  }

  /// The closest support point: a strongly curved face may have several local minima.
  Point<dim - 1> start() const
  {
    const auto closest = std::min_element(
        scratch.offsets.begin(), scratch.offsets.end(),
        [](const auto &one, const auto &other) { return one.norm_square() < other.norm_square(); });
    return basis.support_points()[closest - scratch.offsets.begin()];
  }

  void evaluate(const Point<dim - 1> &xi, Jet<dim> &jet) const
  {
    basis.evaluate(xi, scratch.values, scratch.gradients, scratch.hessians);
    jet = Jet<dim>();
    for (unsigned int i = 0; i < basis.size(); ++i) {
      const Tensor<1, dim> &offset = scratch.offsets[i];
      jet.r += scratch.values[i] * offset;
      for (unsigned int k = 0, kl = 0; k < dim - 1; ++k) {
        jet.tangent[k] += scratch.gradients[i][k] * offset;
        for (unsigned int l = k; l < dim - 1; ++l, ++kl)
          jet.second[kl] += scratch.hessians[i][k][l] * offset;
      }
    }
  }

private:
  const LagrangeBasis<dim - 1> &basis;
  SurfaceScratch<dim> &scratch;
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
};

/// The step d that minimises the model under 0 <= xi + d <= 1.
Tensor<1, 1> step_in_box(const QuadraticModel<2> &model, const Point<1> &xi)
{
  Tensor<1, 1> d;
  d[0] = std::clamp(-model.g[0] / model.H[0], -xi[0], 1 - xi[0]);
  return d;
}

Tensor<1, 2> step_in_box(const QuadraticModel<3> &model, const Point<2> &xi)
{
  const auto &g = model.g;
  const auto &H = model.H;
  const double determinant = H[0] * H[2] - H[1] * H[1];
  Tensor<1, 2> free;
  free[0] = (H[1] * g[1] - H[2] * g[0]) / determinant;
  free[1] = (H[1] * g[0] - H[0] * g[1]) / determinant;

  // A convex quadratic whose minimum is outside has its minimum over the box on one of the violated sides.
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
template <int dim, typename Surface>
Point<dim - 1> closest_point(const Surface &surface, Jet<dim> &jet)
{
  Point<dim - 1> xi = surface.start();
  surface.evaluate(xi, jet);
  for (unsigned int iteration = 0; iteration < 100; ++iteration) {
    const QuadraticModel<dim> model(jet);
    Tensor<1, dim - 1> d = step_in_box(model, xi);
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
      for (unsigned int k = 0; k < dim - 1; ++k)
        xi[k] = std::clamp(xi[k], 0., 1.);
      surface.evaluate(xi, jet);
      if (jet.r.norm_square() <= f + 1e-4 * slope + rounding)
        break;
    }
  }
  for (unsigned int k = 0; k < dim - 1; ++k)
    xi[k] = std::clamp(xi[k], 0., 1.);
  return xi;
}

/// Face coordinates are the cell's own in increasing order, whatever orientation the face has in the
/// triangulation: then the position in the cell needs no look at flips and rotations.
template <int dim>
Point<dim> position_in_cell(const unsigned int face_no, const Point<dim - 1> &xi)
{
  Point<dim> result;
  const unsigned int axis = face_no / 2;
  for (unsigned int d = 0, k = 0; d < dim; ++d)
    result[d] = (d == axis) ? face_no % 2 : xi[k++];
  return result;
}

/// The outward normal from the tangents along the coordinates above; Jacobians of cells are positive in
/// deal.II.
template <int dim>
Tensor<1, dim> outward_normal(const unsigned int face_no, const std::array<Tensor<1, dim>, dim - 1> &tangent)
{
  Tensor<1, dim> normal;
  if constexpr (dim == 2)
    normal = cross_product_2d(tangent[0]);
  else
    normal = cross_product_3d(tangent[0], tangent[1]);
  const bool points_inside = (face_no % 2 == 1) == (face_no / 2 == 1);
  return normal * ((points_inside ? -1. : 1.) / normal.norm());
}

/// The unit in which distances to a face of a size are counted: about 1e-9 of the size, and a power of two,
/// so that rounding is exact and faces of equal size share it.
double distance_quantum(const double face_size)
{
  return std::ldexp(1., std::ilogb(face_size) - 30);
}

/// (CellId, number of the face): the same for every partition.
using GlobalKey = std::array<unsigned int, 5>;

template <int dim>
GlobalKey global_key(const typename FaceLocator<dim>::Face &face)
{
  const CellId::binary_type id = face.cell->id().template to_binary<dim>();
  return {{id[0], id[1], id[2], id[3], face.face_no}};
}

template <int dim>
double diameter(const Point<dim> *nodes, const unsigned int n)
{
  double square = 0;
  for (unsigned int i = 0; i < n; ++i)
    for (unsigned int j = 0; j < i; ++j)
      square = std::max(square, nodes[i].distance_square(nodes[j]));
  return std::sqrt(square);
}

/// A box that holds the face: that of its (multi)linear part, which lies in the hull of the corners, widened
/// by the rest, sum_a phi_a (X_a - linear part), with sum |phi_a| <= 2 per direction (up to degree 10).
template <int dim>
BoundingBox<dim> enclosing_box(const LagrangeBasis<dim - 1> &basis, const Point<dim> *nodes)
{
  const unsigned int n = basis.size();
  const unsigned int n_1d = std::lround(std::pow(n, 1. / (dim - 1)));
  std::vector<Point<dim>> corners;
  for (unsigned int i = 0; i < GeometryInfo<dim - 1>::vertices_per_cell; ++i)
    corners.push_back(nodes[(i % 2) * (n_1d - 1) + (i / 2) * (n - n_1d)]);

  Tensor<1, dim> bulge;
  for (unsigned int i = 0; i < n; ++i) {
    Point<dim> linear;
    for (unsigned int c = 0; c < corners.size(); ++c)
      linear += GeometryInfo<dim - 1>::d_linear_shape_function(basis.support_points()[i], c) * corners[c];
    for (unsigned int d = 0; d < dim; ++d)
      bulge[d] = std::max(bulge[d], (1 << (dim - 1)) * std::abs(nodes[i][d] - linear[d]));
  }
  const BoundingBox<dim> box(corners);
  return {{box.get_boundary_points().first - bulge, box.get_boundary_points().second + bulge}};
}

template <int dim>
double distance_square(const BoundingBox<dim> &box, const Point<dim> &X)
{
  const auto &[lower, upper] = box.get_boundary_points();
  double result = 0;
  for (unsigned int d = 0; d < dim; ++d) {
    const double outside = std::max({0., lower[d] - X[d], X[d] - upper[d]});
    result += outside * outside;
  }
  return result;
}

} // namespace

template <int dim>
struct FaceLocator<dim>::Implementation
{
  template <typename Index>
  using BoxTree = RTree<std::pair<BoundingBox<dim>, Index>>;

  struct Candidate
  {
    double bound; ///< its distance is not smaller
    unsigned int face;
    bool operator<(const Candidate &other) const { return bound < other.bound; }
  };

  struct Scratch : SurfaceScratch<dim>
  {
    using SurfaceScratch<dim>::SurfaceScratch;
    std::vector<Candidate> candidates;
  };

  Implementation(const unsigned int mapping_degree, const double search_radius, const MPI_Comm &communicator);

  void collect_faces(const Triangulation<dim> &triangulation, const Mapping<dim> &mapping,
                     const std::set<types::boundary_id> &boundary_ids);
  void build_trees();

  /// The distance beyond which the face is no partner.
  double reach(const unsigned int face) const;
  Match closest(const unsigned int face, const Query &query, Scratch &scratch) const;
  void search(const Query &query, Scratch &scratch, Match &best) const;

  /// The sparse exchange: to each other rank whose boxes hold them a list of queries, and their answers back.
  std::map<unsigned int, std::vector<unsigned int>>
  queries_of_other_ranks(const std::vector<Query> &queries) const;
  std::vector<double> answer(const std::vector<double> &packed_queries, Scratch &scratch) const;
  void merge(const unsigned int rank, const std::vector<unsigned int> &indices,
             const std::vector<double> &packed_answers, std::vector<Match> &matches,
             std::vector<GlobalKey> &keys) const;

  const unsigned int degree;
  const double radius;
  const MPI_Comm communicator;
  const unsigned int this_rank;
  const unsigned int n_ranks;
  const LagrangeBasis<dim - 1> basis;

  std::vector<Face> faces;
  std::vector<GlobalKey> keys;
  std::vector<Point<dim>> nodes; ///< basis.size() support points per face
  std::vector<BoundingBox<dim>> boxes;
  BoxTree<unsigned int> face_tree;
  BoxTree<unsigned int> rank_tree; ///< the coarse boxes of the other ranks
};

namespace {

/// The order of candidates: accepted ones first, then by rounded distance, then by global key.
template <typename Match>
bool is_better(const Match &one, const GlobalKey &key_of_one, const Match &other,
               const GlobalKey &key_of_other)
{
  if (one.found != other.found)
    return one.found;
  const auto rounded = [](const Match &match) {
    const double quantum = distance_quantum(match.face_size);
    return std::nearbyint(match.distance / quantum) * quantum;
  };
  const double distance = rounded(one), other_distance = rounded(other);
  return distance != other_distance ? distance < other_distance : key_of_one < key_of_other;
}

} // namespace

template <int dim>
FaceLocator<dim>::Implementation::Implementation(const unsigned int mapping_degree,
                                                 const double search_radius, const MPI_Comm &communicator)
    : degree(mapping_degree), radius(search_radius), communicator(communicator),
      this_rank(Utilities::MPI::this_mpi_process(communicator)),
      n_ranks(Utilities::MPI::n_mpi_processes(communicator)), basis(mapping_degree)
{
}

template <int dim>
void FaceLocator<dim>::Implementation::collect_faces(const Triangulation<dim> &triangulation,
                                                     const Mapping<dim> &mapping,
                                                     const std::set<types::boundary_id> &boundary_ids)
{
  AssertThrow(triangulation.all_reference_cells_are_hyper_cube(),
              ExcMessage("The face locator knows quadrilaterals and hexahedra only."));
  const FE_Nothing<dim> fe;
  std::array<std::unique_ptr<FEValues<dim>>, 2 * dim> support_points;
  for (unsigned int f = 0; f < 2 * dim; ++f) {
    std::vector<Point<dim>> in_cell;
    for (const Point<dim - 1> &xi : basis.support_points())
      in_cell.push_back(position_in_cell<dim>(f, xi));
    support_points[f] =
        std::make_unique<FEValues<dim>>(mapping, fe, Quadrature<dim>(in_cell), update_quadrature_points);
  }

  for (const auto &cell : triangulation.active_cell_iterators()) {
    if (!cell->is_locally_owned() || !cell->at_boundary())
      continue;
    for (const unsigned int f : cell->face_indices())
      if (cell->face(f)->at_boundary() && boundary_ids.count(cell->face(f)->boundary_id()) > 0) {
        support_points[f]->reinit(cell);
        const auto &points = support_points[f]->get_quadrature_points();
        nodes.insert(nodes.end(), points.begin(), points.end());
        faces.push_back({cell, f, diameter(points.data(), points.size())});
        keys.push_back(global_key<dim>(faces.back()));
      }
  }
}

template <int dim>
void FaceLocator<dim>::Implementation::build_trees()
{
  std::vector<std::pair<BoundingBox<dim>, unsigned int>> inflated;
  for (unsigned int face = 0; face < faces.size(); ++face) {
    boxes.push_back(enclosing_box<dim>(basis, &nodes[face * basis.size()]));
    inflated.emplace_back(boxes.back(), face);
    inflated.back().first.extend(reach(face));
  }
  face_tree = pack_rtree(inflated);
  if (n_ranks == 1)
    return;

  // One level below the root: at most 16 boxes. Ranks without faces send an empty list.
  std::vector<double> corners;
  if (!faces.empty())
    for (const BoundingBox<dim> &box : extract_rtree_level(face_tree, 0))
      for (unsigned int d = 0; d < dim; ++d) {
        corners.push_back(box.get_boundary_points().first[d]);
        corners.push_back(box.get_boundary_points().second[d]);
      }

  std::vector<std::pair<BoundingBox<dim>, unsigned int>> coarse;
  const std::vector<std::vector<double>> all_corners = Utilities::MPI::all_gather(communicator, corners);
  for (unsigned int rank = 0; rank < n_ranks; ++rank)
    for (unsigned int i = 0; rank != this_rank && i < all_corners[rank].size(); i += 2 * dim) {
      std::pair<Point<dim>, Point<dim>> corner;
      for (unsigned int d = 0; d < dim; ++d) {
        corner.first[d] = all_corners[rank][i + 2 * d];
        corner.second[d] = all_corners[rank][i + 2 * d + 1];
      }
      coarse.emplace_back(BoundingBox<dim>(corner), rank);
    }
  rank_tree = pack_rtree(coarse);
}

template <int dim>
double FaceLocator<dim>::Implementation::reach(const unsigned int face) const
{
  return (radius + relative_tolerance) * faces[face].size;
}

template <int dim>
typename FaceLocator<dim>::Match
FaceLocator<dim>::Implementation::closest(const unsigned int face, const Query &query, Scratch &scratch) const
{
  Jet<dim> jet;
  Point<dim - 1> xi;
  const Point<dim> *face_nodes = &nodes[face * basis.size()];
  if (degree == 1)
    xi = closest_point(LinearSurface<dim>(face_nodes, query.X), jet);
  else
    xi = closest_point(PolynomialSurface<dim>(basis, face_nodes, query.X, scratch), jet);

  const Face &partner = faces[face];
  Match match;
  match.rank = this_rank;
  match.face = face;
  match.face_size = partner.size;
  match.X = query.X + jet.r;
  match.N = outward_normal<dim>(partner.face_no, jet.tangent);
  match.unit_point = position_in_cell<dim>(partner.face_no, xi);
  match.distance = jet.r.norm();
  // The half-angle form keeps its digits for small angles, which the arc cosine does not.
  match.angle = 2 * std::asin(std::min(1., 0.5 * (query.N + match.N).norm()));

  const double normal_distance = std::abs(jet.r * match.N);
  const double sideways = std::sqrt(std::max(0., jet.r.norm_square() - normal_distance * normal_distance));
  match.found = query.N * match.N < -relative_tolerance && match.distance <= reach(face) &&
                sideways <= std::max(relative_tolerance * partner.size, normal_distance);
  return match;
}

template <int dim>
void FaceLocator<dim>::Implementation::search(const Query &query, Scratch &scratch, Match &best) const
{
  std::vector<Candidate> &candidates = scratch.candidates;
  candidates.clear();
  face_tree.query(boost::geometry::index::intersects(query.X),
                  boost::make_function_output_iterator([&](const auto &box_and_face) {
                    const unsigned int face = box_and_face.second;
                    candidates.push_back({std::sqrt(distance_square(boxes[face], query.X)), face});
                  }));
  std::sort(candidates.begin(), candidates.end());

  for (const Candidate &candidate : candidates) {
    // Farther even after rounding both distances; 1e-8 is some of their quanta.
    if (best.found && candidate.bound > best.distance + 1e-8 * (best.face_size + faces[candidate.face].size))
      continue;
    const Match match = closest(candidate.face, query, scratch);
    if (best.face == numbers::invalid_unsigned_int ||
        is_better(match, keys[match.face], best, keys[best.face]))
      best = match;
  }
}

template <int dim>
std::map<unsigned int, std::vector<unsigned int>>
FaceLocator<dim>::Implementation::queries_of_other_ranks(const std::vector<Query> &queries) const
{
  std::map<unsigned int, std::vector<unsigned int>> result;
  for (unsigned int i = 0; i < queries.size(); ++i)
    rank_tree.query(boost::geometry::index::intersects(queries[i].X),
                    boost::make_function_output_iterator([&](const auto &box_and_rank) {
                      std::vector<unsigned int> &indices = result[box_and_rank.second];
                      if (indices.empty() ||
                          indices.back() != i) // several boxes of a rank may hold the point
                        indices.push_back(i);
                    }));
  return result;
}

namespace {

/// found, distance, angle, face, face size; then three points or vectors; then the key.
constexpr unsigned int n_scalars = 5;

template <int dim>
constexpr unsigned int answer_size = n_scalars + 3 * dim + 5;

template <int dim, typename Match>
void pack(const Match &match, const GlobalKey &key, double *data)
{
  const std::array<double, n_scalars> scalars{
      {match.found ? 1. : 0., match.distance, match.angle, double(match.face), match.face_size}};
  data = std::copy(scalars.begin(), scalars.end(), data);
  for (unsigned int d = 0; d < dim; ++d) {
    data[d] = match.unit_point[d];
    data[dim + d] = match.X[d];
    data[2 * dim + d] = match.N[d];
  }
  std::copy(key.begin(), key.end(), data + 3 * dim);
}

template <int dim, typename Match>
void unpack(const double *data, Match &match, GlobalKey &key)
{
  match.found = data[0] > 0;
  match.distance = data[1];
  match.angle = data[2];
  match.face = data[3];
  match.face_size = data[4];
  data += n_scalars;
  for (unsigned int d = 0; d < dim; ++d) {
    match.unit_point[d] = data[d];
    match.X[d] = data[dim + d];
    match.N[d] = data[2 * dim + d];
  }
  std::copy(data + 3 * dim, data + 3 * dim + key.size(), key.begin());
}

} // namespace

template <int dim>
std::vector<double> FaceLocator<dim>::Implementation::answer(const std::vector<double> &packed_queries,
                                                             Scratch &scratch) const
{
  const unsigned int n_queries = packed_queries.size() / (2 * dim);
  std::vector<double> result(n_queries * answer_size<dim>);
  for (unsigned int i = 0; i < n_queries; ++i) {
    Query query;
    for (unsigned int d = 0; d < dim; ++d) {
      query.X[d] = packed_queries[2 * dim * i + d];
      query.N[d] = packed_queries[2 * dim * i + dim + d];
    }
    Match match;
    search(query, scratch, match);
    const bool is_empty = match.face == numbers::invalid_unsigned_int;
    pack<dim>(match, is_empty ? GlobalKey() : keys[match.face], &result[i * answer_size<dim>]);
  }
  return result;
}

template <int dim>
void FaceLocator<dim>::Implementation::merge(const unsigned int rank,
                                             const std::vector<unsigned int> &indices,
                                             const std::vector<double> &packed_answers,
                                             std::vector<Match> &matches,
                                             std::vector<GlobalKey> &keys_of_matches) const
{
  AssertDimension(packed_answers.size(), indices.size() * answer_size<dim>);
  for (unsigned int i = 0; i < indices.size(); ++i) {
    Match match;
    GlobalKey key;
    unpack<dim>(&packed_answers[i * answer_size<dim>], match, key);
    match.rank = rank;
    Match &best = matches[indices[i]];
    GlobalKey &best_key = keys_of_matches[indices[i]];
    if (match.face == numbers::invalid_unsigned_int)
      continue;
    if (best.face == numbers::invalid_unsigned_int || is_better(match, key, best, best_key)) {
      best = match;
      best_key = key;
    }
  }
}

template <int dim>
FaceLocator<dim>::FaceLocator(const Triangulation<dim> &triangulation, const Mapping<dim> &mapping,
                              const unsigned int mapping_degree,
                              const std::set<types::boundary_id> &boundary_ids, const double search_radius,
                              const MPI_Comm &communicator)
    : implementation(std::make_unique<Implementation>(mapping_degree, search_radius, communicator))
{
  implementation->collect_faces(triangulation, mapping, boundary_ids);
  implementation->build_trees();
}

template <int dim>
FaceLocator<dim>::~FaceLocator() = default;

template <int dim>
const std::vector<typename FaceLocator<dim>::Face> &FaceLocator<dim>::faces() const
{
  return implementation->faces;
}

template <int dim>
std::vector<typename FaceLocator<dim>::Match>
FaceLocator<dim>::locate(const std::vector<Query> &queries) const
{
  const Implementation &local = *implementation;
  typename Implementation::Scratch scratch(local.basis.size());
  std::vector<Match> matches(queries.size());
  for (unsigned int i = 0; i < queries.size(); ++i)
    local.search(queries[i], scratch, matches[i]);
  if (local.n_ranks == 1)
    return matches;

  const auto indices = local.queries_of_other_ranks(queries);
  std::map<unsigned int, std::vector<double>> sent, answers;
  for (const auto &[rank, indices_of_rank] : indices)
    for (const unsigned int i : indices_of_rank) {
      sent[rank].insert(sent[rank].end(), queries[i].X.begin_raw(), queries[i].X.end_raw());
      sent[rank].insert(sent[rank].end(), queries[i].N.begin_raw(), queries[i].N.end_raw());
    }
  for (const auto &[rank, packed] : Utilities::MPI::some_to_some(local.communicator, sent))
    answers[rank] = local.answer(packed, scratch);

  std::vector<GlobalKey> keys(queries.size());
  for (unsigned int i = 0; i < queries.size(); ++i)
    if (matches[i].face != numbers::invalid_unsigned_int)
      keys[i] = local.keys[matches[i].face];
  for (const auto &[rank, packed] : Utilities::MPI::some_to_some(local.communicator, answers))
    local.merge(rank, indices.at(rank), packed, matches, keys);
  return matches;
}

template class FaceLocator<2>;
template class FaceLocator<3>;

} // namespace dovetail
