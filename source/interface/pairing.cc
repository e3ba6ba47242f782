// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/interface/pairing.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/timer.h>

#include <numeric>

namespace dovetail {

namespace {

/// Area and number of faces of a side, over all ranks.
template <int dim>
std::array<double, 2> measure_side(const InterfaceSide<dim> &side, const MPI_Comm &communicator)
{
  const Domain<dim> &domain = *side.domain;
  dealii::FEFaceValues<dim> values(domain.mapping(), domain.scalar_element(),
                                   dealii::QGauss<dim - 1>(domain.mapping_degree() + 1),
                                   dealii::update_JxW_values);
  double area = 0, n_faces = 0;
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (cell->is_locally_owned() && side.boundary_ids.count(id) > 0) {
      values.reinit(cell, face);
      area = std::accumulate(values.get_JxW_values().begin(), values.get_JxW_values().end(), area);
      ++n_faces;
    }
  return {
      {dealii::Utilities::MPI::sum(area, communicator), dealii::Utilities::MPI::sum(n_faces, communicator)}};
}

template <int dim>
FaceLocator<dim> make_locator(const InterfaceSide<dim> &side, const double search_radius,
                              const MPI_Comm &communicator)
{
  return {side.domain->mesh(), side.domain->mapping(), side.domain->mapping_degree(),
          side.boundary_ids,   search_radius,          communicator};
}

} // namespace

template <int dim>
Pairing<dim>::Pairing(const std::array<InterfaceSide<dim>, 2> &sides, const Options &options,
                      const MPI_Comm &communicator)
    : extension(options.gap_extension), n_nodes{{sides[source].domain->n_nodes(),
                                                 sides[destination].domain->n_nodes()}}
{
  std::array<double, 2> face_size;
  for (const unsigned int side : {source, destination}) {
    const auto [area, n_faces] = measure_side(sides[side], communicator);
    account.area[side] = area;
    face_size[side] = std::pow(area / std::max(n_faces, 1.), 1. / (dim - 1));
  }

  const double factor = options.integrate_on[source] && options.integrate_on[destination] ? 0.5 : 1;
  for (const unsigned int own : {source, destination})
    if (options.integrate_on[own]) {
      // a coarse face needs so many points that the partner's faces, too, hold their share of them
      Options of_side = options;
      if (of_side.points_per_direction == 0) {
        const unsigned int degree = std::max(sides[source].domain->degree, sides[destination].domain->degree);
        const double ratio = std::max(1., face_size[own] / face_size[1 - own]);
        of_side.points_per_direction = static_cast<unsigned int>(std::ceil((degree + 1) * ratio - 1e-6)) + 1;
      }
      integrate(sides, own, of_side, factor, communicator);
    }
  account.n_points = dealii::Utilities::MPI::sum(static_cast<unsigned long>(weights.size()), communicator);
}

template <int dim>
typename Pairing<dim>::OwnPoints Pairing<dim>::own_points(const InterfaceSide<dim> &side,
                                                          const unsigned int points_per_direction)
{
  const Domain<dim> &domain = *side.domain;
  const unsigned int n = domain.n_nodes();
  dealii::FEFaceValues<dim> face_values(
      domain.mapping(), domain.scalar_element(), dealii::QGauss<dim - 1>(points_per_direction),
      dealii::update_values | dealii::update_gradients | dealii::update_quadrature_points |
          dealii::update_normal_vectors | dealii::update_JxW_values);
  ShapeEvaluator<dim> shapes(domain);
  OwnPoints own;
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (cell->is_locally_owned() && side.boundary_ids.count(id) > 0) {
      face_values.reinit(cell, face);
      CellBehind behind;
      domain.cell_dofs(domain.dof_cell(cell), behind.dofs);
      behind.cell_measure = shapes.cell_measure(cell);
      behind.face_measure =
          std::accumulate(face_values.get_JxW_values().begin(), face_values.get_JxW_values().end(), 0.);
      for (const unsigned int q : face_values.quadrature_point_indices()) {
        own.queries.push_back({face_values.quadrature_point(q), face_values.normal_vector(q)});
        own.JxW.push_back(face_values.JxW(q));
        own.cell_of_point.push_back(own.cells.size());
        for (unsigned int a = 0; a < n; ++a) {
          own.values.push_back(face_values.shape_value(a, q));
          own.gradients.push_back(face_values.shape_grad(a, q));
        }
      }
      own.cells.push_back(std::move(behind));
    }
  return own;
}

template <int dim>
void Pairing<dim>::integrate(const std::array<InterfaceSide<dim>, 2> &sides, const unsigned int own,
                             const Options &options, const double factor, const MPI_Comm &communicator)
{
  const unsigned int partner = 1 - own;
  OwnPoints points_of_own = own_points(sides[own], options.points_per_direction);
  dealii::Timer timer;
  const FaceLocator<dim> locator = make_locator(sides[partner], options.search_radius, communicator);
  const auto matches = locator.locate(points_of_own.queries);
  search_seconds += timer.wall_time();
  const PartnerShapes<dim> shapes = fetch_shapes(*sides[partner].domain, locator, matches, communicator);

  // the points with a partner, sorted by the two cells behind them
  std::vector<unsigned int> order;
  double covered = 0, covered_partner = 0, gap = 0, angle = 0, miss = std::numeric_limits<double>::infinity();
  unsigned long n_uncovered = 0;
  for (unsigned int q = 0; q < matches.size(); ++q)
    if (matches[q].found) {
      order.push_back(q);
      covered += points_of_own.JxW[q];
      covered_partner += points_of_own.JxW[q] * std::abs(points_of_own.queries[q].N * matches[q].N);
      gap = std::max(gap, matches[q].distance);
      angle = std::max(angle, matches[q].angle);
    } else {
      ++n_uncovered;
      miss = std::min(miss, matches[q].distance);
    }
  std::stable_sort(order.begin(), order.end(), [&](const unsigned int p, const unsigned int q) {
    return std::make_pair(points_of_own.cell_of_point[p], shapes.cell_of_point[p]) <
           std::make_pair(points_of_own.cell_of_point[q], shapes.cell_of_point[q]);
  });

  const unsigned int first_point = weights.size();
  const std::array<unsigned int, 2> first_cell = {{static_cast<unsigned int>(cells[source].size()),
                                                   static_cast<unsigned int>(cells[destination].size())}};
  for (const unsigned int side : {source, destination}) {
    const std::size_t size = (first_point + order.size()) * n_nodes[side];
    shape_values[side].reserve(size);
    shape_gradients[side].reserve(size);
    if (extension != GapExtension::none)
      extended_values[side].reserve(size);
  }
  for (const unsigned int q : order) {
    weights.push_back(factor * points_of_own.JxW[q]);
    points[own].push_back(points_of_own.queries[q].X);
    points[partner].push_back(matches[q].X);
    normals[own].push_back(points_of_own.queries[q].N);
    normals[partner].push_back(matches[q].N);
    const dealii::Tensor<1, dim> offset = points_of_own.queries[q].X - matches[q].X;
    for (unsigned int a = 0; a < n_nodes[own]; ++a) {
      shape_values[own].push_back(points_of_own.values[q * n_nodes[own] + a]);
      shape_gradients[own].push_back(points_of_own.gradients[q * n_nodes[own] + a]);
      if (extension != GapExtension::none)
        extended_values[own].push_back(shape_values[own].back());
    }
    for (unsigned int a = 0; a < n_nodes[partner]; ++a) {
      const unsigned int i = q * n_nodes[partner] + a;
      shape_values[partner].push_back(shapes.values[i]);
      shape_gradients[partner].push_back(shapes.gradients[i]);
      if (extension != GapExtension::none)
        extended_values[partner].push_back(shapes.values[i] + shapes.gradients[i] * offset);
    }
  }
  for (unsigned int i = 0; i < order.size(); ++i) {
    std::array<unsigned int, 2> behind;
    behind[own] = first_cell[own] + points_of_own.cell_of_point[order[i]];
    behind[partner] = first_cell[partner] + shapes.cell_of_point[order[i]];
    if (i == 0 || groups.back().cells != behind)
      groups.push_back({first_point + i, first_point + i, behind});
    ++groups.back().end;
  }
  for (const unsigned int side : {source, destination})
    for (const CellBehind &cell : side == own ? points_of_own.cells : shapes.cells)
      cells[side].push_back(cell);

  account.covered[own] = dealii::Utilities::MPI::sum(covered, communicator);
  n_uncovered = dealii::Utilities::MPI::sum(n_uncovered, communicator);
  account.n_uncovered += n_uncovered;
  account.largest_gap = std::max(account.largest_gap, dealii::Utilities::MPI::max(gap, communicator));
  account.largest_angle = std::max(account.largest_angle, dealii::Utilities::MPI::max(angle, communicator));
  if (n_uncovered > 0)
    account.nearest_miss = dealii::Utilities::MPI::min(miss, communicator);
  if (options.integrate_on[partner])
    return; // the partner's own points tell how much of it is covered
  if (n_uncovered == 0)
    account.covered[partner] =
        std::min(account.area[partner], dealii::Utilities::MPI::sum(covered_partner, communicator));
  else {
    const OwnPoints of_partner = own_points(sides[partner], options.points_per_direction);
    const auto back =
        make_locator(sides[own], options.search_radius, communicator).locate(of_partner.queries);
    double found = 0;
    for (unsigned int q = 0; q < back.size(); ++q)
      if (back[q].found)
        found += of_partner.JxW[q];
    account.covered[partner] = dealii::Utilities::MPI::sum(found, communicator);
  }
}

template class Pairing<2>;
template class Pairing<3>;

} // namespace dovetail
