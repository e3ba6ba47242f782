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

/// Which directions of a hypercube are long, or which edges of a simplex: pairs of its vertices, in order.
using LongEdges = std::bitset<6>;

/// [node]: nodes of the same cell and their weights
using NodeSums = std::vector<std::vector<std::pair<unsigned int, double>>>;

/// Edges of one direction are as long as they are on average.
template <int dim>
LongEdges long_directions(const typename dealii::DoFHandler<dim>::active_cell_iterator &cell)
{
  const double smallest_ratio = 2;
  LongEdges result;
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

/// A cube that is divided into 24 tetrahedra has edges twice as long as others.
template <int dim>
LongEdges long_edges_of_simplex(const typename dealii::DoFHandler<dim>::active_cell_iterator &cell)
{
  const double smallest_ratio = 3;
  LongEdges result;
  std::vector<double> length;
  for (unsigned int v = 0; v <= dim; ++v)
    for (unsigned int w = v + 1; w <= dim; ++w)
      length.push_back(cell->vertex(v).distance(cell->vertex(w)));
  const double shortest = *std::min_element(length.begin(), length.end());
  for (unsigned int e = 0; e < length.size(); ++e)
    result[e] = length[e] > smallest_ratio * shortest;
  return result;
}

template <int dim>
LongEdges long_edges(const typename dealii::DoFHandler<dim>::active_cell_iterator &cell)
{
  return cell->reference_cell().is_hyper_cube() ? long_directions<dim>(cell)
                                                : long_edges_of_simplex<dim>(cell);
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
NodeSums interpolate(const std::vector<dealii::Point<dim>> &nodes, const LongEdges &is_long)
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

/// From the vertices, with which the nodes of an element begin, unless a long edge joins two of those that a
/// node lies between.
template <int dim>
NodeSums interpolate_in_simplex(const std::vector<dealii::Point<dim>> &nodes,
                                const dealii::ReferenceCell &shape, const LongEdges &is_long)
{
  NodeSums sums(nodes.size());
  for (unsigned int a = 0; a < nodes.size(); ++a) {
    std::vector<double> weight;
    for (const unsigned int v : shape.vertex_indices()) {
      weight.push_back(shape.d_linear_shape_function(nodes[a], v));
      if (std::abs(weight.back()) > 1e-14)
        sums[a].emplace_back(v, weight.back());
    }
    bool is_along = false;
    for (unsigned int v = 0, edge = 0; v <= dim; ++v)
      for (unsigned int w = v + 1; w <= dim; ++w, ++edge)
        is_along = is_along || (is_long[edge] && weight[v] > 1e-14 && weight[w] > 1e-14);
    if (is_along)
      sums[a] = {{a, 1.}};
  }
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
                        const dealii::ReferenceCell &shape, const LongEdges &is_long)
{
  if (!layout.is_continuous(component))
    return themselves(layout.n_nodes(component));
  const auto &nodes = layout.element(component).get_unit_support_points();
  return shape.is_hyper_cube() ? interpolate<dim>(nodes, is_long)
                               : interpolate_in_simplex<dim>(nodes, shape, is_long);
}

} // namespace

template <int dim>
std::vector<std::vector<std::pair<dealii::types::global_dof_index, double>>>
linear_part(const Domain<dim> &domain, const Block &block)
{
  const Field &field = domain.fields()[block.field_index];
  const CellLayout<dim> &layout = domain.layout();
  std::map<unsigned long, NodeSums> known; // by long edges
  std::vector<std::vector<std::pair<dealii::types::global_dof_index, double>>> sums(block.owned.n_elements());
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      const LongEdges is_long = long_edges<dim>(cell);
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
