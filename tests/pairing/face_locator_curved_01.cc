// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Strongly curved faces (three around a ring, six around a sphere), far points on both sides: no point of a
// dense sample of the faces is closer than the one found, and the sample comes close to it.

#include "face_locator_queries.h"

using namespace dealii;

/// The squared distance from @p X to a dense sample of all faces.
template <int dim>
double sampled_distance(const std::vector<Point<dim>> &sample, const Point<dim> &X)
{
  double square = std::numeric_limits<double>::max();
  for (const Point<dim> &point : sample)
    square = std::min(square, point.distance_square(X));
  return std::sqrt(square);
}

template <int dim>
void check(const unsigned int degree)
{
  // Every rank does the same.
  Triangulation<dim> triangulation;
  GridGenerator::hyper_shell(triangulation, Point<dim>(), 0.5, 1., dim == 2 ? 3 : 6, true);
  const MappingQ<dim> mapping(degree);
  std::vector<Point<dim>> sample;
  for (const auto &point : locator_test::queries_of_side<dim>(
           triangulation, mapping, 1, QIterated<dim - 1>(QTrapezoid<1>(), dim == 2 ? 1000 : 30)))
    sample.push_back(point.X);

  const dovetail::FaceLocator<dim> locator(locator_test::faces_with(1, triangulation, mapping, degree), 1.,
                                           0., MPI_COMM_SELF);
  unsigned int found = 0, points = 0;
  double closer = -1, farther = -1;
  for (const double radius : {0.6, 0.9, 1.3, 1.8}) {
    locator_test::Queries<dim> queries =
        locator_test::queries_of_side<dim>(triangulation, mapping, 1, QGauss<dim - 1>(dim == 2 ? 4 : 2));
    for (auto &query : queries) {
      query.X *= radius;
      query.N *= -1;
    }
    const auto matches = locator.locate(queries);
    for (unsigned int i = 0; i < queries.size(); ++i, ++points)
      if (matches[i].found) {
        ++found;
        const double distance = sampled_distance(sample, queries[i].X);
        farther = std::max(farther, matches[i].distance - distance);
        closer = std::max(closer, distance - matches[i].distance);
      }
  }
  locator_test::print(std::to_string(dim) + "D, degree " + std::to_string(degree) + ": found " +
                      std::to_string(found) + " of " + std::to_string(points) + ", never farther " +
                      std::to_string(farther < 1e-14) + ", hardly closer " +
                      std::to_string(closer < (dim == 2 ? 1e-5 : 1e-2)));
}

int main(int argc, char *argv[])
{
  Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const unsigned int degree : {1, 2, 3, 4}) {
    check<2>(degree);
    check<3>(degree);
  }
}
