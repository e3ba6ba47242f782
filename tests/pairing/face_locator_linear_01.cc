// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Faces of degree 1 have their own code. Told that the mapping has degree 3, the locator treats the same
// faces with the general code and must find the same partners. The faces are warped: the mesh is distorted,
// its boundary too.

#include "face_locator_queries.h"

using namespace dealii;

template <int dim>
void check()
{
  Triangulation<dim> straight, distorted;
  GridGenerator::hyper_cube(straight, 0, 1, true);
  GridGenerator::hyper_cube(distorted, 0, 1, true);
  straight.refine_global(3);
  distorted.refine_global(2);
  GridTools::distort_random(0.2, distorted, false);
  GridTools::shift(Point<dim>::unit_vector(0), distorted);

  const MappingQ<dim> mapping(1);
  const auto queries = locator_test::queries_of_side<dim>(straight, mapping, 1, QGauss<dim - 1>(3));
  const dovetail::FaceLocator<dim> special(locator_test::faces_with(0, distorted, mapping, 1), 0.3, 0.,
                                           MPI_COMM_SELF);
  const dovetail::FaceLocator<dim> general(locator_test::faces_with(0, distorted, mapping, 3), 0.3, 0.,
                                           MPI_COMM_SELF);
  const auto matches = special.locate(queries);
  const auto other_matches = general.locate(queries);

  unsigned int found = 0, different = 0;
  double difference = 0;
  for (unsigned int i = 0; i < queries.size(); ++i) {
    const auto &one = matches[i], &other = other_matches[i];
    found += one.found;
    different += one.found != other.found || one.face != other.face;
    if (one.found && other.found)
      difference = std::max({difference, one.X.distance(other.X), one.unit_point.distance(other.unit_point),
                             (one.N - other.N).norm(), std::abs(one.angle - other.angle)});
  }
  locator_test::print(std::to_string(dim) + "D: found more than 90 % " +
                      std::to_string(found > 0.9 * queries.size()) + ", different partners " +
                      std::to_string(different) + ", equal " + std::to_string(difference < 1e-11));
}

int main(int argc, char *argv[])
{
  Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check<2>();
  check<3>();
}
