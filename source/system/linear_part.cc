// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/linear_part.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace dovetail {

namespace {

/// Which directions of a hypercube are long, or which edges of a simplex: pairs of its vertices, in order.
using LongEdges = std::bitset<6>;

/// [node]: nodes of the same cell and their weights
using NodeSums = std::vector<std::vector<std::pair<unsigned int, double>>>;

template <int dim>
LongEdges long_directions(const typename dealii::DoFHandler<dim>::active_cell_iterator &cell,
                          const double smallest_ratio)
{
  LongEdges result;
  const auto lengths = edge_lengths<dim>(cell);
  const double shortest = *std::min_element(lengths.begin(), lengths.end());
  for (unsigned int d = 0; d < dim; ++d)
    result[d] = lengths[d] > smallest_ratio * shortest;
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
LongEdges long_edges(const typename dealii::DoFHandler<dim>::active_cell_iterator &cell,
                     const double smallest_stretch_of_hypercubes)
{
  return cell->reference_cell().is_hyper_cube() ? long_directions<dim>(cell, smallest_stretch_of_hypercubes)
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

/// The sums of the nodes of cells, which many cells share.
template <int dim>
class KnownSums
{
public:
  struct Sum
  {
    std::vector<unsigned int> nodes;
    unsigned int first_weight; ///< in the result
    bool is_itself;
  };

  KnownSums(const Domain<dim> &domain, const Block &block, const double smallest_stretch,
            const std::set<dealii::types::boundary_id> &tied)
      : domain(domain), block(block), field(domain.fields()[block.field_index]),
        smallest_stretch(smallest_stretch), tied(tied)
  {
  }

  const Sum &operator[](const unsigned int number) const { return sums[number]; }
  /// Calls @p visit(own unknown, number of its sum, the unknown of a node) for those of all cells.
  /// @param result gets the weights of new ones
  template <typename Visit>
  void for_each_node(RowSums &result, const Visit &visit);

private:
  unsigned int first_of(const typename dealii::DoFHandler<dim>::active_cell_iterator &cell, RowSums &result);

  const Domain<dim> &domain;
  const Block &block;
  const Field &field;
  const double smallest_stretch;
  const std::set<dealii::types::boundary_id> &tied;
  std::map<unsigned long, unsigned int> first; ///< that of the first node, by long edges
  std::vector<Sum> sums;
};

template <int dim>
unsigned int KnownSums<dim>::first_of(const typename dealii::DoFHandler<dim>::active_cell_iterator &cell,
                                      RowSums &result)
{
  bool is_tied = false;
  for (const unsigned int f : cell->face_indices())
    is_tied = is_tied || (cell->at_boundary(f) && tied.count(cell->face(f)->boundary_id()) > 0);
  const LongEdges is_long = long_edges<dim>(cell, is_tied ? dovetail::smallest_stretch : smallest_stretch);
  const auto [place, is_new] = first.try_emplace(is_long.to_ulong(), sums.size());
  if (!is_new)
    return place->second;
  const NodeSums node_sums =
      make_node_sums<dim>(domain.layout(), field.first_component, domain.cell_shape(), is_long);
  std::vector<double> weights;
  for (unsigned int a = 0; a < node_sums.size(); ++a) {
    sums.push_back({{}, 0, node_sums[a].size() == 1 && node_sums[a][0].first == a});
    weights.clear();
    for (const auto &[node, weight] : node_sums[a]) {
      sums.back().nodes.push_back(node);
      weights.push_back(weight);
    }
    sums.back().first_weight = result.add_weights(weights);
  }
  return place->second;
}

template <int dim>
template <typename Visit>
void KnownSums<dim>::for_each_node(RowSums &result, const Visit &visit)
{
  const CellLayout<dim> &layout = domain.layout();
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      const unsigned int first_sum = first_of(cell, result);
      domain.cell_dofs(cell, dofs);
      for (unsigned int c = field.first_component; c < field.first_component + field.n_components; ++c)
        for (unsigned int a = 0; a < layout.n_nodes(c); ++a)
          if (const auto dof = dofs[layout.index(c, a)]; block.owned.is_element(dof - block.begin))
            visit(block.owned.index_within_set(dof - block.begin), first_sum + a,
                  [&](const unsigned int node) { return dofs[layout.index(c, node)]; });
    }
}

} // namespace

/// One cell in which an edge is short is enough.
template <int dim>
RowSums linear_part(const Domain<dim> &domain, const Block &block,
                    const dealii::AffineConstraints<double> &constraints, const double smallest_stretch,
                    const std::set<dealii::types::boundary_id> &tied)
{
  const unsigned int none = dealii::numbers::invalid_unsigned_int;
  RowSums result;
  KnownSums<dim> known(domain, block, smallest_stretch, tied);
  std::vector<unsigned int> chosen(block.owned.n_elements(), none); // of the known ones
  known.for_each_node(result, [&](const unsigned int i, const unsigned int number, const auto &) {
    if (chosen[i] == none || known[chosen[i]].is_itself)
      chosen[i] = number;
  });
  std::size_t n_columns = 0;
  for (unsigned int i = 0; i < chosen.size(); ++i)
    n_columns += chosen[i] == none ? 0 : known[chosen[i]].nodes.size();
  result.reserve(chosen.size(), n_columns);
  unsigned int row = 0;
  for (const auto i : block.owned) {
    unsigned int &number = chosen[row++];
    if (constraints.is_constrained(block.begin + i)) {
      number = none;
      if (const auto *entries = constraints.get_constraint_entries(block.begin + i))
        result.add_row(*entries);
      else
        result.add_row(0, 0);
    } else if (number == none)
      result.add_row(0, 0);
    else
      result.add_row(known[number].nodes.size(), known[number].first_weight);
  }
  known.for_each_node(result, [&](const unsigned int i, const unsigned int number, const auto &unknown) {
    if (chosen[i] != number)
      return;
    std::transform(known[number].nodes.begin(), known[number].nodes.end(), result.columns_of(i), unknown);
    chosen[i] = none;
  });
  return result;
}

template RowSums linear_part(const Domain<2> &, const Block &, const dealii::AffineConstraints<double> &,
                             double, const std::set<dealii::types::boundary_id> &);
template RowSums linear_part(const Domain<3> &, const Block &, const dealii::AffineConstraints<double> &,
                             double, const std::set<dealii::types::boundary_id> &);

} // namespace dovetail
