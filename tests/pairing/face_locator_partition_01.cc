// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The winner does not depend on the partition, nor on who asks. Matching meshes are asked at their vertices,
// where up to four faces tie: the sum of the unit points betrays any other choice. Meshes with hanging nodes;
// some ranks own no face or have no query. A mesh in micrometres far from the origin gives the same numbers
// as one of size one.

// ranks: 1, 2, 3

#include "face_locator_queries.h"

using namespace dealii;

/// The queries of all ranks, on the last rank.
template <int dim>
locator_test::Queries<dim> gather(const locator_test::Queries<dim> &queries)
{
  std::vector<double> flat;
  for (const auto &query : queries) {
    flat.insert(flat.end(), query.X.begin_raw(), query.X.end_raw());
    flat.insert(flat.end(), query.N.begin_raw(), query.N.end_raw());
  }
  const unsigned int last = Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) - 1;
  locator_test::Queries<dim> result;
  for (const std::vector<double> &of_rank : Utilities::MPI::gather(MPI_COMM_WORLD, flat, last))
    for (unsigned int i = 0; i < of_rank.size(); i += 2 * dim) {
      result.emplace_back();
      std::copy_n(&of_rank[i], dim, result.back().X.begin_raw());
      std::copy_n(&of_rank[i + dim], dim, result.back().N.begin_raw());
    }
  return result;
}

template <int dim>
void report(const std::string &name, const locator_test::Matches<dim> &matches, const double scale)
{
  double unit_points = 0, sizes = 0, lost_distance = 0, lost = 0;
  for (const auto &match : matches) {
    for (unsigned int d = 0; d < dim; ++d)
      unit_points += (d + 1) * match.unit_point[d] * (1 + match.N[d]);
    sizes += match.face_size / scale;
    if (!match.found && std::isfinite(match.distance)) {
      lost_distance += match.distance / scale;
      ++lost;
    }
  }
  const locator_test::Summary summary = locator_test::summarise<dim>(matches);
  const double n = summary.points;
  locator_test::print(
      name + ": found " + std::to_string(summary.found) + " of " + std::to_string(summary.points) +
      ", distance " + locator_test::digits(summary.largest_distance) + ", mean unit point " +
      locator_test::digits(Utilities::MPI::sum(unit_points, MPI_COMM_WORLD) / n) + ", mean size " +
      locator_test::digits(Utilities::MPI::sum(sizes, MPI_COMM_WORLD) / n) + ", mean distance of lost " +
      locator_test::digits(Utilities::MPI::sum(lost_distance, MPI_COMM_WORLD) /
                           std::max(1., Utilities::MPI::sum(lost, MPI_COMM_WORLD))));
}

/// Refines the cells around the edge x = end, y = start.
template <int dim>
void refine_locally(Triangulation<dim> &triangulation, const double length)
{
  for (const auto &cell : triangulation.active_cell_iterators())
    if (cell->is_locally_owned() && cell->center()[1] < 0.3 * length)
      cell->set_refine_flag();
  triangulation.execute_coarsening_and_refinement();
}

template <int dim>
void check(const std::string &name, const double scale, const double origin, const double gap,
           const double overhang)
{
  parallel::distributed::Triangulation<dim> left(MPI_COMM_WORLD), right(MPI_COMM_WORLD);
  GridGenerator::hyper_cube(left, 0, scale, true);
  GridGenerator::hyper_cube(right, 0, scale, true);
  left.refine_global(dim == 2 ? 4 : 3);
  right.refine_global(dim == 2 ? 4 : 3);
  refine_locally(right, scale);
  Tensor<1, dim> offset;
  for (unsigned int d = 0; d < dim; ++d)
    offset[d] = origin * scale;
  GridTools::shift(offset, left);
  offset[0] += scale * (1 + gap);
  offset[1] += overhang * scale;
  GridTools::shift(offset, right);

  const MappingQ<dim> mapping(1);
  const auto queries = locator_test::queries_of_side<dim>(left, mapping, 1, QTrapezoid<dim - 1>());
  const dovetail::FaceLocator<dim> locator(locator_test::faces_with(0, right, mapping, 1), 0.2, 0.,
                                           MPI_COMM_WORLD);
  report<dim>(name, locator.locate(queries), scale);
  report<dim>(name + ", the last rank asks", locator.locate(gather<dim>(queries)), scale);
}

int main(int argc, char *argv[])
{
  Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check<2>("2D", 1, 0, 0, 0.125);
  check<2>("2D gap", 1, 0, 0.003, 0.125);
  check<2>("2D rim", 1, 0, 0.003, 0.004);
  check<2>("2D small", 1e-6, 100, 0.003, 0.004);
  check<3>("3D", 1, 0, 0, 0.125);
  check<3>("3D gap", 1, 0, 0.003, 0.125);
  check<3>("3D rim", 1, 0, 0.003, 0.004);
  check<3>("3D small", 1e-6, 100, 0.003, 0.004);
}
