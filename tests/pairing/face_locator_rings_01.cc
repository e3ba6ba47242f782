// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A ring in a ring, 3n/2 faces outside and n inside, and a shell in a shell, with mapping degrees 1 to 3: the
// sides differ by the facets' sagitta, and no point may be lost, whichever side asks.

// ranks: 1, 2, 3

#include "face_locator_queries.h"

using namespace dealii;

template <int dim>
void ask(const std::string &name, const Triangulation<dim> &asking, const types::boundary_id asking_id,
         const Triangulation<dim> &partner, const types::boundary_id partner_id, const unsigned int degree)
{
  const MappingQ<dim> mapping(degree);
  const auto queries =
      locator_test::queries_of_side<dim>(asking, mapping, asking_id, QGauss<dim - 1>(degree + 1));
  const dovetail::FaceLocator<dim> locator(locator_test::faces_with(partner_id, partner, mapping, degree),
                                           0.2, 0., MPI_COMM_WORLD);
  const auto matches = locator.locate(queries);
  const auto [position, normal] = locator_test::difference_from_mapping(locator, matches, mapping);
  const locator_test::Summary summary = locator_test::summarise<dim>(matches);
  locator_test::print(name + ", degree " + std::to_string(degree) + ": lost " +
                      std::to_string(summary.points - summary.found) + " of " +
                      std::to_string(summary.points) + ", distance " +
                      locator_test::digits(summary.largest_distance) + ", angle " +
                      locator_test::digits(summary.largest_angle) + ", unit point " +
                      std::to_string(position < 1e-13) + ", normal " + std::to_string(normal < 1e-12));
}

template <int dim>
void check(const std::string &name, const unsigned int n_inside, const unsigned int n_outside,
           const unsigned int refinements)
{
  parallel::distributed::Triangulation<dim> inside(MPI_COMM_WORLD), outside(MPI_COMM_WORLD);
  GridGenerator::hyper_shell(inside, Point<dim>(), 0.8, 1., n_inside, true);
  GridGenerator::hyper_shell(outside, Point<dim>(), 1., 1.2, n_outside, true);
  inside.refine_global(refinements);
  outside.refine_global(refinements);
  for (const unsigned int degree : {1, 2, 3}) {
    ask<dim>(name + " from inside", inside, 1, outside, 0, degree);
    ask<dim>(name + " from outside", outside, 0, inside, 1, degree);
  }
}

int main(int argc, char *argv[])
{
  Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check<2>("ring 16", 16, 24, 0);
  check<2>("ring 64", 64, 96, 0);
  check<3>("shell", 6, 12, 1);
}
