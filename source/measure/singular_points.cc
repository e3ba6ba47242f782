// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/singular_points.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace dovetail {

namespace {

/// A direction in which a flat boundary face goes on from a point on it.
template <int dim>
struct FaceAtPoint
{
  unsigned int domain = 0;
  dealii::types::boundary_id id = 0;
  double size = 0;
  dealii::Point<dim> beside; ///< on the face, away from the point
  dealii::Tensor<1, dim> N;

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &domain &id &size &beside &N;
  }
};

/// By the vertices, as if the face was flat.
template <int dim>
dealii::Tensor<1, dim> outward_normal(const typename Domain<dim>::BoundaryFace &face)
{
  const auto shape = face.cell->face(face.number);
  dealii::Tensor<1, dim> N;
  const dealii::Tensor<1, dim> first = shape->vertex(1) - shape->vertex(0);
  if constexpr (dim == 2)
    N = dealii::cross_product_2d(first);
  else {
    const dealii::Tensor<1, dim> second = shape->vertex(2) - shape->vertex(0);
    N = dealii::cross_product_3d(first, second);
  }
  N /= N.norm();
  return N * (shape->center() - face.cell->center()) < 0 ? -N : N;
}

/// How far a point is outside of a flat face with convex outline, in its plane.
template <int dim>
double distance_beside(const typename Domain<dim>::BoundaryFace &face, const dealii::Point<dim> &X)
{
  const auto shape = face.cell->face(face.number);
  double outside = 0;
  if constexpr (dim == 2) {
    dealii::Tensor<1, dim> along = shape->vertex(1) - shape->vertex(0);
    along /= along.norm();
    outside = std::max((X - shape->vertex(1)) * along, (shape->vertex(0) - X) * along);
  } else
    for (const unsigned int l : shape->line_indices()) {
      const dealii::Point<dim> begin = shape->line(l)->vertex(0);
      dealii::Tensor<1, dim> along = shape->line(l)->vertex(1) - begin;
      along /= along.norm();
      dealii::Tensor<1, dim> inward = shape->center() - begin;
      inward -= (inward * along) * along;
      outside = std::max(outside, -((X - begin) * inward) / inward.norm());
    }
  return outside;
}

/// Whether a point lies on a face up to a distance.
template <int dim>
bool holds_point(const typename Domain<dim>::BoundaryFace &face, const dealii::Point<dim> &X,
                 const double tolerance)
{
  const auto shape = face.cell->face(face.number);
  return shape->center().distance(X) <= shape->diameter() + tolerance &&
         std::abs((X - shape->center()) * outward_normal<dim>(face)) <= tolerance &&
         distance_beside<dim>(face, X) <= tolerance;
}

/// From a point on a face towards each of its vertices, half of the way.
template <int dim>
void add_directions(const unsigned int domain, const typename Domain<dim>::BoundaryFace &face,
                    const dealii::Point<dim> &X, std::vector<FaceAtPoint<dim>> &directions)
{
  const auto shape = face.cell->face(face.number);
  for (const unsigned int v : shape->vertex_indices())
    if (shape->vertex(v).distance(X) > 0.1 * shape->diameter())
      directions.push_back(
          {domain, face.id, shape->diameter(), X + 0.5 * (shape->vertex(v) - X), outward_normal<dim>(face)});
}

/// Of all bodies and ranks; an axis of revolution lies inside of its body. Collective.
template <int dim>
std::vector<FaceAtPoint<dim>> faces_at(const Model<dim> &model, const dealii::Point<dim> &X)
{
  std::vector<FaceAtPoint<dim>> own;
  for (unsigned int d = 0; d < model.domains.size(); ++d)
    for (const auto &face : model.domains[d]->boundary_faces())
      if (face.cell->is_locally_owned() &&
          !model.domains[d]->is_on_axis(face.cell->face(face.number)->center()) &&
          holds_point<dim>(face, X, 1e-6 * face.cell->face(face.number)->diameter()))
        add_directions<dim>(d, face, X, own);
  std::vector<FaceAtPoint<dim>> all;
  for (const auto &of_rank : dealii::Utilities::MPI::all_gather(model.communicator, own))
    all.insert(all.end(), of_rank.begin(), of_rank.end());
  return all;
}

/// Whether a side lies opposite to a face there. Collective.
template <int dim>
bool faces_side(const FaceAtPoint<dim> &face, const InterfaceSide<dim> &other, const MPI_Comm &communicator)
{
  const auto &faces = other.domain->boundary_faces();
  const bool found = std::any_of(faces.begin(), faces.end(), [&](const auto &candidate) {
    return other.boundary_ids.count(candidate.id) > 0 &&
           holds_point<dim>(candidate, face.beside, 0.1 * face.size);
  });
  return dealii::Utilities::MPI::max(found ? 1 : 0, communicator) > 0;
}

template <int dim>
bool is_of_side(const Model<dim> &model, const FaceAtPoint<dim> &face, const InterfaceSide<dim> &side)
{
  return model.domains[face.domain].get() == side.domain && side.boundary_ids.count(face.id) > 0;
}

/// Whether a face at X leads out of the plane of another one, to its outer side. An edge that is curved does
/// so by some per cent of the length.
template <int dim>
bool rises_above(const FaceAtPoint<dim> &face, const FaceAtPoint<dim> &plane, const dealii::Point<dim> &X)
{
  const dealii::Tensor<1, dim> direction = face.beside - X;
  return direction * plane.N > 0.2 * direction.norm();
}

/// Whether two free faces at X enclose more than 225 degrees of material.
template <int dim>
bool turn_back(const FaceAtPoint<dim> &one, const FaceAtPoint<dim> &other, const dealii::Point<dim> &X)
{
  const double cosine_of_turn = std::sqrt(0.5);
  return one.N * other.N < cosine_of_turn && rises_above(one, other, X) && rises_above(other, one, X);
}

/// The faces at a point: where interfaces tie it, and the free ones, which no interface has.
template <int dim>
struct Corner
{
  std::vector<FaceAtPoint<dim>> free;
  std::vector<FaceAtPoint<dim>> bonded;    ///< one of each interface of different materials
  std::set<std::set<unsigned int>> joined; ///< domains
};

template <int dim>
Corner<dim> corner_at(const Model<dim> &model, const dealii::Point<dim> &X)
{
  const auto faces = faces_at(model, X);
  std::vector<bool> is_free(faces.size(), true);
  Corner<dim> corner;
  for (const auto &interface : model.interfaces) {
    std::array<const FaceAtPoint<dim> *, 2> found{{nullptr, nullptr}};
    for (unsigned int i = 0; i < faces.size(); ++i)
      for (const unsigned int side : {source, destination})
        if (is_of_side(model, faces[i], interface->sides[side]) &&
            faces_side(faces[i], interface->sides[1 - side], model.communicator)) {
          is_free[i] = false;
          found[side] = &faces[i];
        }
    if (found[source] == nullptr || found[destination] == nullptr)
      continue;
    corner.joined.insert({found[source]->domain, found[destination]->domain});
    if (&interface->sides[source].domain->material != &interface->sides[destination].domain->material)
      corner.bonded.push_back(*found[source]);
  }
  for (unsigned int i = 0; i < faces.size(); ++i)
    if (is_free[i])
      corner.free.push_back(faces[i]);
  return corner;
}

} // namespace

namespace {

/// How a face holds a field at the time t.
enum class Hold { nothing, parts, all };

template <int dim>
Hold hold_of(const Model<dim> &model, const FaceAtPoint<dim> &face, const Field &field, const double t)
{
  unsigned int n_held = 0;
  bool holds_normal = false;
  for (const auto &condition : model.domains[face.domain]->conditions())
    if (condition->boundary_ids.count(face.id) > 0 && condition->field.name == field.name &&
        !condition->follows_fields() && condition->is_active(t)) {
      if (condition->constrains_normal()) // its components are those of the normals of all its planes
        holds_normal = true;
      else
        n_held += condition->prescribed_components().size();
    }
  return n_held >= field.n_components ? Hold::all : n_held > 0 || holds_normal ? Hold::parts : Hold::nothing;
}

/// Whether the flux grows without bound where a face that is held meets one that is free. The angle between
/// them in the material is 180 degrees less that between their normals, or more at a re-entrant corner. The
/// exponent of a scalar is pi / (2 angle) (singular beyond 90 degrees); that of a clamped displacement is
/// less than 1 beyond some 60 degrees, depending on Poisson's ratio (Williams 1952). One that is held along
/// one direction is half of a free wedge of twice the angle.
template <int dim>
bool is_singular_end(const FaceAtPoint<dim> &held, const Hold hold, const FaceAtPoint<dim> &free,
                     const Field &field, const dealii::Point<dim> &X)
{
  const bool is_clamped = hold == Hold::all && field.n_components > 1;
  const double smallest_cosine =
      is_clamped ? -0.3 : 0.4; // of the normals: 72 and 114 degrees; facets turn some
  return held.N * free.N > smallest_cosine || (rises_above(held, free, X) && rises_above(free, held, X));
}

template <int dim>
bool has_singular_end(const Model<dim> &model, const Corner<dim> &corner, const Field &field,
                      const dealii::Point<dim> &X, const double t)
{
  std::vector<Hold> holds;
  for (const auto &face : corner.free)
    holds.push_back(hold_of(model, face, field, t));
  for (unsigned int i = 0; i < holds.size(); ++i)
    for (unsigned int j = 0; j < holds.size(); ++j)
      if (holds[i] != Hold::nothing && holds[j] == Hold::nothing &&
          corner.free[i].domain == corner.free[j].domain &&
          is_singular_end(corner.free[i], holds[i], corner.free[j], field, X))
        return true;
  return false;
}

} // namespace

template <int dim>
std::string why_singular(const Model<dim> &model, const dealii::Point<dim> &X, const Field &field,
                         const double t)
{
  const Corner<dim> corner = corner_at(model, X);
  for (const auto &one : corner.free)
    for (const auto &other : corner.free)
      if ((one.domain == other.domain || corner.joined.count({one.domain, other.domain}) > 0) &&
          turn_back(one, other, X))
        return "a re-entrant corner";
  for (const auto &tied : corner.bonded)
    for (const auto &face : corner.free) {
      const double cosine = std::abs(tied.N * face.N);
      if (cosine < std::sqrt(0.75) && (field.n_components > 1 || cosine > 0.1))
        return "the end of an interface between two materials";
    }
  if (has_singular_end(model, corner, field, X, t))
    return "the end of a prescribed " + field.name;
  return {};
}

template std::string why_singular(const Model<2> &, const dealii::Point<2> &, const Field &, double);
template std::string why_singular(const Model<3> &, const dealii::Point<3> &, const Field &, double);

} // namespace dovetail
