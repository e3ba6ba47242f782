// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/extreme_places.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <limits>

namespace dovetail {

namespace {

template <int dim>
struct Extreme
{
  double value = -std::numeric_limits<double>::max(); ///< times -1 for a minimum
  std::vector<dealii::Point<dim>> vertices;

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &value &vertices;
  }
};

/// In the order of their distance from the point.
template <int dim>
std::vector<dealii::Point<dim>> nearest_vertices(const DomainPoint<dim> &point)
{
  std::vector<dealii::Point<dim>> vertices;
  for (const unsigned int v : point.cell()->vertex_indices())
    vertices.push_back(point.cell()->vertex(v));
  std::sort(vertices.begin(), vertices.end(), [&](const auto &one, const auto &other) {
    return one.distance(point.state().X) < other.distance(point.state().X);
  });
  vertices.resize(dim - 1);
  return vertices;
}

} // namespace

template <int dim>
std::vector<std::vector<dealii::Point<dim>>>
places_of_extremes(const Region<dim> &region, const Quantity<dim> &quantity, const Reduce how,
                   const Vector &solution, const double t)
{
  const double sign = how == Reduce::minimum ? -1 : 1;
  std::vector<Extreme<dim>> extremes(quantity.n_numbers());
  std::vector<double> numbers;
  visit_points<dim>(region, solution, t, [&](DomainPoint<dim> &point, double) {
    numbers.clear();
    quantity.evaluate(point, numbers);
    for (unsigned int i = 0; i < numbers.size(); ++i)
      if (sign * numbers[i] > extremes[i].value)
        extremes[i] = {sign * numbers[i], nearest_vertices(point)};
  });
  std::vector<Extreme<dim>> largest(extremes.size());
  for (const auto &of_rank :
       dealii::Utilities::MPI::all_gather(solution.block(0).get_mpi_communicator(), extremes))
    for (unsigned int i = 0; i < largest.size(); ++i)
      if (of_rank[i].value > largest[i].value)
        largest[i] = of_rank[i];
  std::vector<std::vector<dealii::Point<dim>>> result;
  for (const auto &extreme : largest)
    result.push_back(extreme.vertices);
  return result;
}

template std::vector<std::vector<dealii::Point<2>>> places_of_extremes(const Region<2> &, const Quantity<2> &,
                                                                       Reduce, const Vector &, double);
template std::vector<std::vector<dealii::Point<3>>> places_of_extremes(const Region<3> &, const Quantity<3> &,
                                                                       Reduce, const Vector &, double);

} // namespace dovetail
