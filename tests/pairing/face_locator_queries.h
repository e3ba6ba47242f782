// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the tests of the face locator share: the points of a side, and checks that reduce over the ranks.

#pragma once

#include <dovetail/pairing/face_locator.h>

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/distributed/tria.h>
#include <deal.II/fe/fe_nothing.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/fe/mapping_q.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/grid/grid_tools.h>

#include <iostream>
#include <string>

namespace locator_test {

using namespace dealii;

template <int dim>
using Queries = std::vector<typename dovetail::FaceLocator<dim>::Query>;

template <int dim>
using Matches = std::vector<typename dovetail::FaceLocator<dim>::Match>;

/// The faces with a boundary id.
template <int dim>
dovetail::SideFaces<dim> faces_with(const types::boundary_id id, const Triangulation<dim> &triangulation,
                                    const Mapping<dim> &mapping, const unsigned int mapping_degree)
{
  return {triangulation, mapping, mapping_degree,
          [id](const auto & /*cell*/, const types::boundary_id other) { return other == id; }};
}

template <int dim>
Queries<dim> queries_of_side(const Triangulation<dim> &triangulation, const Mapping<dim> &mapping,
                             const types::boundary_id id, const Quadrature<dim - 1> &quadrature)
{
  const FE_Nothing<dim> fe;
  FEFaceValues<dim> values(mapping, fe, quadrature, update_quadrature_points | update_normal_vectors);
  Queries<dim> queries;
  for (const auto &cell : triangulation.active_cell_iterators())
    for (const unsigned int f : cell->face_indices())
      if (cell->is_locally_owned() && cell->face(f)->at_boundary() && cell->face(f)->boundary_id() == id) {
        values.reinit(cell, f);
        for (const unsigned int q : values.quadrature_point_indices())
          queries.push_back({values.quadrature_point(q), values.normal_vector(q)});
      }
  return queries;
}

struct Summary
{
  unsigned int points = 0, found = 0;
  double largest_distance = 0; ///< of the found, over the size of the partner's face
  double largest_angle = 0;
};

template <int dim>
Summary summarise(const Matches<dim> &matches)
{
  Summary summary;
  for (const auto &match : matches)
    if (match.found) {
      ++summary.found;
      summary.largest_distance = std::max(summary.largest_distance, match.distance / match.face_size);
      summary.largest_angle = std::max(summary.largest_angle, match.angle);
    }
  summary.points = Utilities::MPI::sum(static_cast<unsigned int>(matches.size()), MPI_COMM_WORLD);
  summary.found = Utilities::MPI::sum(summary.found, MPI_COMM_WORLD);
  summary.largest_distance = Utilities::MPI::max(summary.largest_distance, MPI_COMM_WORLD);
  summary.largest_angle = Utilities::MPI::max(summary.largest_angle, MPI_COMM_WORLD);
  return summary;
}

/// The largest differences between a match and what the mapping says of its cell and unit point: position
/// over face size, and normal (the row of the inverse Jacobian that belongs to the face). Of partners on this
/// rank only.
template <int dim>
std::pair<double, double> difference_from_mapping(const dovetail::FaceLocator<dim> &locator,
                                                  const Matches<dim> &matches, const Mapping<dim> &mapping)
{
  const unsigned int rank = Utilities::MPI::this_mpi_process(MPI_COMM_WORLD);
  const FE_Nothing<dim> fe;
  double of_position = 0, of_normal = 0;
  for (const auto &match : matches)
    if (match.found && match.rank == rank) {
      const auto &face = locator.side().faces[match.face];
      FEValues<dim> values(mapping, fe, Quadrature<dim>(match.unit_point),
                           update_quadrature_points | update_inverse_jacobians);
      values.reinit(face.cell);
      Tensor<1, dim> normal;
      for (unsigned int d = 0; d < dim; ++d)
        normal[d] = (face.face_no % 2 == 1 ? 1. : -1.) * values.inverse_jacobian(0)[face.face_no / 2][d];
      of_normal = std::max(of_normal, (match.N - normal / normal.norm()).norm());
      of_position = std::max(of_position, match.X.distance(values.quadrature_point(0)) / face.size);
    }
  return {Utilities::MPI::max(of_position, MPI_COMM_WORLD), Utilities::MPI::max(of_normal, MPI_COMM_WORLD)};
}

/// Prints on one rank.
inline void print(const std::string &text)
{
  if (Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
    std::cout << text << std::endl;
}

inline std::string digits(const double value)
{
  char text[32];
  std::snprintf(text, sizeof(text), "%.6f", std::abs(value) < 5e-7 ? 0. : value);
  return text;
}

} // namespace locator_test
