// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/shapes.h>
#include <dovetail/measure/point_in_domain.h>

#include <deal.II/base/geometry_info.h>
#include <deal.II/base/mpi.h>

#include <algorithm>
#include <limits>
#include <sstream>

namespace dovetail {

namespace {

/// In units of the cell's diameter.
constexpr double tolerance_of_straight = 1e-3, tolerance_of_curved = 0.1, rounding_of_distance = 1e-9;

/// A point of a cell, and how far X is from it in units of the cell's diameter.
template <int dim>
struct Candidate
{
  PointInCell<dim> place;
  double distance;
};

template <int dim>
std::string to_text(const dealii::Point<dim> &X)
{
  std::ostringstream text;
  for (unsigned int d = 0; d < dim; ++d)
    text << (d == 0 ? "" : "; ") << X[d];
  return text.str();
}

/// Where X is in the reference cell, or at its surface if X is outside.
template <int dim>
dealii::Point<dim> find_in_cell(const Domain<dim> &domain, const typename Domain<dim>::cell_iterator &cell,
                                const dealii::Point<dim> &X)
{
  if (!domain.has_simplices())
    return dealii::GeometryInfo<dim>::project_to_unit_cell(
        domain.mapping().transform_real_to_unit_cell(cell, X));
  const typename dealii::Triangulation<dim>::active_cell_iterator mesh_cell(cell);
  dealii::Point<dim> unit_point =
      domain.mapping_degree() > 1
          ? domain.mapping().transform_real_to_unit_cell(cell, X)
          : dealii::Point<dim>(dealii::invert(jacobian_of_simplex<dim>(mesh_cell)) * (X - cell->vertex(0)));
  double first = 1, sum = 0; // barycentric coordinates
  for (unsigned int d = 0; d < dim; ++d) {
    first -= unit_point[d];
    unit_point[d] = std::max(unit_point[d], 0.);
    sum += unit_point[d];
  }
  return dealii::Point<dim>(unit_point / (sum + std::max(first, 0.)));
}

template <int dim>
void compare_with_cell(const Domain<dim> &domain, const typename Domain<dim>::cell_iterator &cell,
                       const dealii::Point<dim> &X, std::vector<Candidate<dim>> &candidates)
{
  const double diameter = cell->diameter();
  if (X.distance(cell->center()) > 1.5 * diameter)
    return;
  try {
    const auto unit_point = find_in_cell(domain, cell, X);
    const double distance =
        X.distance(domain.mapping().transform_unit_to_real_cell(cell, unit_point)) / diameter;
    candidates.push_back({{cell, unit_point}, distance});
  } catch (const typename dealii::Mapping<dim>::ExcTransformationFailed &) {
    // too far away for this curved cell
  }
}

template <int dim>
[[noreturn]] void fail_outside(const Domain<dim> &domain, const dealii::Point<dim> &X, const Section &asking,
                               const MPI_Comm &communicator)
{
  double distance = std::numeric_limits<double>::max();
  std::vector<double> corners(2 * dim, std::numeric_limits<double>::max()); // smallest, minus largest
  for (const auto &cell : domain.mesh().active_cell_iterators())
    if (cell->is_locally_owned())
      for (const unsigned int v : cell->vertex_indices()) {
        distance = std::min(distance, X.distance(cell->vertex(v)));
        for (unsigned int d = 0; d < dim; ++d) {
          corners[d] = std::min(corners[d], cell->vertex(v)[d]);
          corners[dim + d] = std::min(corners[dim + d], -cell->vertex(v)[d]);
        }
      }
  distance = dealii::Utilities::MPI::min(distance, communicator);
  dealii::Utilities::MPI::min(corners, communicator, corners);
  dealii::Point<dim> lower, upper;
  for (unsigned int d = 0; d < dim; ++d) {
    lower[d] = corners[d];
    upper[d] = -corners[dim + d];
  }
  std::ostringstream message;
  message << "is outside the domain " << domain.name << ": the nearest vertex of its mesh is " << distance
          << " away, and the domain extends from " << to_text(lower) << " to " << to_text(upper) << ".";
  asking.fail("Point", message.str());
}

} // namespace

template <int dim>
std::vector<PointInCell<dim>> find_cells(const Domain<dim> &domain, const dealii::Point<dim> &X,
                                         const Section &asking, const MPI_Comm &communicator)
{
  std::vector<Candidate<dim>> candidates;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned())
      compare_with_cell(domain, cell, X, candidates);

  double least = std::numeric_limits<double>::max();
  for (const auto &candidate : candidates)
    least = std::min(least, candidate.distance);
  least = dealii::Utilities::MPI::min(least, communicator);
  if (least > tolerance_of_straight && (least > tolerance_of_curved || is_straight(domain.mesh())))
    fail_outside(domain, X, asking, communicator);

  std::vector<PointInCell<dim>> result;
  for (const auto &candidate : candidates)
    if (candidate.distance <= least + rounding_of_distance)
      result.push_back(candidate.place);
  return result;
}

template std::vector<PointInCell<2>> find_cells(const Domain<2> &, const dealii::Point<2> &, const Section &,
                                                const MPI_Comm &);
template std::vector<PointInCell<3>> find_cells(const Domain<3> &, const dealii::Point<3> &, const Section &,
                                                const MPI_Comm &);

} // namespace dovetail
