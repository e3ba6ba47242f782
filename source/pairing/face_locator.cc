// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/pairing/face_locator.h>

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

  /// The best match of a rank, and the key of its face if there is one.
  struct Answer
  {
    Match match;
    GlobalKey key;

    template <typename Archive>
    void serialize(Archive &archive, const unsigned int)
    {
      archive &match &key;
    }
  };
  Answer answer(const Query &query, Candidates &candidates) const;

  /// For each other rank the indices of the boxes that its own ones meet.
  RankMap<std::vector<unsigned int>> boxes_of_other_ranks(const std::vector<BoundingBox<dim>> &boxes) const;
  /// The faces of this rank in some boxes.
  NearbyFaces faces_in(const std::vector<BoundingBox<dim>> &boxes) const;

  const SideFaces<dim> side;
  const double radius, least_reach;
  const MPI_Comm communicator;
  const unsigned int this_rank;
  const unsigned int n_ranks;

  std::vector<BoundingBox<dim>> boxes;
  BoxTree<unsigned int> face_tree;
  BoxTree<unsigned int> rank_tree; ///< the coarse boxes of the other ranks
  mutable InterfaceWork work;      ///< counted by collective calls, so never by two threads at once
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
  std::vector<BoundingBox<dim>> own;
  if (!side.faces.empty())
    own = extract_rtree_level(face_tree, 0);
  std::vector<std::pair<BoundingBox<dim>, unsigned int>> coarse;
  const auto gathered = Utilities::MPI::all_gather(communicator, own);
  for (unsigned int rank = 0; rank < n_ranks; ++rank)
    for (const BoundingBox<dim> &box : gathered[rank])
      if (rank != this_rank)
        coarse.emplace_back(box, rank);
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
RankMap<std::vector<unsigned int>>
FaceLocator<dim>::Implementation::boxes_of_other_ranks(const std::vector<BoundingBox<dim>> &boxes) const
{
  RankMap<std::vector<unsigned int>> result;
  for (unsigned int i = 0; i < boxes.size(); ++i)
    rank_tree.query(boost::geometry::index::intersects(boxes[i]),
                    boost::make_function_output_iterator([&](const auto &box_and_rank) {
                      std::vector<unsigned int> &indices = result[box_and_rank.second];
                      if (indices.empty() || indices.back() != i) // a rank has several boxes
                        indices.push_back(i);
                    }));
  return result;
}

template <int dim>
typename FaceLocator<dim>::Implementation::Answer
FaceLocator<dim>::Implementation::answer(const Query &query, Candidates &candidates) const
{
  Answer result = {};
  search(query, candidates, result.match);
  if (result.match.face != numbers::invalid_unsigned_int)
    result.key = side.keys[result.match.face];
  return result;
}

namespace {

/// The objects with some indices, for each rank.
template <typename T>
RankMap<std::vector<T>> select(const std::vector<T> &objects,
                               const RankMap<std::vector<unsigned int>> &indices)
{
  RankMap<std::vector<T>> result;
  for (const auto &[rank, rank_part] : indices)
    for (const unsigned int i : rank_part)
      result[rank].push_back(objects[i]);
  return result;
}

} // namespace

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
  std::vector<Match> matches;
  std::vector<GlobalKey> keys;
  std::vector<BoundingBox<dim>> boxes;
  for (const Query &query : queries) {
    const auto [match, key] = local.answer(query, candidates);
    matches.push_back(match);
    keys.push_back(key);
    boxes.push_back(local.box_of(query));
  }
  if (local.n_ranks == 1)
    return matches;

  const auto indices = local.boxes_of_other_ranks(boxes);
  RankMap<std::vector<typename Implementation::Answer>> answers;
  for (const auto &[rank, rank_part] : exchange(select(queries, indices), local.communicator, local.work))
    for (const Query &query : rank_part)
      answers[rank].push_back(local.answer(query, candidates));
  for (const auto &[rank, rank_part] : exchange(std::move(answers), local.communicator, local.work))
    for (unsigned int i = 0; i < rank_part.size(); ++i) {
      const auto &[match, key] = rank_part[i];
      const unsigned int query = indices.at(rank)[i];
      if (match.face != numbers::invalid_unsigned_int &&
          (matches[query].face == numbers::invalid_unsigned_int ||
           is_better(match, key, matches[query], keys[query]))) {
        matches[query] = match;
        keys[query] = key;
      }
    }
  return matches;
}

template <int dim>
typename FaceLocator<dim>::NearbyFaces
FaceLocator<dim>::Implementation::faces_in(const std::vector<BoundingBox<dim>> &in_boxes) const
{
  NearbyFaces result;
  std::map<unsigned int, unsigned int> position; // in the result, each face once
  const auto add = [&](const unsigned int index) {
    const auto [entry, is_new] = position.emplace(index, result.faces.size());
    result.faces_in_box.back().push_back(entry->second);
    if (!is_new)
      return;
    const auto &face = side.faces[index];
    const Point<dim> *nodes = side.nodes(index);
    result.faces.push_back({this_rank,
                            index,
                            face.face_no,
                            face.size,
                            face.rim_tolerance,
                            side.keys[index],
                            {nodes, nodes + side.shape.n_nodes()}});
  };
  for (const BoundingBox<dim> &box : in_boxes) {
    result.faces_in_box.emplace_back();
    face_tree.query(
        boost::geometry::index::intersects(box),
        boost::make_function_output_iterator([&](const auto &box_and_face) { add(box_and_face.second); }));
  }
  return result;
}

template <int dim>
typename FaceLocator<dim>::NearbyFaces FaceLocator<dim>::faces_near(std::vector<BoundingBox<dim>> boxes,
                                                                    const std::vector<double> &sizes) const
{
  const Implementation &local = *implementation;
  for (unsigned int i = 0; i < boxes.size(); ++i)
    boxes[i].extend(local.reach(sizes[i]));
  NearbyFaces result = local.faces_in(boxes);
  if (local.n_ranks > 1) {
    const std::size_t n_own = result.faces.size();
    const auto indices = local.boxes_of_other_ranks(boxes);
    RankMap<NearbyFaces> answers;
    for (const auto &[rank, rank_part] : exchange(select(boxes, indices), local.communicator, local.work))
      answers[rank] = local.faces_in(rank_part);
    for (const auto &[rank, nearby] : exchange(std::move(answers), local.communicator, local.work)) {
      const unsigned int first = result.faces.size();
      result.faces.insert(result.faces.end(), nearby.faces.begin(), nearby.faces.end());
      for (unsigned int i = 0; i < nearby.faces_in_box.size(); ++i)
        for (const unsigned int face : nearby.faces_in_box[i])
          result.faces_in_box[indices.at(rank)[i]].push_back(first + face);
    }
    local.work.faces += result.faces.size() - n_own;
  }
  for (std::vector<unsigned int> &faces_in_box : result.faces_in_box)
    std::sort(faces_in_box.begin(), faces_in_box.end(), [&](const unsigned int i, const unsigned int j) {
      return result.faces[i].key < result.faces[j].key;
    });
  return result;
}

template class SideFaces<2>;
template class SideFaces<3>;
template class FaceLocator<2>;
template class FaceLocator<3>;

} // namespace dovetail
