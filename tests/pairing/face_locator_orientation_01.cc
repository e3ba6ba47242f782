// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The unit point maps to the point found, and the normal is outward, whatever the orientation, flip and
// rotation of faces, on which of its faces a cell is asked, and however curved it is. Points of the side ask
// the side itself.

#include "face_locator_queries.h"

using namespace dealii;

template <int dim>
void check(const std::string &name, const Triangulation<dim> &triangulation, const unsigned int degree)
{
  const MappingQ<dim> mapping(degree);
  locator_test::Queries<dim> queries =
      locator_test::queries_of_side<dim>(triangulation, mapping, 0, QGauss<dim - 1>(3));
  for (auto &query : queries)
    query.N *= -1;
  const dovetail::FaceLocator<dim> locator(locator_test::faces_with(0, triangulation, mapping, degree), 0.1,
                                           0., MPI_COMM_SELF);
  const auto matches = locator.locate(queries);
  const auto [position, normal] = locator_test::difference_from_mapping(locator, matches, mapping);
  const unsigned int lost =
      std::count_if(matches.begin(), matches.end(), [](const auto &match) { return !match.found; });
  const auto largest =
      std::max_element(matches.begin(), matches.end(), [](const auto &one, const auto &other) {
        return std::max(one.distance, one.angle) < std::max(other.distance, other.angle);
      });
  std::set<unsigned int> face_numbers;
  for (const auto &match : matches)
    face_numbers.insert(locator.side().faces[match.face].face_no);
  locator_test::print(name + ", degree " + std::to_string(degree) + ": lost " + std::to_string(lost) +
                      " of " + std::to_string(queries.size()) + ", on " +
                      (face_numbers.size() > 1 ? "several faces" : "one face") + " of cells, itself " +
                      std::to_string(largest->distance < 1e-14 && largest->angle < 1e-12) + ", unit point " +
                      std::to_string(position < 1e-13) + ", normal " + std::to_string(normal < 1e-12));
}

int main(int argc, char *argv[])
{
  Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (unsigned int code = 0; code < 8; ++code) {
    Triangulation<3> cubes;
    GridGenerator::non_standard_orientation_mesh(cubes, code & 1, code & 2, code & 4, true);
    check("cubes " + std::to_string(code), cubes, 1);
    check("cubes " + std::to_string(code), cubes, 2);
  }
  for (const unsigned int degree : {1, 2, 3}) {
    Triangulation<2> disc;
    GridGenerator::hyper_ball(disc);
    check("disc", disc, degree);
    Triangulation<3> ball;
    GridGenerator::hyper_ball(ball);
    ball.refine_global(1);
    check("ball", ball, degree);
    Triangulation<3> torus;
    GridGenerator::torus(torus, 2., 0.5);
    check("torus", torus, degree);
  }
}
