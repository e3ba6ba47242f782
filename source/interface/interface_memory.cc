// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/interface/interface_memory.h>

#include <deal.II/base/mpi.h>
#include <deal.II/numerics/rtree.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

namespace dovetail {

template <int dim>
void InterfaceMemory<dim>::set_points(const Pairing<dim> &pairing,
                                      const std::array<InterfaceSide<dim>, 2> &sides,
                                      const std::vector<double> &of_joint, const MPI_Comm &communicator)
{
  for (const unsigned int side : {source, destination, joint}) {
    const std::vector<double> &initial =
        side == joint ? of_joint : sides[side].domain->material.initial_memory();
    if (initial.empty())
      continue;
    const auto former_points = std::move(points[side]);
    const InternalVariables former = std::move(variables[side]);
    points[side].clear();
    for (unsigned int q = 0; q < pairing.n_points(); ++q)
      points[side].push_back(pairing.X(side == joint ? source : side, q));
    variables[side] = InternalVariables(points[side].size(), initial);
    if (has_points)
      copy_from_nearest(side, former, former_points, communicator);
  }
  has_points = true;
}

namespace {

/// Of the points that are as near to @p X as the nearest one, up to rounding, the first in the order of their
/// coordinates: rounding decides nothing.
template <int dim, typename Tree>
unsigned int find_nearest(const Tree &tree, const dealii::Point<dim> &X)
{
  const unsigned int most_neighbours = 8;
  std::vector<typename Tree::value_type> near;
  tree.query(boost::geometry::index::nearest(X, most_neighbours), std::back_inserter(near));
  const auto distance = [&](const auto &one) { return X.distance(one.first); };
  const auto comes_before = [&](const auto &one, const auto &other) {
    const double rounding = 1e-9 * (distance(one) + distance(other));
    if (std::abs(distance(one) - distance(other)) > rounding)
      return distance(one) < distance(other);
    for (unsigned int d = 0; d < dim; ++d)
      if (std::abs(one.first[d] - other.first[d]) > rounding)
        return one.first[d] < other.first[d];
    return false;
  };
  return std::min_element(near.begin(), near.end(), comes_before)->second;
}

} // namespace

/// All ranks look at all points, in an order that does not depend on the ranks.
template <int dim>
void InterfaceMemory<dim>::copy_from_nearest(const unsigned int side, const InternalVariables &former,
                                             const std::vector<dealii::Point<dim>> &former_points,
                                             const MPI_Comm &communicator)
{
  std::vector<std::vector<double>> own, all; // X, variables
  for (unsigned int q = 0; q < former_points.size(); ++q) {
    std::vector<double> row(former_points[q].begin_raw(), former_points[q].end_raw());
    const auto values = former.accepted(q);
    row.insert(row.end(), values.begin(), values.end());
    own.push_back(std::move(row));
  }
  for (const auto &other : dealii::Utilities::MPI::all_gather(communicator, own))
    all.insert(all.end(), other.begin(), other.end());
  if (all.empty())
    return;
  std::sort(all.begin(), all.end());

  std::vector<std::pair<dealii::Point<dim>, unsigned int>> numbered;
  for (unsigned int i = 0; i < all.size(); ++i)
    numbered.emplace_back(
        dealii::Point<dim>(dealii::Tensor<1, dim>(dealii::ArrayView<const double>(all[i].data(), dim))), i);
  const auto tree = dealii::pack_rtree(numbered);
  for (unsigned int q = 0; q < points[side].size(); ++q) {
    const std::vector<double> &row = all[find_nearest<dim>(tree, points[side][q])];
    variables[side].set_accepted(q, {row.data() + dim, row.size() - dim});
  }
}

template <int dim>
void InterfaceMemory<dim>::keep_joint(const unsigned int q)
{
  std::vector<double> values(variables[joint].accepted(q).begin(), variables[joint].accepted(q).end());
  variables[joint].set_trial(q, {values.data(), values.size()});
}

template <int dim>
void InterfaceMemory<dim>::accept()
{
  for (auto &side_variables : variables)
    side_variables.accept();
}

template <int dim>
std::vector<double> InterfaceMemory<dim>::pack(const unsigned int q) const
{
  std::vector<double> numbers;
  for (const auto &side_variables : variables)
    if (!side_variables.empty()) {
      const auto values = side_variables.accepted(q);
      numbers.insert(numbers.end(), values.begin(), values.end());
    }
  return numbers;
}

template <int dim>
void InterfaceMemory<dim>::unpack(const unsigned int q, const std::vector<double> &numbers)
{
  const double *begin = numbers.data();
  for (auto &side_variables : variables)
    if (!side_variables.empty()) {
      const auto n = side_variables.accepted(q).size();
      side_variables.set_accepted(q, {begin, n});
      begin += n;
    }
}

template class InterfaceMemory<2>;
template class InterfaceMemory<3>;

} // namespace dovetail
