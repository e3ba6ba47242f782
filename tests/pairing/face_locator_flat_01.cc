// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Flat sides in 2D and 3D: 8 faces per direction ask 6 faces (of size 1/6, in 3D 2^(1/2)/6). Shifted upwards
// by a quarter of the asking side, a quarter of the points has no partner. With a gap the distance is the gap
// over the size. A gap beyond the search radius, a side that looks away and a side without faces find
// nothing.

// ranks: 1, 2, 3

#include "face_locator_queries.h"

using namespace dealii;

template <int dim>
void check(const std::string &name, const double gap, const double shift, const types::boundary_id partner_id)
{
  parallel::distributed::Triangulation<dim> left(MPI_COMM_WORLD), right(MPI_COMM_WORLD);
  Point<dim> origin, end;
  for (unsigned int d = 0; d < dim; ++d)
    end[d] = 1;
  GridGenerator::subdivided_hyper_rectangle(left, std::vector<unsigned int>(dim, 8), origin, end, true);
  GridGenerator::subdivided_hyper_rectangle(right, std::vector<unsigned int>(dim, 6), origin, end, true);
  Tensor<1, dim> offset;
  offset[0] = 1 + gap;
  offset[1] = shift;
  GridTools::shift(offset, right);

  const MappingQ<dim> mapping(1);
  const auto queries = locator_test::queries_of_side<dim>(left, mapping, 1, QGauss<dim - 1>(2));
  const dovetail::FaceLocator<dim> locator(locator_test::faces_with(partner_id, right, mapping, 1), 0.2, 0.,
                                           MPI_COMM_WORLD);
  const auto matches = locator.locate(queries);

  // The closest point is known: that of the query, moved by the gap.
  double error = 0;
  for (unsigned int i = 0; i < queries.size(); ++i)
    if (matches[i].found)
      error = std::max(error, (matches[i].X - queries[i].X - gap * Point<dim>::unit_vector(0)).norm());
  error = Utilities::MPI::max(error, MPI_COMM_WORLD);
  const auto [position, normal] = locator_test::difference_from_mapping(locator, matches, mapping);
  const locator_test::Summary summary = locator_test::summarise<dim>(matches);
  locator_test::print(std::to_string(dim) + "D " + name + ": found " + std::to_string(summary.found) +
                      " of " + std::to_string(summary.points) + ", distance " +
                      locator_test::digits(summary.largest_distance) + ", angle " +
                      locator_test::digits(summary.largest_angle) + ", closest " +
                      std::to_string(error < 1e-14) + ", unit point " + std::to_string(position < 1e-14) +
                      ", normal " + std::to_string(normal < 1e-13));
}

template <int dim>
void check()
{
  check<dim>("touching", 0, 0, 0);
  check<dim>("shifted", 0, 0.25, 0);
  check<dim>("gap", 0.01, 0, 0);
  check<dim>("far away", 0.1, 0, 0);
  check<dim>("looking away", 0, 0, 1);
  check<dim>("no faces", 0, 0, 77);
}

int main(int argc, char *argv[])
{
  Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check<2>();
  check<3>();
}
