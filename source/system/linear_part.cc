// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/linear_part.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <map>

namespace dovetail {

namespace {

/// Which directions of a cell are long.
template <int dim>
using Directions = std::bitset<dim>;

/// [node]: nodes of the same cell and their weights
using NodeSums = std::vector<std::vector<std::pair<unsigned int, double>>>;

template <int dim>
Directions<dim> long_directions(const typename dealii::DoFHandler<dim>::active_cell_iterator &cell)
{
  const double smallest_ratio = 2;
  Directions<dim> result;
  if (!cell->reference_cell().is_hyper_cube())
    return result;
  std::array<double, dim> length{};
  for (unsigned int d = 0; d < dim; ++d)
    for (const unsigned int v : cell->vertex_indices())
      if ((v & (1u << d)) == 0)
        length[d] += cell->vertex(v).distance(cell->vertex(v | (1u << d)));
  const double shortest = *std::min_element(length.begin(), length.end());
  for (unsigned int d = 0; d < dim; ++d)
    result[d] = length[d] > smallest_ratio * shortest;
  return result;
}

template <int dim>
unsigned int node_at(const std::vector<dealii::Point<dim>> &nodes, const dealii::Point<dim> &place)
{
  return std::min_element(nodes.begin(), nodes.end(),
                          [&](const auto &a, const auto &b) {
                            return a.distance_square(place) < b.distance_square(place);
                          }) -
         nodes.begin();
}

/// Linear interpolation in the short directions only.
template <int dim>
NodeSums interpolate(const std::vector<dealii::Point<dim>> &nodes, const Directions<dim> &is_long)
{
  NodeSums sums(nodes.size());
  for (unsigned int a = 0; a < nodes.size(); ++a) {
    std::vector<std::pair<dealii::Point<dim>, double>> places = {{nodes[a], 1.}};
    for (unsigned int d = 0; d < dim; ++d)
      if (const double x = nodes[a][d]; !is_long[d] && x > 1e-10 && x < 1 - 1e-10) {
        const unsigned int n = places.size();
        for (unsigned int i = 0; i < n; ++i) {
          places.push_back(places[i]);
          places[i].first[d] = 0;
          places[i].second *= 1 - x;
          places.back().first[d] = 1;
          places.back().second *= x;
        }
      }
    for (const auto &[place, weight] : places)
      sums[a].emplace_back(node_at(nodes, place), weight);
  }
  return sums;
}

/// Those of the vertices, with which the nodes of an element begin.
template <int dim>
NodeSums interpolate_in_simplex(const std::vector<dealii::Point<dim>> &nodes,
                                const dealii::ReferenceCell &shape)
{
  NodeSums sums(nodes.size());
  for (unsigned int a = 0; a < nodes.size(); ++a)
    for (const unsigned int v : shape.vertex_indices())
      if (const double weight = shape.d_linear_shape_function(nodes[a], v); std::abs(weight) > 1e-14)
        sums[a].emplace_back(v, weight);
  return sums;
}

NodeSums themselves(const unsigned int n_nodes)
{
  NodeSums sums(n_nodes);
  for (unsigned int a = 0; a < n_nodes; ++a)
    sums[a].emplace_back(a, 1.);
  return sums;
}

template <int dim>
NodeSums make_node_sums(const CellLayout<dim> &layout, const unsigned int component,
                        const dealii::ReferenceCell &shape, const Directions<dim> &is_long)
{
  if (!layout.is_continuous(component))
    return themselves(layout.n_nodes(component));
  const auto &nodes = layout.element(component).get_unit_support_points();
  return shape.is_hyper_cube() ? interpolate<dim>(nodes, is_long) : interpolate_in_simplex<dim>(nodes, shape);
}

} // namespace

template <int dim>
std::vector<std::vector<std::pair<dealii::types::global_dof_index, double>>>
linear_part(const Domain<dim> &domain, const Block &block)
{
  const Field &field = domain.fields()[block.field_index];
  const CellLayout<dim> &layout = domain.layout();
  std::map<unsigned long, NodeSums> known; // by long directions
  std::vector<std::vector<std::pair<dealii::types::global_dof_index, double>>> sums(block.owned.n_elements());
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      const Directions<dim> is_long = long_directions<dim>(cell);
      NodeSums &node_sums = known[is_long.to_ulong()];
      if (node_sums.empty())
        node_sums = make_node_sums<dim>(layout, field.first_component, domain.cell_shape(), is_long);
      domain.cell_dofs(cell, dofs);
      for (unsigned int c = field.first_component; c < field.first_component + field.n_components; ++c)
        for (unsigned int a = 0; a < node_sums.size(); ++a) {
          const auto dof = dofs[layout.index(c, a)];
          if (!block.owned.is_element(dof - block.begin))
            continue;
          auto &sum = sums[block.owned.index_within_set(dof - block.begin)];
          if (sum.empty() || sum[0].first == dof) { // one cell in which its edge is short is enough
            sum.clear();
            for (const auto &[node, weight] : node_sums[a])
              sum.emplace_back(dofs[layout.index(c, node)], weight);
          }
        }
    }
  return sums;
}

template std::vector<std::vector<std::pair<dealii::types::global_dof_index, double>>>
linear_part(const Domain<2> &domain, const Block &block);
template std::vector<std::vector<std::pair<dealii::types::global_dof_index, double>>>
linear_part(const Domain<3> &domain, const Block &block);

} // namespace dovetail
