// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/interface/face_locator.h>

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

double distance_quantum(const double face_size)
{
  return std::ldexp(1., std::ilogb(face_size) - 30);
}

namespace {

/// Lengths below this fraction of the face size are no distances (see the header).
constexpr double relative_tolerance = 1e-6;

/// Two polynomials of degree 2 and more that interpolate the same curve differ by much less than this
/// fraction of their height over the chord, which is O(h^2).
constexpr double fraction_of_bulge = 0.1;

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
SideFaces<dim>::SideFaces(const Triangulation<dim> &triangulation, const Mapping<dim> &mapping,
                          const unsigned int mapping_degree, const std::set<types::boundary_id> &boundary_ids)
    : SideFaces(triangulation, mapping, mapping_degree,
                [&](const auto &, const types::boundary_id id) { return boundary_ids.count(id) > 0; })
{
}

template <int dim>
SideFaces<dim>::SideFaces(const Triangulation<dim> &triangulation, const Mapping<dim> &mapping,
                          const unsigned int mapping_degree, const Selection &selection,
                          const Tensor<1, dim> &shift)
    : shape(triangulation.all_reference_cells_are_hyper_cube() ? ReferenceCells::get_hypercube<dim>()
                                                               : ReferenceCells::get_simplex<dim>(),
            mapping_degree),
      shift(shift)
{
  std::vector<std::unique_ptr<FEValues<dim>>> support_points(
      GeometryInfo<dim>::faces_per_cell); // a simplex has fewer faces
  const FE_Nothing<dim> fe(shape.cell());
  for (const auto &cell : triangulation.active_cell_iterators()) {
    if (!cell->is_locally_owned() || !cell->at_boundary())
      continue;
    for (const unsigned int f : cell->face_indices())
      if (cell->face(f)->at_boundary() && selection(cell, cell->face(f)->boundary_id())) {
        if (!support_points[f])
          support_points[f] = std::make_unique<FEValues<dim>>(
              mapping, fe, Quadrature<dim>(shape.nodes_in_cell(f)), update_quadrature_points);
        support_points[f]->reinit(cell);
        const auto &points = support_points[f]->get_quadrature_points();
        for (const Point<dim> &point : points)
          all_nodes.push_back(point + shift);
        faces.push_back(
            {cell, f, shape.diameter(points.data()), fraction_of_bulge * shape.bulge_of_rim(points.data())});
        const CellId::binary_type id = cell->id().template to_binary<dim>();
        keys.push_back({{id[0], id[1], id[2], id[3], f}});
      }
  }
}

template <int dim>
void FaceLocator<dim>::Match::set(const FaceShape<dim> &shape, const unsigned int face_no, const Query &query,
                                  const SurfacePoint<dim> &point)
{
  X = point.X;
  N = shape.normal(face_no, point);
  N /= N.norm();
  unit_point = shape.position_in_cell(face_no, point.xi);
  distance = query.X.distance(X);
  // The half-angle form keeps its digits for small angles, which the arc cosine does not.
  angle = 2 * std::asin(std::min(1., 0.5 * (query.N + N).norm()));
}

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

  using Candidates = std::vector<Candidate>;

  Implementation(SideFaces<dim> side, double search_radius, double least_reach, const MPI_Comm &communicator);

  void build_trees();

  /// The distance beyond which a face of this size is no partner.
  double reach(double face_size) const
  {
    return std::max((radius + relative_tolerance) * face_size, least_reach);
  }
  bool is_partner(const Query &query, const Match &match) const;
  BoundingBox<dim> box_of(const Query &query) const; ///< of what the asking face reaches
  Match closest(const unsigned int face, const Query &query) const;
  void search(const Query &query, Candidates &candidates, Match &best) const;

  /// The sparse exchange: to each other rank whose boxes hold them a list of queries, and their answers back.
  std::map<unsigned int, std::vector<unsigned int>>
  queries_of_other_ranks(const std::vector<Query> &queries) const;
  std::vector<double> answer(const std::vector<double> &packed_queries, Candidates &candidates) const;
  void merge(const unsigned int rank, const std::vector<unsigned int> &indices,
             const std::vector<double> &packed_answers, std::vector<Match> &matches,
             std::vector<GlobalKey> &keys) const;

  std::vector<unsigned int> faces_in(const BoundingBox<dim> &box) const;
  std::vector<double> pack_nearby(const std::vector<double> &packed_boxes) const;
  void unpack_nearby(unsigned int rank, const std::vector<unsigned int> &indices,
                     const std::vector<double> &packed, NearbyFaces &result) const;

  const SideFaces<dim> side;
  const double radius, least_reach;
  const MPI_Comm communicator;
  const unsigned int this_rank;
  const unsigned int n_ranks;

  std::vector<BoundingBox<dim>> boxes;
  BoxTree<unsigned int> face_tree;
  BoxTree<unsigned int> rank_tree; ///< the coarse boxes of the other ranks
  mutable InterfaceWork work;
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
FaceLocator<dim>::Implementation::Implementation(SideFaces<dim> side, const double search_radius,
                                                 const double least_reach, const MPI_Comm &communicator)
    : side(std::move(side)), radius(search_radius), least_reach(least_reach), communicator(communicator),
      this_rank(Utilities::MPI::this_mpi_process(communicator)),
      n_ranks(Utilities::MPI::n_mpi_processes(communicator))
{
}

template <int dim>
void FaceLocator<dim>::Implementation::build_trees()
{
  std::vector<std::pair<BoundingBox<dim>, unsigned int>> inflated;
  for (unsigned int face = 0; face < side.faces.size(); ++face) {
    boxes.push_back(side.shape.box(side.nodes(face)));
    inflated.emplace_back(boxes.back(), face);
    inflated.back().first.extend(reach(side.faces[face].size));
  }
  face_tree = pack_rtree(inflated);
  if (n_ranks == 1)
    return;

  // One level below the root: at most 16 boxes. Ranks without faces send an empty list.
  std::vector<double> corners;
  if (!side.faces.empty())
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
typename FaceLocator<dim>::Match FaceLocator<dim>::Implementation::closest(const unsigned int face,
                                                                           const Query &query) const
{
  const auto &partner = side.faces[face];
  const SurfacePoint<dim> point = side.shape.closest(side.nodes(face), query.X);
  Match match;
  match.rank = this_rank;
  match.face = face;
  match.face_size = partner.size;
  match.rim_tolerance = partner.rim_tolerance;
  match.set(side.shape, partner.face_no, query, point);

  match.found = is_partner(query, match);
  return match;
}

template <int dim>
BoundingBox<dim> FaceLocator<dim>::Implementation::box_of(const Query &query) const
{
  BoundingBox<dim> box({query.X, query.X});
  if (query.face_size > 0)
    box.extend(reach(query.face_size));
  return box;
}

template <int dim>
bool FaceLocator<dim>::Implementation::is_partner(const Query &query, const Match &match) const
{
  const Tensor<1, dim> r = match.X - query.X;
  const double normal_distance = std::abs(r * match.N);
  const double sideways = std::sqrt(std::max(0., r.norm_square() - normal_distance * normal_distance));
  return query.N * match.N < -relative_tolerance &&
         match.distance <= reach(std::max(match.face_size, query.face_size)) &&
         sideways <= std::max({relative_tolerance * match.face_size, normal_distance, match.rim_tolerance});
}

template <int dim>
void FaceLocator<dim>::Implementation::search(const Query &query, Candidates &candidates, Match &best) const
{
  candidates.clear();
  face_tree.query(boost::geometry::index::intersects(box_of(query)),
                  boost::make_function_output_iterator([&](const auto &box_and_face) {
                    const unsigned int face = box_and_face.second;
                    candidates.push_back({std::sqrt(distance_square(boxes[face], query.X)), face});
                  }));
  std::sort(candidates.begin(), candidates.end());

  for (const Candidate &candidate : candidates) {
    // Farther even after rounding both distances; 1e-8 is some of their quanta.
    if (best.found &&
        candidate.bound > best.distance + 1e-8 * (best.face_size + side.faces[candidate.face].size))
      continue;
    const Match match = closest(candidate.face, query);
    if (best.face == numbers::invalid_unsigned_int ||
        is_better(match, side.keys[match.face], best, side.keys[best.face]))
      best = match;
  }
}

template <int dim>
std::map<unsigned int, std::vector<unsigned int>>
FaceLocator<dim>::Implementation::queries_of_other_ranks(const std::vector<Query> &queries) const
{
  std::map<unsigned int, std::vector<unsigned int>> result;
  for (unsigned int i = 0; i < queries.size(); ++i)
    rank_tree.query(boost::geometry::index::intersects(box_of(queries[i])),
                    boost::make_function_output_iterator([&](const auto &box_and_rank) {
                      std::vector<unsigned int> &indices = result[box_and_rank.second];
                      if (indices.empty() ||
                          indices.back() != i) // several boxes of a rank may hold the point
                        indices.push_back(i);
                    }));
  return result;
}

namespace {

/// X, N, face size.
template <int dim>
constexpr unsigned int query_size = 2 * dim + 1;

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
                                                             Candidates &candidates) const
{
  const unsigned int n_queries = packed_queries.size() / query_size<dim>;
  std::vector<double> result(n_queries * answer_size<dim>);
  for (unsigned int i = 0; i < n_queries; ++i) {
    Query query;
    for (unsigned int d = 0; d < dim; ++d) {
      query.X[d] = packed_queries[query_size<dim> * i + d];
      query.N[d] = packed_queries[query_size<dim> * i + dim + d];
    }
    query.face_size = packed_queries[query_size<dim> * i + 2 * dim];
    Match match;
    search(query, candidates, match);
    const bool is_empty = match.face == numbers::invalid_unsigned_int;
    pack<dim>(match, is_empty ? GlobalKey() : side.keys[match.face], &result[i * answer_size<dim>]);
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
    : FaceLocator(SideFaces<dim>(triangulation, mapping, mapping_degree, boundary_ids), search_radius, 0.,
                  communicator)
{
}

template <int dim>
FaceLocator<dim>::FaceLocator(SideFaces<dim> side, const double search_radius, const double least_reach,
                              const MPI_Comm &communicator)
    : implementation(
          std::make_unique<Implementation>(std::move(side), search_radius, least_reach, communicator))
{
  implementation->build_trees();
  implementation->work.locators = 1;
}

template <int dim>
FaceLocator<dim>::~FaceLocator() = default;

template <int dim>
const SideFaces<dim> &FaceLocator<dim>::side() const
{
  return implementation->side;
}

template <int dim>
InterfaceWork &FaceLocator<dim>::work() const
{
  return implementation->work;
}

template <int dim>
bool FaceLocator<dim>::is_partner(const Query &query, const Match &match) const
{
  return implementation->is_partner(query, match);
}

template <int dim>
std::vector<typename FaceLocator<dim>::Match>
FaceLocator<dim>::locate(const std::vector<Query> &queries) const
{
  const Implementation &local = *implementation;
  typename Implementation::Candidates candidates;
  std::vector<Match> matches(queries.size());
  for (unsigned int i = 0; i < queries.size(); ++i)
    local.search(queries[i], candidates, matches[i]);
  if (local.n_ranks == 1)
    return matches;

  const auto indices = local.queries_of_other_ranks(queries);
  OfRanks sent, answers;
  for (const auto &[rank, indices_of_rank] : indices)
    for (const unsigned int i : indices_of_rank) {
      sent[rank].insert(sent[rank].end(), queries[i].X.begin_raw(), queries[i].X.end_raw());
      sent[rank].insert(sent[rank].end(), queries[i].N.begin_raw(), queries[i].N.end_raw());
      sent[rank].push_back(queries[i].face_size);
    }
  for (const auto &[rank, packed] : exchange(sent, local.communicator, local.work))
    answers[rank] = local.answer(packed, candidates);

  std::vector<GlobalKey> keys(queries.size());
  for (unsigned int i = 0; i < queries.size(); ++i)
    if (matches[i].face != numbers::invalid_unsigned_int)
      keys[i] = local.side.keys[matches[i].face];
  for (const auto &[rank, packed] : exchange(answers, local.communicator, local.work))
    local.merge(rank, indices.at(rank), packed, matches, keys);
  return matches;
}

template <int dim>
std::vector<unsigned int> FaceLocator<dim>::Implementation::faces_in(const BoundingBox<dim> &box) const
{
  std::vector<unsigned int> found;
  face_tree.query(boost::geometry::index::intersects(box),
                  boost::make_function_output_iterator(
                      [&](const auto &box_and_face) { found.push_back(box_and_face.second); }));
  return found;
}

/// The faces in some boxes, each once: n faces; index, face_no, sizes, key, nodes of each; then for every box
/// their number and positions in this list.
template <int dim>
std::vector<double>
FaceLocator<dim>::Implementation::pack_nearby(const std::vector<double> &packed_boxes) const
{
  std::map<unsigned int, unsigned int> position;
  std::vector<unsigned int> order;
  std::vector<double> of_boxes;
  for (unsigned int i = 0; i < packed_boxes.size(); i += 2 * dim) {
    std::pair<Point<dim>, Point<dim>> corners;
    for (unsigned int d = 0; d < dim; ++d) {
      corners.first[d] = packed_boxes[i + d];
      corners.second[d] = packed_boxes[i + dim + d];
    }
    const std::vector<unsigned int> found = faces_in(BoundingBox<dim>(corners));
    of_boxes.push_back(found.size());
    for (const unsigned int face : found) {
      const auto [entry, is_new] = position.emplace(face, order.size());
      if (is_new)
        order.push_back(face);
      of_boxes.push_back(entry->second);
    }
  }
  std::vector<double> packed = {double(order.size())};
  for (const unsigned int face : order) {
    const auto &of_side = side.faces[face];
    packed.insert(packed.end(), {double(face), double(of_side.face_no), of_side.size, of_side.rim_tolerance});
    packed.insert(packed.end(), side.keys[face].begin(), side.keys[face].end());
    for (unsigned int a = 0; a < side.shape.n_nodes(); ++a)
      for (unsigned int d = 0; d < dim; ++d)
        packed.push_back(side.nodes(face)[a][d]);
  }
  packed.insert(packed.end(), of_boxes.begin(), of_boxes.end());
  return packed;
}

template <int dim>
void FaceLocator<dim>::Implementation::unpack_nearby(const unsigned int rank,
                                                     const std::vector<unsigned int> &indices,
                                                     const std::vector<double> &packed,
                                                     NearbyFaces &result) const
{
  auto next = packed.begin();
  const unsigned int first = result.faces.size(), n_faces = *next++;
  for (unsigned int i = 0; i < n_faces; ++i) {
    NearbyFace face;
    face.rank = rank;
    face.index = *next++;
    face.face_no = *next++;
    face.size = *next++;
    face.rim_tolerance = *next++;
    for (unsigned int &part : face.key)
      part = *next++;
    face.nodes.resize(side.shape.n_nodes());
    for (Point<dim> &node : face.nodes)
      for (unsigned int d = 0; d < dim; ++d)
        node[d] = *next++;
    result.faces.push_back(std::move(face));
  }
  for (const unsigned int box : indices) {
    const unsigned int n = *next++;
    for (unsigned int i = 0; i < n; ++i)
      result.of_box[box].push_back(first + static_cast<unsigned int>(*next++));
  }
}

template <int dim>
typename FaceLocator<dim>::NearbyFaces FaceLocator<dim>::faces_near(std::vector<BoundingBox<dim>> boxes,
                                                                    const std::vector<double> &sizes) const
{
  const Implementation &local = *implementation;
  for (unsigned int i = 0; i < boxes.size(); ++i)
    boxes[i].extend(local.reach(sizes[i]));
  const auto pack_box = [](const BoundingBox<dim> &box, std::vector<double> &packed) {
    const auto &[lower, upper] = box.get_boundary_points();
    packed.insert(packed.end(), lower.begin_raw(), lower.end_raw());
    packed.insert(packed.end(), upper.begin_raw(), upper.end_raw());
  };
  std::map<unsigned int, std::vector<unsigned int>> indices;
  OfRanks sent, answers;
  std::vector<unsigned int> all;
  std::vector<double> packed_all;
  for (unsigned int i = 0; i < boxes.size(); ++i) {
    all.push_back(i);
    pack_box(boxes[i], packed_all);
    local.rank_tree.query(boost::geometry::index::intersects(boxes[i]),
                          boost::make_function_output_iterator([&](const auto &box_and_rank) {
                            std::vector<unsigned int> &of_rank = indices[box_and_rank.second];
                            if (!of_rank.empty() && of_rank.back() == i)
                              return; // another box of this rank
                            of_rank.push_back(i);
                            pack_box(boxes[i], sent[box_and_rank.second]);
                          }));
  }
  NearbyFaces result;
  result.of_box.resize(boxes.size());
  local.unpack_nearby(local.this_rank, all, local.pack_nearby(packed_all), result);
  if (local.n_ranks > 1) {
    const std::size_t n_own = result.faces.size();
    for (const auto &[rank, packed] : exchange(sent, local.communicator, local.work))
      answers[rank] = local.pack_nearby(packed);
    for (const auto &[rank, packed] : exchange(answers, local.communicator, local.work))
      local.unpack_nearby(rank, indices.at(rank), packed, result);
    local.work.faces += result.faces.size() - n_own;
  }
  for (std::vector<unsigned int> &of_box : result.of_box)
    std::sort(of_box.begin(), of_box.end(), [&](const unsigned int i, const unsigned int j) {
      return result.faces[i].key < result.faces[j].key;
    });
  return result;
}

template class SideFaces<2>;
template class SideFaces<3>;
template class FaceLocator<2>;
template class FaceLocator<3>;

} // namespace dovetail
