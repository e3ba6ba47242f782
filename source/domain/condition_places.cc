// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Planes of faces and nodes at points.

#include <dovetail/domain/condition_places.h>
#include <dovetail/domain/domain.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/scene/undefined.h>

#include <deal.II/base/mpi.h>
#include <deal.II/fe/fe_values.h>

#include <boost/serialization/utility.hpp>
#include <boost/serialization/vector.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

namespace dovetail {

using dealii::Tensor;

namespace {

constexpr double largest_angle = 1e-3; ///< [rad] between normals of one plane

/// The directions, up to their sign, of the normals on the faces with one boundary id; at most dim + 1.
template <int dim>
using Directions = std::vector<Tensor<1, dim>>;

template <int dim>
double difference(const Tensor<1, dim> &N, const Tensor<1, dim> &direction)
{
  return std::min((N - direction).norm(), (N + direction).norm());
}

/// The position of the direction that is nearest to a unit normal.
template <int dim>
unsigned int nearest(const Directions<dim> &directions, const Tensor<1, dim> &N)
{
  return std::min_element(directions.begin(), directions.end(),
                          [&](const auto &a, const auto &b) { return difference(N, a) < difference(N, b); }) -
         directions.begin();
}

template <int dim>
void add_direction(const Tensor<1, dim> &N, Directions<dim> &directions)
{
  if (directions.size() <= dim &&
      std::all_of(directions.begin(), directions.end(),
                  [&](const auto &direction) { return difference(N, direction) > largest_angle; }))
    directions.push_back(N);
}

template <int dim>
class Planes
{
public:
  Planes(const Domain<dim> &domain, const MPI_Comm &communicator)
      : domain(domain), communicator(communicator),
        values(domain.mapping(), domain.scalar_element(),
               gauss_rule<dim - 1>(domain.face_shape(), domain.mapping_degree() + 1),
               dealii::update_normal_vectors | dealii::update_JxW_values)
  {
    for (const auto &condition : domain.conditions())
      if (condition->constrains_normal())
        for (const auto id : condition->boundary_ids)
          conditions.emplace(id, condition.get());
  }

  PlaneNormals<dim> find();

private:
  void find_directions();
  void average();

  const Domain<dim> &domain;
  const MPI_Comm communicator;
  dealii::FEFaceValues<dim> values;
  std::map<dealii::types::boundary_id, const Condition<dim> *> conditions; ///< one that each id has
  std::map<dealii::types::boundary_id, Directions<dim>> directions;
};

template <int dim>
void Planes<dim>::find_directions()
{
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (conditions.count(id) > 0 && cell->is_locally_owned()) {
      values.reinit(cell, face);
      for (const unsigned int q : values.quadrature_point_indices())
        add_direction(values.normal_vector(q), directions[id]);
    }
  std::vector<std::pair<dealii::types::boundary_id, Tensor<1, dim>>> own;
  for (const auto &[id, sums_of_id] : directions)
    for (const Tensor<1, dim> &N : sums_of_id)
      own.emplace_back(id, N);
  directions.clear();
  std::set<std::pair<dealii::types::boundary_id, std::array<double, dim>>> sorted; // whoever owns them
  for (const auto &rank_part : dealii::Utilities::MPI::all_gather(communicator, own))
    for (const auto &[id, N] : rank_part) {
      std::array<double, dim> entries;
      std::copy(N.begin_raw(), N.end_raw(), entries.begin());
      sorted.emplace(id, entries);
    }
  for (const auto &[id, entries] : sorted) {
    Tensor<1, dim> N;
    std::copy(entries.begin(), entries.end(), N.begin_raw());
    add_direction(N, directions[id]);
  }
  for (const auto &[id, sums_of_id] : directions)
    conditions.at(id)->section.check(
        sums_of_id.size() <= dim, "Boundary ids",
        "has " + std::to_string(id) + ", whose faces lie in more than " + std::to_string(dim) +
            " planes: u.N = 0 on a curved boundary would hold its nodes in all directions. Give the planes "
            "boundary ids of their own.");
}

/// The means of the normals, weighted by area.
template <int dim>
void Planes<dim>::average()
{
  std::vector<double> sums;
  std::map<dealii::types::boundary_id, unsigned int> first;
  for (const auto &[id, sums_of_id] : directions) {
    first[id] = sums.size();
    sums.resize(sums.size() + dim * sums_of_id.size());
  }
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (conditions.count(id) > 0 && cell->is_locally_owned()) {
      values.reinit(cell, face);
      for (const unsigned int q : values.quadrature_point_indices()) {
        const Tensor<1, dim> &N = values.normal_vector(q);
        const unsigned int i = nearest(directions[id], N);
        const double sign = N * directions[id][i] < 0 ? -1 : 1;
        for (unsigned int d = 0; d < dim; ++d)
          sums[first[id] + i * dim + d] += sign * values.JxW(q) * N[d];
      }
    }
  dealii::Utilities::MPI::sum(sums, communicator, sums);
  for (auto &[id, sums_of_id] : directions)
    for (unsigned int i = 0; i < sums_of_id.size(); ++i) {
      Tensor<1, dim> &N = sums_of_id[i];
      for (unsigned int d = 0; d < dim; ++d)
        N[d] = sums[first[id] + i * dim + d];
      for (unsigned int d = 0; d < dim; ++d)
        N[d] = std::abs(N[d]) < 1e-10 * N.norm() ? 0 : N[d];
      N /= N.norm();
    }
}

template <int dim>
PlaneNormals<dim> Planes<dim>::find()
{
  PlaneNormals<dim> normals;
  if (conditions.empty())
    return normals;
  find_directions();
  average();
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (conditions.count(id) > 0) {
      values.reinit(cell, face);
      const Directions<dim> &sums_of_id = directions.at(id);
      normals[{cell->active_cell_index(), face}] = sums_of_id[nearest(sums_of_id, values.normal_vector(0))];
    }
  return normals;
}

/// Of this rank: the node that is nearest to a point.
template <int dim>
struct Nearest
{
  double distance = std::numeric_limits<double>::max(), diameter = 0; ///< of the cell
  dealii::Point<dim> X;
  std::optional<NodeOfCell<dim>> node; ///< none if only vertices have been looked at
};

template <int dim>
Nearest<dim> nearest_node(const Domain<dim> &domain, const Field &field, const dealii::Point<dim> &point)
{
  Nearest<dim> nearest;
  const auto look_at = [&](const auto &cell, const dealii::Point<dim> &X,
                           const std::optional<unsigned int> node) {
    if (X.distance(point) >= nearest.distance)
      return;
    nearest.distance = X.distance(point);
    nearest.diameter = cell->diameter();
    nearest.X = X;
    nearest.node = node ? std::optional(NodeOfCell<dim>{cell, *node}) : std::nullopt;
  };
  const auto &element = domain.layout().element(field.first_component);
  dealii::FEValues<dim> at_nodes(domain.mapping(), element, element.get_unit_support_points(),
                                 dealii::update_quadrature_points);
  const auto hanging = domain.hanging_nodes();
  const auto &owned = domain.dof_handler().locally_owned_dofs();
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : domain.mesh().active_cell_iterators()) {
    if (cell->is_artificial())
      continue;
    if (cell->center().distance(point) > cell->diameter()) {
      for (const unsigned int v : cell->vertex_indices())
        look_at(cell, cell->vertex(v), {});
      continue;
    }
    at_nodes.reinit(cell);
    domain.cell_dofs(domain.dof_cell(cell), dofs);
    for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a)
      if (const auto dof = dofs[domain.layout().index(field.first_component, a)] - domain.first_dof();
          owned.is_element(dof) && !hanging.is_constrained(dof))
        look_at(cell, at_nodes.quadrature_point(a), a);
  }
  return nearest;
}

} // namespace

template <int dim>
PlaneNormals<dim> find_plane_normals(const Domain<dim> &domain, const MPI_Comm &communicator)
{
  return Planes<dim>(domain, communicator).find();
}

template <int dim>
std::optional<NodeOfCell<dim>> find_node(const Domain<dim> &domain, const Condition<dim> &condition,
                                         const MPI_Comm &communicator)
{
  const double tolerance = 1e-2; // of the diameter: coordinates are typed by hand
  const Nearest<dim> nearest = nearest_node(domain, condition.field, *condition.point());
  std::vector<double> own = {nearest.distance, nearest.diameter};
  for (unsigned int d = 0; d < dim; ++d)
    own.push_back(nearest.X[d]);
  const auto gathered = dealii::Utilities::MPI::all_gather(communicator, own);
  const auto best = std::min_element(gathered.begin(), gathered.end(),
                                     [](const auto &a, const auto &b) { return a[0] < b[0]; });
  dealii::Point<dim> X;
  for (unsigned int d = 0; d < dim; ++d)
    X[d] = (*best)[2 + d];
  condition.section.check((*best)[0] <= tolerance * (*best)[1], "Point",
                          "is " + in_words(*condition.point()) +
                              ", where the mesh has no node; the nearest one is " + in_words(X) + ".");
  const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(communicator);
  return static_cast<unsigned int>(best - gathered.begin()) == rank ? nearest.node : std::nullopt;
}

template PlaneNormals<2> find_plane_normals(const Domain<2> &, const MPI_Comm &);
template PlaneNormals<3> find_plane_normals(const Domain<3> &, const MPI_Comm &);
template std::optional<NodeOfCell<2>> find_node(const Domain<2> &, const Condition<2> &, const MPI_Comm &);
template std::optional<NodeOfCell<3>> find_node(const Domain<3> &, const Condition<3> &, const MPI_Comm &);

} // namespace dovetail
