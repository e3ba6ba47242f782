// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_order.h>

#include <deal.II/base/utilities.h>

#include <algorithm>
#include <numeric>

namespace dovetail {

namespace {

using Order = std::vector<std::size_t>; // of cells: those of the file, one after the other

Order order_of_file(const MeshFile &mesh)
{
  Order order(mesh.cells.size());
  std::iota(order.begin(), order.end(), 0);
  return order;
}

template <int dim>
Order order_along_curve(const MeshFile &mesh)
{
  std::vector<dealii::Point<dim>> centres(mesh.cells.size());
  for (std::size_t c = 0; c < centres.size(); ++c)
    for (unsigned int v = 0; v < mesh.cells.n_nodes(c); ++v)
      for (unsigned int d = 0; d < dim; ++d)
        centres[c][d] += mesh.nodes[mesh.cells.nodes_of(c)[v]][d] / mesh.cells.n_nodes(c);
  const auto places = dealii::Utilities::inverse_Hilbert_space_filling_curve<dim>(centres, 20);
  Order order = order_of_file(mesh);
  std::stable_sort(order.begin(), order.end(),
                   [&](const auto one, const auto other) { return places[one] < places[other]; });
  return order;
}

/// Steps from a cell at a node to the next one there: all, and those that pass more than 256 cells.
struct Steps
{
  std::size_t n = 0, n_long = 0;
};

Steps count_steps(const MeshFile &mesh, const Order &order)
{
  constexpr std::size_t none = -1, long_step = 256;
  std::vector<std::size_t> last(mesh.nodes.size(), none); // place of a cell at each node
  Steps steps;
  for (std::size_t place = 0; place < order.size(); ++place) {
    const std::size_t c = order[place];
    for (unsigned int v = 0; v < mesh.cells.n_nodes(c); ++v) {
      std::size_t &before = last[mesh.cells.nodes_of(c)[v]];
      if (before != none) {
        ++steps.n;
        steps.n_long += place - before > long_step;
      }
      before = place;
    }
  }
  return steps;
}

void sort_cells(const Order &order, MeshFile &mesh)
{
  const std::size_t n_further = mesh.further_nodes.size() / order.size(); // of a cell
  MeshElements cells;
  std::vector<dealii::Point<3>> further_nodes;
  further_nodes.reserve(mesh.further_nodes.size());
  for (const std::size_t c : order) {
    const unsigned int *const nodes = mesh.cells.nodes_of(c);
    cells.add(mesh.cells.numbers[c], mesh.cells.ids[c], {nodes, nodes + mesh.cells.n_nodes(c)});
    further_nodes.insert(further_nodes.end(), mesh.further_nodes.begin() + c * n_further,
                         mesh.further_nodes.begin() + (c + 1) * n_further);
  }
  mesh.cells = std::move(cells);
  mesh.further_nodes = std::move(further_nodes);
}

/// Those that no cell has stand last.
void sort_nodes(MeshFile &mesh)
{
  const unsigned int none = -1;
  std::vector<unsigned int> new_index(mesh.nodes.size(), none);
  unsigned int next = 0;
  for (const unsigned int node : mesh.cells.nodes)
    if (new_index[node] == none)
      new_index[node] = next++;
  for (unsigned int &index : new_index)
    if (index == none)
      index = next++;

  const auto nodes = mesh.nodes;
  const auto numbers = mesh.node_numbers;
  for (std::size_t node = 0; node < nodes.size(); ++node) {
    mesh.nodes[new_index[node]] = nodes[node];
    mesh.node_numbers[new_index[node]] = numbers[node];
  }
  for (auto *const of_elements : {&mesh.cells.nodes, &mesh.faces.nodes})
    for (unsigned int &node : *of_elements)
      node = new_index[node];
}

} // namespace

template <int dim>
void sort_scattered_cells(MeshFile &mesh)
{
  const Steps as_they_are = count_steps(mesh, order_of_file(mesh));
  if (5 * as_they_are.n_long <= as_they_are.n)
    return;
  const Order along_curve = order_along_curve<dim>(mesh);
  if (as_they_are.n_long <= 8 * count_steps(mesh, along_curve).n_long)
    return;
  sort_cells(along_curve, mesh);
  sort_nodes(mesh);
}

template void sort_scattered_cells<2>(MeshFile &);
template void sort_scattered_cells<3>(MeshFile &);

} // namespace dovetail
