// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The order of the cells of a file: triangles and tetrahedra of a grid whose cells stand in a random order
// are sorted, so that the next cell at a node is near. Every cell keeps its number, its id, its corners and
// further nodes, every node its number, and the faces remain where they are. Cells in columns keep their
// order, as do the scattered cells of a small mesh and a mesh without cells at the same node.

#include "../system/scene_model.h"

#include <dovetail/domain/cell_order.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <random>

using namespace test;

namespace {

/// A grid of n^dim squares or cubes in (0, 1)^dim, each divided into dim! simplices (Kuhn, 1960), column by
/// column along the last direction. The further nodes of a cell lie a little beside the middles of its edges,
/// those of the faces at x = 0 are given, one node has no cell.
template <int dim>
MeshFile grid(const unsigned int n)
{
  MeshFile mesh;
  const unsigned int n_nodes = dim == 2 ? (n + 1) * (n + 1) : (n + 1) * (n + 1) * (n + 1);
  for (unsigned int i = 0; i <= n_nodes; ++i) {
    dealii::Point<3> X;
    for (unsigned int d = 0, rest = i; d < dim; ++d, rest /= n + 1)
      X[dim - 1 - d] = double(rest % (n + 1)) / n;
    mesh.nodes.push_back(i < n_nodes ? X : dealii::Point<3>(7, 7, 7));
    mesh.node_numbers.push_back(1000 + 3 * i);
  }
  std::array<unsigned int, dim> stride;
  stride[dim - 1] = 1;
  for (unsigned int d = dim - 1; d > 0; --d)
    stride[d - 1] = stride[d] * (n + 1);
  for (unsigned int i = 0; i < n_nodes; ++i) {
    const bool is_last =
        std::any_of(stride.begin(), stride.end(), [&](const unsigned int s) { return i / s % (n + 1) == n; });
    std::array<unsigned int, dim> path;
    std::iota(path.begin(), path.end(), 0);
    do {
      std::vector<unsigned int> nodes = {i};
      for (const unsigned int d : path)
        nodes.push_back(nodes.back() + stride[d]);
      if (is_last)
        break;
      mesh.cells.add(50 + 2 * mesh.cells.size(), i % 5, nodes);
      for (unsigned int a = 0; a <= dim; ++a)
        for (unsigned int b = a + 1; b <= dim; ++b)
          mesh.further_nodes.push_back(
              dealii::Point<3>(0.51 * mesh.nodes[nodes[a]] + 0.49 * mesh.nodes[nodes[b]]));
      if (i < stride[0] && path.back() == 0) // the face of its first vertices, at x = 0
        mesh.faces.add(mesh.faces.size(), 4, {nodes.begin(), nodes.end() - 1});
    } while (std::next_permutation(path.begin(), path.end()));
  }
  return mesh;
}

/// In a random order, which is the same on every machine.
template <int dim>
MeshFile scattered(const MeshFile &mesh)
{
  std::mt19937 generator(7);
  std::vector<std::pair<unsigned int, std::size_t>> places;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c)
    places.emplace_back(generator(), c);
  std::sort(places.begin(), places.end());
  MeshFile result = mesh;
  result.cells = MeshElements();
  result.further_nodes.clear();
  constexpr unsigned int n_edges = dim * (dim + 1) / 2;
  for (const auto &[random, c] : places) {
    const unsigned int *const nodes = mesh.cells.nodes_of(c);
    result.cells.add(mesh.cells.numbers[c], mesh.cells.ids[c], {nodes, nodes + dim + 1});
    for (unsigned int e = 0; e < n_edges; ++e)
      result.further_nodes.push_back(mesh.further_nodes[c * n_edges + e]);
  }
  return result;
}

/// The share of steps from a cell at a node to the next one there that pass more than 256 cells.
double share_of_long_steps(const MeshFile &mesh)
{
  std::map<unsigned int, std::size_t> last;
  double n = 0, n_long = 0;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c)
    for (unsigned int v = 0; v < mesh.cells.n_nodes(c); ++v) {
      const unsigned int node = mesh.cells.nodes_of(c)[v];
      if (const auto found = last.find(node); found != last.end()) {
        ++n;
        n_long += c - found->second > 256;
      }
      last[node] = c;
    }
  return n > 0 ? n_long / n : 0;
}

using Coordinates = std::vector<std::array<double, 3>>;

std::array<double, 3> coordinates(const dealii::Point<3> &X)
{
  return {{X[0], X[1], X[2]}};
}

/// What belongs to the elements, by their numbers: id, vertices, further nodes.
std::map<std::int64_t, std::pair<unsigned int, Coordinates>>
content(const MeshFile &mesh, const MeshElements &elements,
        const std::vector<dealii::Point<3>> &further_nodes)
{
  std::map<std::int64_t, std::pair<unsigned int, Coordinates>> result;
  const std::size_t n_further = further_nodes.size() / elements.size();
  for (std::size_t e = 0; e < elements.size(); ++e) {
    auto &[id, points] = result[elements.numbers[e]];
    id = elements.ids[e];
    for (unsigned int v = 0; v < elements.n_nodes(e); ++v)
      points.push_back(coordinates(mesh.nodes[elements.nodes_of(e)[v]]));
    for (std::size_t i = 0; i < n_further; ++i)
      points.push_back(coordinates(further_nodes[e * n_further + i]));
  }
  return result;
}

std::map<std::int64_t, std::array<double, 3>> nodes_by_number(const MeshFile &mesh)
{
  std::map<std::int64_t, std::array<double, 3>> result;
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    result[mesh.node_numbers[i]] = coordinates(mesh.nodes[i]);
  return result;
}

template <int dim>
void show(const unsigned int n, const unsigned int n_of_small)
{
  const MeshFile before = scattered<dim>(grid<dim>(n));
  MeshFile mesh = before;
  sort_scattered_cells<dim>(mesh);
  print(std::to_string(dim) + "D, long steps before and after",
        {share_of_long_steps(before), share_of_long_steps(mesh)});
  report("  the same cells", content(mesh, mesh.cells, mesh.further_nodes) ==
                                 content(before, before.cells, before.further_nodes));
  report("  the same faces", content(mesh, mesh.faces, {}) == content(before, before.faces, {}));
  report("  the same nodes", nodes_by_number(mesh) == nodes_by_number(before));
  report("  nodes by their first cell", mesh.cells.nodes[0] == 0 && mesh.cells.nodes[dim] == dim);

  MeshFile in_columns = grid<dim>(n);
  const auto numbers = in_columns.cells.numbers;
  sort_scattered_cells<dim>(in_columns);
  report("  columns as they are", in_columns.cells.numbers == numbers);

  MeshFile small = scattered<dim>(grid<dim>(n_of_small));
  const auto numbers_of_small = small.cells.numbers;
  sort_scattered_cells<dim>(small);
  report("  a small mesh as it is", small.cells.numbers == numbers_of_small);
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  show<2>(60, 8);
  show<3>(16, 2);

  MeshFile apart; // cells without common nodes
  for (unsigned int c = 0; c < 1000; ++c) {
    for (unsigned int v = 0; v < 3; ++v) {
      apart.nodes.emplace_back(c % 7 + (v == 1), c % 11 + (v == 2), 0.);
      apart.node_numbers.push_back(apart.nodes.size());
    }
    apart.cells.add(c, 0, {3 * c, 3 * c + 1, 3 * c + 2});
  }
  const auto numbers = apart.cells.numbers;
  sort_scattered_cells<2>(apart);
  report("cells apart as they are", apart.cells.numbers == numbers);
}
