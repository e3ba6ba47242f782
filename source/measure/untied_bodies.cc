// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/bulges.h>
#include <dovetail/measure/meeting_bodies.h>
#include <dovetail/pairing/face_points.h>
#include <dovetail/pairing/facing_boundaries.h>
#include <dovetail/pairing/pairing.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_untied_bodies("untied bodies", "bodies touch each other where nothing ties them");

const double search_radius_of_touch = 0.2; ///< of the face size
const double largest_angle_of_touch = dealii::numbers::PI / 12;
const double least_touching_area = 0.5; ///< of a face of the usual size
const double uncertainty_of_bulge = 0.15;
const double rounding_of_touch = 1e-4; ///< of the face size; coordinates in files have six digits

/// The extent of the faces of a boundary id over all ranks.
template <int dim>
struct Extent
{
  dealii::Point<dim> low, high;
  double largest_face = 0;
  double thinnest_cell = std::numeric_limits<double>::infinity(); ///< |K| / (diameter of the face)^(dim - 1)
};

template <int dim>
using Extents = std::map<dealii::types::boundary_id, Extent<dim>>;

/// Collective.
template <int dim>
Extents<dim> extents_of(const Domain<dim> &domain, const MPI_Comm &communicator)
{
  const double infinity = std::numeric_limits<double>::infinity();
  Extents<dim> extents;
  for (const auto id : domain.boundary_ids()) {
    Extent<dim> &extent = extents[id];
    for (unsigned int d = 0; d < dim; ++d) {
      extent.low[d] = infinity;
      extent.high[d] = -infinity;
    }
  }
  for (const auto &face : domain.boundary_faces())
    if (face.cell->is_locally_owned()) {
      Extent<dim> &extent = extents.at(face.id);
      const auto shape = face.cell->face(face.number);
      const double diameter = shape->diameter();
      extent.largest_face = std::max(extent.largest_face, diameter);
      extent.thinnest_cell =
          std::min(extent.thinnest_cell, face.cell->measure() / std::pow(diameter, dim - 1));
      for (const unsigned int v : shape->vertex_indices())
        for (unsigned int d = 0; d < dim; ++d) {
          extent.low[d] = std::min(extent.low[d], shape->vertex(v)[d]);
          extent.high[d] = std::max(extent.high[d], shape->vertex(v)[d]);
        }
    }
  for (auto &entry : extents) {
    Extent<dim> &extent = entry.second;
    extent.largest_face = dealii::Utilities::MPI::max(extent.largest_face, communicator);
    extent.thinnest_cell = dealii::Utilities::MPI::min(extent.thinnest_cell, communicator);
    for (unsigned int d = 0; d < dim; ++d) {
      extent.low[d] = dealii::Utilities::MPI::min(extent.low[d], communicator);
      extent.high[d] = dealii::Utilities::MPI::max(extent.high[d], communicator);
    }
  }
  return extents;
}

/// Whether the boxes have a surface in common, not only an edge.
template <int dim>
bool may_touch(const Extent<dim> &one, const Extent<dim> &other)
{
  const double reach = search_radius_of_touch * std::min(one.largest_face, other.largest_face);
  unsigned int n_long = 0;
  for (unsigned int d = 0; d < dim; ++d) {
    const double common = std::min(one.high[d], other.high[d]) - std::max(one.low[d], other.low[d]);
    if (!(common > -reach))
      return false;
    n_long += common > reach ? 1 : 0;
  }
  return n_long + 1 >= dim;
}

template <int dim>
bool is_tied(const Model<dim> &model, const std::array<const Domain<dim> *, 2> &bodies,
             const std::array<dealii::types::boundary_id, 2> &ids)
{
  return std::any_of(model.interfaces.begin(), model.interfaces.end(), [&](const auto &interface) {
    for (const unsigned int first : {source, destination}) {
      const auto &one = interface->sides[first], &other = interface->sides[1 - first];
      if (one.domain == bodies[0] && other.domain == bodies[1] && one.boundary_ids.count(ids[0]) > 0 &&
          other.boundary_ids.count(ids[1]) > 0)
        return true;
    }
    return false;
  });
}

/// Whether a third body is tied to both boundaries, as a thin plate that lies between them is.
template <int dim>
bool have_body_between(const Model<dim> &model, const std::array<const Domain<dim> *, 2> &bodies,
                       const std::array<dealii::types::boundary_id, 2> &ids)
{
  std::array<std::set<const Domain<dim> *>, 2> partners;
  for (const auto &interface : model.interfaces)
    for (const unsigned int first : {source, destination})
      for (const unsigned int side : {0, 1})
        if (interface->sides[first].domain == bodies[side] &&
            interface->sides[first].boundary_ids.count(ids[side]) > 0)
          partners[side].insert(interface->sides[1 - first].domain);
  return std::any_of(partners[0].begin(), partners[0].end(), [&](const auto *partner) {
    return partner != bodies[0] && partner != bodies[1] && partners[1].count(partner) > 0;
  });
}

/// Whether somebody has thought of the boundary: a condition acts on a field that both bodies have.
template <int dim>
bool has_condition(const Domain<dim> &body, const dealii::types::boundary_id id, const Domain<dim> &other)
{
  return std::any_of(body.conditions().begin(), body.conditions().end(), [&](const auto &condition) {
    return condition->boundary_ids.count(id) > 0 &&
           other.material.find_field(condition->field.name) != nullptr;
  });
}

template <typename T>
std::vector<T> gathered(const T &own, const MPI_Comm &communicator)
{
  if (dealii::Utilities::MPI::n_mpi_processes(communicator) == 1)
    return {own}; // else it would be packed and unpacked
  return dealii::Utilities::MPI::all_gather(communicator, own);
}

template <int dim>
using Cell = typename dealii::Triangulation<dim>::active_cell_iterator;

template <int dim>
bool is_near(const Extent<dim> &other, const Cell<dim> &cell, const double reach)
{
  for (unsigned int d = 0; d < dim; ++d) {
    double low = cell->vertex(0)[d], high = low;
    for (const unsigned int v : cell->vertex_indices()) {
      low = std::min(low, cell->vertex(v)[d]);
      high = std::max(high, cell->vertex(v)[d]);
    }
    if (!(low < other.high[d] + reach && high > other.low[d] - reach))
      return false;
  }
  return true;
}

/// The faces of a boundary in whose reach the box of another one is.
template <int dim>
SideFaces<dim> faces_near(const Extent<dim> &other, const Domain<dim> &body,
                          const dealii::types::boundary_id own_id, const double reach)
{
  return SideFaces<dim>(
      body.mesh(), body.mapping(), body.mapping_degree(),
      [&](const auto &cell, const auto id) { return id == own_id && is_near<dim>(other, cell, reach); });
}

/// A face with what is near enough for a search to find it: the low and the high corner of the box and the
/// normal outward, of any length.
template <int dim>
using FaceBox = std::array<double, 3 * dim>;

template <int dim>
FaceBox<dim> box_of(const Cell<dim> &cell, const unsigned int face_no,
                    const std::vector<dealii::Point<dim>> &nodes, const double size)
{
  const auto shape = cell->face(face_no);
  FaceBox<dim> box;
  for (unsigned int d = 0; d < dim; ++d) {
    double low = nodes[0][d], high = low;
    for (const auto &node : nodes) {
      low = std::min(low, node[d]);
      high = std::max(high, node[d]);
    }
    box[d] = low - search_radius_of_touch * size;
    box[dim + d] = high + search_radius_of_touch * size;
  }
  dealii::Tensor<1, dim> normal;
  if constexpr (dim == 2)
    normal = dealii::cross_product_2d(shape->vertex(1) - shape->vertex(0));
  else {
    const bool is_triangle = shape->n_vertices() == 3;
    normal = dealii::cross_product_3d(shape->vertex(is_triangle ? 1 : 3) - shape->vertex(0),
                                      shape->vertex(2) - shape->vertex(is_triangle ? 0 : 1));
  }
  const double sign = normal * (shape->center() - cell->center()) < 0 ? -1 : 1;
  for (unsigned int d = 0; d < dim; ++d)
    box[2 * dim + d] = sign * normal[d];
  return box;
}

/// Those of faces_near() and their cells, by the active index.
template <int dim>
struct BoxesOfSide
{
  std::vector<FaceBox<dim>> boxes;
  std::vector<unsigned int> cells;
};

template <int dim>
BoxesOfSide<dim> boxes_near(const Extent<dim> &other, const Domain<dim> &body,
                            const dealii::types::boundary_id own_id, const double reach)
{
  BoxesOfSide<dim> result;
  std::vector<dealii::Point<dim>> nodes;
  const auto add = [&](const Cell<dim> &cell, const unsigned int face_no, const double size) {
    result.boxes.push_back(box_of<dim>(cell, face_no, nodes, size));
    result.cells.push_back(cell->active_cell_index());
  };
  if (body.mapping_degree() > 1) {
    const SideFaces<dim> side = faces_near(other, body, own_id, reach);
    for (unsigned int i = 0; i < side.faces.size(); ++i) {
      nodes.assign(side.nodes(i), side.nodes(i) + side.shape.n_nodes());
      add(side.faces[i].cell, side.faces[i].face_no, side.faces[i].size);
    }
    return result;
  }
  for (const auto &face : body.boundary_faces())
    if (face.id == own_id && face.cell->is_locally_owned() && is_near<dim>(other, face.cell, reach)) {
      const auto shape = face.cell->face(face.number);
      nodes.clear();
      double size = 0;
      for (const unsigned int v : shape->vertex_indices()) {
        for (const auto &node : nodes)
          size = std::max(size, node.distance(shape->vertex(v)));
        nodes.push_back(shape->vertex(v));
      }
      add(face.cell, face.number, size);
    }
  return result;
}

/// What touches turns by less than a right angle, also where two straight faces are chords of one circle.
template <int dim>
bool may_touch(const FaceBox<dim> &one, const FaceBox<dim> &other, const bool are_straight)
{
  double product = 0, squares[] = {0, 0};
  for (unsigned int d = 0; d < dim; ++d) {
    if (one[d] > other[dim + d] || one[dim + d] < other[d])
      return false;
    product += one[2 * dim + d] * other[2 * dim + d];
    squares[0] += one[2 * dim + d] * one[2 * dim + d];
    squares[1] += other[2 * dim + d] * other[2 * dim + d];
  }
  return !are_straight || product < -0.01 * std::sqrt(squares[0] * squares[1]);
}

/// The own cells, by their active index, with a face that may touch one of the other side. On small sides
/// this is cheaper than a search, which mostly finds nothing; of large ones all cells are given. Collective.
template <int dim>
std::set<unsigned int> cells_that_may_touch(const BoxesOfSide<dim> &own, const BoxesOfSide<dim> &other,
                                            const bool are_straight, const MPI_Comm &communicator)
{
  if (dealii::Utilities::MPI::sum(1. * own.boxes.size(), communicator) *
          dealii::Utilities::MPI::sum(1. * other.boxes.size(), communicator) >
      1e6)
    return {own.cells.begin(), own.cells.end()};
  std::set<unsigned int> cells;
  const auto of_ranks = gathered(other.boxes, communicator);
  for (unsigned int i = 0; i < own.boxes.size(); ++i)
    for (const auto &boxes : of_ranks)
      if (std::any_of(boxes.begin(), boxes.end(), [&](const FaceBox<dim> &one) {
            return may_touch<dim>(own.boxes[i], one, are_straight);
          }))
        cells.insert(own.cells[i]);
  return cells;
}

/// Where the faces of one side face another one, and how far the smooth surfaces are from both. With a body
/// between them only what has no distance touches.
template <int dim>
class TouchingFaces
{
public:
  /// Collective.
  TouchingFaces(const std::array<const Domain<dim> *, 2> &bodies,
                const std::array<dealii::types::boundary_id, 2> &ids, const SideFaces<dim> &own,
                SideFaces<dim> other, const double thinnest_cell, const bool has_body_between,
                const MPI_Comm &communicator)
      : cells{{own.shape.cell(), other.shape.cell()}}, thinnest_cell(thinnest_cell),
        has_body_between(has_body_between)
  {
    if (bodies[0]->mapping_degree() == 1)
      own_bulges = Bulges<dim>(*bodies[0], ids[0], own).of_face;
    std::map<unsigned int, typename Bulges<dim>::OfFace> others;
    if (bodies[1]->mapping_degree() == 1)
      others = Bulges<dim>(*bodies[1], ids[1], other).of_face;
    other_bulges = gathered(others, communicator);
    const FaceLocator<dim> locator(std::move(other), search_radius_of_touch, 0., communicator);
    points = segments(own, locator, 1, 1);
    for (unsigned int q = 0; q < points.size(); ++q)
      if (is_facing(q) && points.matches[q].angle <= largest_angle_of_touch)
        largest_angle = std::max(largest_angle, points.matches[q].angle);
    largest_angle = dealii::Utilities::MPI::max(largest_angle, communicator);
  }

  /// Of this rank.
  double area() const
  {
    double sum = 0;
    for (unsigned int q = 0; q < points.size(); ++q)
      if (is_facing(q) && (facets_touch(q) || surfaces_touch(q)))
        sum += points.JxW[q];
    return sum;
  }

private:
  /// Not behind the thinnest cell: the far sides of two thin bodies look at each other through both.
  bool is_facing(const unsigned int q) const
  {
    const auto &match = points.matches[q];
    return match.found && (match.X - points.queries[q].X) * points.queries[q].N > -thinnest_cell;
  }

  double face_size(const unsigned int q) const
  {
    return std::min(points.matches[q].face_size, points.queries[q].face_size);
  }

  const typename Bulges<dim>::OfFace *bulges_of(const unsigned int q, const unsigned int side) const
  {
    const auto &bulges = side == 0 ? own_bulges : other_bulges[points.matches[q].rank];
    const auto found = bulges.find(side == 0 ? points.face[q] : points.matches[q].face);
    return found == bulges.end() ? nullptr : &found->second;
  }

  /// Coarse facets must do so exactly: what bounds the distance of others would bridge a true gap.
  bool facets_touch(const unsigned int q) const
  {
    if (has_body_between && points.matches[q].distance > rounding_of_touch * face_size(q))
      return false;
    const bool are_coarse = bulges_of(q, 0) != nullptr || bulges_of(q, 1) != nullptr;
    return points.matches[q].angle <= (are_coarse ? 0.01 : largest_angle_of_touch) &&
           points.matches[q].distance <= distance_of_facets(face_size(q), are_coarse ? 0. : largest_angle);
  }

  /// One side of a hexagon and one of an octagon in the same circle are up to an eighth of their length
  /// apart, and turned by up to half of what both turn.
  bool surfaces_touch(const unsigned int q) const
  {
    if (has_body_between)
      return false;
    const auto &match = points.matches[q];
    dealii::Tensor<1, dim> gap = match.X - points.queries[q].X;
    double turn = 0, height = 0;
    for (const unsigned int side : {0, 1})
      if (const auto *bulges = bulges_of(q, side)) {
        double half_turn = 0;
        for (const Bulge<dim> &bulge : *bulges) {
          half_turn = std::max(half_turn, bulge.half_turn);
          height = std::max(height, bulge.height.norm());
        }
        turn += half_turn;
        gap += side == 0 ? -height_at(points.unit_points[q], cells[0], *bulges)
                         : height_at(match.unit_point, cells[1], *bulges);
      }
    const dealii::Tensor<1, dim> N = points.queries[q].N - match.N;
    return height > 0 && match.angle <= largest_angle_of_touch + turn &&
           std::abs(gap * N) <=
               N.norm() * (distance_of_facets(face_size(q), 0.) + uncertainty_of_bulge * height);
  }

  const std::array<dealii::ReferenceCell, 2> cells;
  const double thinnest_cell;
  const bool has_body_between;
  std::map<unsigned int, typename Bulges<dim>::OfFace> own_bulges;
  std::vector<std::map<unsigned int, typename Bulges<dim>::OfFace>> other_bulges; ///< of each rank
  FacePoints<dim> points;
  double largest_angle = 0; ///< of what faces each other
};

/// Of the first body. Collective.
template <int dim>
double touching_area(const std::array<const Domain<dim> *, 2> &bodies,
                     const std::array<dealii::types::boundary_id, 2> &ids,
                     const std::array<const Extent<dim> *, 2> &extents, const bool has_body_between,
                     const MPI_Comm &communicator)
{
  const double thinnest_cell = std::min(extents[0]->thinnest_cell, extents[1]->thinnest_cell);
  const double reach = search_radius_of_touch * std::max(extents[0]->largest_face, extents[1]->largest_face);
  const Domain<dim> &body = *bodies[0];
  const auto cells = cells_that_may_touch(
      boxes_near(*extents[1], body, ids[0], reach), boxes_near(*extents[0], *bodies[1], ids[1], reach),
      body.mapping_degree() == 1 && bodies[1]->mapping_degree() == 1, communicator);
  if (dealii::Utilities::MPI::max(static_cast<unsigned int>(cells.size()), communicator) == 0)
    return 0;
  const SideFaces<dim> own(body.mesh(), body.mapping(), body.mapping_degree(),
                           [&](const auto &cell, const auto id) {
                             return id == ids[0] && cells.count(cell->active_cell_index()) > 0;
                           });
  const TouchingFaces<dim> faces(bodies, ids, own, faces_near(*extents[0], *bodies[1], ids[1], reach),
                                 thinnest_cell, has_body_between, communicator);
  return dealii::Utilities::MPI::sum(faces.area(), communicator);
}

/// The note on two bodies with the boundaries that touch, if there are any.
template <int dim>
void add_notes_on_pair(const Model<dim> &model, const std::array<const Domain<dim> *, 2> &bodies,
                       const std::array<const Extents<dim> *, 2> &extents, NoteList &notes)
{
  std::ostringstream words;
  words.precision(3);
  for (const auto &[id, extent] : *extents[0])
    for (const auto &[other_id, other_extent] : *extents[1]) {
      if (!may_touch(extent, other_extent) || is_tied(model, bodies, {{id, other_id}}) ||
          (has_condition(*bodies[0], id, *bodies[1]) && has_condition(*bodies[1], other_id, *bodies[0])))
        continue;
      const double area =
          touching_area<dim>(bodies, {{id, other_id}}, {{&extent, &other_extent}},
                             have_body_between(model, bodies, {{id, other_id}}), model.communicator);
      const double face = std::min(extent.largest_face, other_extent.largest_face);
      if (area > least_touching_area * (dim == 2 ? face : face * face))
        words << (words.str().empty() ? "" : ", ") << bodies[0]->name << " : " << id << " and "
              << bodies[1]->name << " : " << other_id << " (area " << area << ')';
    }
  if (!words.str().empty())
    notes.push_back(of_untied_bodies(
        words.str() + " touch each other, but no interface ties them: nothing passes through. Add an "
                      "Interface, or leave it so if they are meant to be apart"));
}

} // namespace

template <int dim>
NoteList notes_on_untied_bodies(const Model<dim> &model)
{
  NoteList notes;
  std::map<const Domain<dim> *, Extents<dim>> extents;
  const auto of = [&](const Domain<dim> &body) -> const Extents<dim> & {
    if (const auto found = extents.find(&body); found != extents.end())
      return found->second;
    return extents[&body] = extents_of(body, model.communicator);
  };
  for (unsigned int i = 0; i < model.domains.size(); ++i)
    for (unsigned int j = i + 1; j < model.domains.size(); ++j) {
      const Domain<dim> &one = *model.domains[i], &other = *model.domains[j];
      if (share_a_field(one, other) &&
          one.centre().distance(other.centre()) <= 0.6 * (one.typical_length() + other.typical_length())) {
        const Extents<dim> &one_extents = of(one), &other_extents = of(other);
        add_notes_on_pair<dim>(model, {{&one, &other}}, {{&one_extents, &other_extents}}, notes);
      }
    }
  return notes;
}

template NoteList notes_on_untied_bodies(const Model<2> &);
template NoteList notes_on_untied_bodies(const Model<3> &);

} // namespace dovetail
