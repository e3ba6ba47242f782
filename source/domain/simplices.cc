// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The division of tetrahedra: J. Bey, Tetrahedral grid refinement, Computing 55 (1995). deal.II's own
// flattens them more and more before version 9.6.

#include <dovetail/domain/geometry.h>
#include <dovetail/domain/mesh_note.h>
#include <dovetail/domain/simplices.h>

#include "whole_mesh.h"

#include <deal.II/base/mpi.h>
#include <deal.II/distributed/fully_distributed_tria.h>
#include <deal.II/fe/fe_simplex_p.h>
#include <deal.II/fe/mapping_fe.h>
#include <deal.II/grid/cell_id.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/grid/grid_tools.h>
#include <deal.II/grid/tria_description.h>
#include <deal.II/lac/sparsity_tools.h>

#include <algorithm>
#include <map>
#include <unordered_map>

namespace dovetail {

namespace {

using Simplex = std::vector<unsigned int>; // indices of its vertices

/// The vertex in the middle of an edge, made when it is first asked for.
template <int dim>
class Middles
{
public:
  explicit Middles(std::vector<dealii::Point<dim>> &vertices) : vertices(vertices) {}

  unsigned int operator()(const unsigned int a, const unsigned int b)
  {
    const auto [middle, is_new] = node_on_edge.insert({std::minmax(a, b), vertices.size()});
    if (is_new)
      vertices.push_back((vertices[a] + vertices[b]) / 2);
    return middle->second;
  }

  /// The middle of a curved edge.
  void place(const unsigned int a, const unsigned int b, const dealii::Point<dim> &X)
  {
    vertices[(*this)(a, b)] = X;
  }

  const dealii::Point<dim> &point(const unsigned int vertex) const { return vertices[vertex]; }

private:
  std::vector<dealii::Point<dim>> &vertices;
  std::map<std::pair<unsigned int, unsigned int>, unsigned int> node_on_edge;
};

template <int dim>
std::vector<Simplex> divide_line(const Simplex &v, Middles<dim> &middle)
{
  const unsigned int m = middle(v[0], v[1]);
  return {{v[0], m}, {m, v[1]}};
}

template <int dim>
std::vector<Simplex> divide_triangle(const Simplex &v, Middles<dim> &middle)
{
  const unsigned int m01 = middle(v[0], v[1]), m12 = middle(v[1], v[2]), m20 = middle(v[2], v[0]);
  return {{v[0], m01, m20}, {m01, v[1], m12}, {m20, m12, v[2]}, {m01, m12, m20}};
}

/// Four parts at the vertices and four around the shortest diagonal of the octahedron that is left.
std::vector<Simplex> divide_tetrahedron(const Simplex &v, Middles<3> &middle)
{
  const unsigned int m01 = middle(v[0], v[1]), m02 = middle(v[0], v[2]), m03 = middle(v[0], v[3]),
                     m12 = middle(v[1], v[2]), m13 = middle(v[1], v[3]), m23 = middle(v[2], v[3]);
  std::vector<Simplex> parts = {
      {v[0], m01, m02, m03}, {m01, v[1], m12, m13}, {m02, m12, v[2], m23}, {m03, m13, m23, v[3]}};

  const std::vector<std::pair<Simplex, Simplex>> diagonals = {{{m01, m23}, {m02, m03, m13, m12}},
                                                              {{m02, m13}, {m01, m12, m23, m03}},
                                                              {{m03, m12}, {m01, m02, m23, m13}}};
  const auto square = [&](const unsigned int i) {
    return middle.point(diagonals[i].first[0]).distance_square(middle.point(diagonals[i].first[1]));
  };
  unsigned int shortest = 0;
  for (const unsigned int i : {1, 2})
    if (square(i) < (1 - 1e-9) * square(shortest))
      shortest = i;
  const auto &[ends, around] = diagonals[shortest];
  for (unsigned int i = 0; i < 4; ++i)
    parts.push_back({ends[0], ends[1], around[i], around[(i + 1) % 4]});
  for (Simplex &part : parts) {
    const auto edge = [&](const unsigned int i) { return middle.point(part[i]) - middle.point(part[0]); };
    if (dealii::cross_product_3d(edge(1), edge(2)) * edge(3) < 0)
      std::swap(part[2], part[3]);
  }
  return parts;
}

/// @p id: the material id of cells, the boundary id of faces, which share their place.
template <int structdim>
void append(const std::vector<Simplex> &parts, const unsigned int id,
            std::vector<dealii::CellData<structdim>> &data)
{
  for (const Simplex &part : parts) {
    data.emplace_back(part.size());
    std::copy(part.begin(), part.end(), data.back().vertices.begin());
    data.back().material_id = id;
  }
}

/// The edges of a simplex, as pairs of its vertices.
template <int dim>
std::array<std::array<unsigned int, 2>, dim *(dim + 1) / 2> edges()
{
  std::array<std::array<unsigned int, 2>, dim *(dim + 1) / 2> result;
  for (unsigned int i = 0, edge = 0; i <= dim; ++i)
    for (unsigned int j = i + 1; j <= dim; ++j)
      result[edge++] = {{i, j}};
  return result;
}

template <int dim>
dealii::Point<dim> reference_vertex(const unsigned int i)
{
  return i == 0 ? dealii::Point<dim>() : dealii::Point<dim>::unit_vector(i - 1);
}

/// The edge on which each support point of the quadratic element lies that is no vertex.
template <int dim>
std::vector<unsigned int> edges_of_support_points()
{
  const SimplexBasis<dim> quadratic(2);
  std::vector<unsigned int> result;
  for (unsigned int a = dim + 1; a < quadratic.size(); ++a)
    for (unsigned int e = 0; e < edges<dim>().size(); ++e)
      if (const auto [i, j] = edges<dim>()[e];
          quadratic.support_points()[a].distance(
              dealii::Point<dim>((reference_vertex<dim>(i) + reference_vertex<dim>(j)) / 2)) < 0.1)
        result.push_back(e);
  return result;
}

/// Its nodes in the order of the support points of the quadratic element.
template <int dim, typename Edges>
std::vector<dealii::Point<dim>> nodes_of_cell(const typename dealii::Triangulation<dim>::cell_iterator &cell,
                                              const Edges &nodes_on_edges)
{
  static const std::vector<unsigned int> order = edges_of_support_points<dim>();
  std::vector<dealii::Point<dim>> nodes;
  nodes.reserve(dim + 1 + order.size());
  for (const unsigned int v : cell->vertex_indices())
    nodes.push_back(cell->vertex(v));
  for (const unsigned int e : order)
    nodes.push_back(nodes_on_edges[e]);
  return nodes;
}

/// The nodes on the edges of the parts of a curved cell: images of the middles in its reference coordinates.
template <int dim>
void divide_edges(const typename dealii::Triangulation<dim>::cell_iterator &cell,
                  const std::vector<Simplex> &parts, const FurtherNodes<dim> &nodes_on_edges,
                  Middles<dim> &middle, FurtherNodes<dim> &result)
{
  static const SimplexBasis<dim> quadratic(2);
  static std::vector<double> values(quadratic.size());
  static std::vector<dealii::Tensor<1, dim>> no_gradients;
  static std::vector<dealii::Tensor<2, dim>> no_hessians;
  const auto nodes = nodes_of_cell<dim>(cell, nodes_on_edges[cell->active_cell_index()]);
  std::map<unsigned int, dealii::Point<dim>> place; // of the vertices of the parts in the cell
  for (const unsigned int v : cell->vertex_indices())
    place[cell->vertex_index(v)] = reference_vertex<dim>(v);
  for (const auto [i, j] : edges<dim>())
    place[middle(cell->vertex_index(i), cell->vertex_index(j))] =
        dealii::Point<dim>((reference_vertex<dim>(i) + reference_vertex<dim>(j)) / 2);
  for (const Simplex &part : parts) {
    result.emplace_back(edges<dim>().size());
    for (unsigned int e = 0; e < edges<dim>().size(); ++e) {
      const auto [i, j] = edges<dim>()[e];
      quadratic.evaluate(dealii::Point<dim>((place.at(part[i]) + place.at(part[j])) / 2), values,
                         no_gradients, no_hessians);
      for (unsigned int a = 0; a < nodes.size(); ++a)
        result.back()[e] += values[a] * nodes[a];
    }
  }
}

/// Divide every triangle into 4, every tetrahedron into 8.
template <int dim>
void divide_simplices(dealii::Triangulation<dim> &mesh, FurtherNodes<dim> &nodes_on_edges)
{
  std::vector<dealii::Point<dim>> vertices = mesh.get_vertices();
  Middles<dim> middle(vertices);
  FurtherNodes<dim> part_nodes;
  std::vector<dealii::CellData<dim>> cells;
  dealii::SubCellData faces;
  for (const auto &cell : mesh.active_cell_iterators()) {
    const auto v = [&](const unsigned int i) { return cell->vertex_index(i); };
    for (unsigned int e = 0; e < edges<dim>().size() && !nodes_on_edges.empty(); ++e)
      middle.place(v(edges<dim>()[e][0]), v(edges<dim>()[e][1]),
                   nodes_on_edges[cell->active_cell_index()][e]);
    std::vector<Simplex> parts;
    if constexpr (dim == 2)
      parts = divide_triangle({v(0), v(1), v(2)}, middle);
    else
      parts = divide_tetrahedron({v(0), v(1), v(2), v(3)}, middle);
    append(parts, cell->material_id(), cells);
    if (!nodes_on_edges.empty())
      divide_edges<dim>(cell, parts, nodes_on_edges, middle, part_nodes);
    for (const auto &face : cell->face_iterators())
      if (face->at_boundary()) {
        const auto w = [&](const unsigned int i) { return face->vertex_index(i); };
        if constexpr (dim == 2)
          append(divide_line({w(0), w(1)}, middle), face->boundary_id(), faces.boundary_lines);
        else
          append(divide_triangle({w(0), w(1), w(2)}, middle), face->boundary_id(), faces.boundary_quads);
      }
  }
  mesh.clear();
  mesh.create_triangulation(vertices, cells, faces);
  nodes_on_edges = std::move(part_nodes);
}

/// @return in 3D: by vertex whether it was added
template <int dim>
std::vector<bool> convert_hypercubes(dealii::Triangulation<dim> &mesh)
{
  dealii::Triangulation<dim> flat, simplices;
  dealii::GridGenerator::flatten_triangulation(mesh, flat);
  for (const auto id : flat.get_manifold_ids())
    if (id != dealii::numbers::flat_manifold_id)
      flat.set_manifold(id, mesh.get_manifold(id));
  dealii::GridGenerator::convert_hypercube_to_simplex_mesh(flat, simplices);
  mesh.clear();
  mesh.copy_triangulation(simplices);
  if constexpr (dim == 2)
    return {};
  const auto coordinates = [](const dealii::Point<dim> &X) {
    std::array<double, dim> result;
    std::copy_n(X.begin_raw(), dim, result.begin());
    return result;
  };
  std::vector<std::array<double, dim>> given;
  std::transform(flat.get_vertices().begin(), flat.get_vertices().end(), std::back_inserter(given),
                 coordinates);
  std::sort(given.begin(), given.end());
  std::vector<bool> is_added;
  for (const auto &vertex : mesh.get_vertices())
    is_added.push_back(!std::binary_search(given.begin(), given.end(), coordinates(vertex)));
  return is_added;
}

/// A base of meshes with the nodes on the edges of this rank's cells, known by the number in their CellId.
template <int dim>
class WithSimplices
{
public:
  virtual ~WithSimplices() = default;
  std::unordered_map<dealii::types::coarse_cell_id, typename FurtherNodes<dim>::value_type> nodes_on_edges;
  bool is_curved = false;     ///< also on ranks without cells
  bool was_divided = false;   ///< from one of hexahedra
  std::vector<bool> is_added; ///< then, by vertex of this rank
};

template <int dim, typename Base>
class MeshOfSimplices : public Base, public WithSimplices<dim>, public WithNote
{
public:
  using Base::Base;
};

/// A rank that is alone copies the mesh, in a fiftieth of the time in which deal.II distributes one.
template <int dim>
std::unique_ptr<Mesh<dim>> copy(const dealii::Triangulation<dim> &mesh, const MPI_Comm &communicator)
{
  auto result = std::make_unique<MeshOfSimplices<dim, WholeMesh<dim>>>(communicator);
  result->copy_triangulation(mesh);
  return result;
}

template <int dim>
std::unique_ptr<Mesh<dim>> share_out(dealii::Triangulation<dim> &mesh, const unsigned int n_ranks,
                                     const MPI_Comm &communicator)
{
  if (mesh.n_active_cells() > n_ranks)
    dealii::GridTools::partition_triangulation(n_ranks, mesh, dealii::SparsityTools::Partitioner::metis);
  else // METIS wants more
    for (const auto &cell : mesh.active_cell_iterators())
      cell->set_subdomain_id(cell->active_cell_index());
  auto result =
      std::make_unique<MeshOfSimplices<dim, dealii::parallel::fullydistributed::Triangulation<dim>>>(
          communicator);
  result->create_triangulation(
      dealii::TriangulationDescription::Utilities::create_description_from_triangulation(mesh, communicator));
  return result;
}

template <int dim>
class QuadraticMapping : public dealii::MappingFE<dim>
{
public:
  explicit QuadraticMapping(const WithSimplices<dim> &mesh)
      : dealii::MappingFE<dim>(dealii::FE_SimplexP<dim>(2)), mesh(mesh)
  {
  }

  std::unique_ptr<dealii::Mapping<dim>> clone() const override
  {
    return std::make_unique<QuadraticMapping>(mesh);
  }

protected:
  std::vector<dealii::Point<dim>> compute_mapping_support_points(
      const typename dealii::Triangulation<dim>::cell_iterator &cell) const override
  {
    return nodes_of_cell<dim>(cell, mesh.nodes_on_edges.at(cell->id().get_coarse_cell_id()));
  }

private:
  const WithSimplices<dim> &mesh;
};

} // namespace

template <int dim>
std::vector<bool> make_simplices(const unsigned int n_refinements, dealii::Triangulation<dim> &mesh,
                                 FurtherNodes<dim> &nodes_on_edges)
{
  std::vector<bool> is_added;
  if (mesh.all_reference_cells_are_simplex())
    for (unsigned int i = 0; i < n_refinements; ++i)
      divide_simplices(mesh, nodes_on_edges);
  else {
    mesh.refine_global(n_refinements);
    is_added = convert_hypercubes(mesh);
  }
  mesh.reset_all_manifolds();
  mesh.set_all_manifold_ids(dealii::numbers::flat_manifold_id);
  return is_added;
}

template <int dim>
std::unique_ptr<Mesh<dim>>
distribute(dealii::Triangulation<dim> &mesh, const FurtherNodes<dim> &nodes_on_edges,
           const std::vector<bool> &is_added, const std::string &note, const MPI_Comm &communicator)
{
  const unsigned int n_ranks = dealii::Utilities::MPI::n_mpi_processes(communicator);
  auto distributed = n_ranks == 1 ? copy(mesh, communicator) : share_out(mesh, n_ranks, communicator);
  dynamic_cast<WithNote &>(*distributed).note = note;
  auto &simplices = dynamic_cast<WithSimplices<dim> &>(*distributed);
  simplices.is_curved = !nodes_on_edges.empty();
  simplices.was_divided = !is_added.empty();
  for (const auto &cell : distributed->active_cell_iterators())
    if (simplices.is_curved && !cell->is_artificial()) {
      const auto number = cell->id().get_coarse_cell_id();
      simplices.nodes_on_edges[number] = nodes_on_edges[number];
    }
  if (simplices.was_divided) {
    simplices.is_added.resize(distributed->n_vertices());
    std::vector<typename dealii::Triangulation<dim>::active_cell_iterator> given;
    for (const auto &cell : mesh.active_cell_iterators())
      given.push_back(cell);
    for (const auto &cell : distributed->active_cell_iterators())
      for (const unsigned int v : cell->vertex_indices())
        if (!cell->is_artificial())
          simplices.is_added[cell->vertex_index(v)] =
              is_added[given[cell->id().get_coarse_cell_id()]->vertex_index(v)];
  }
  return distributed;
}

template <int dim>
const std::vector<bool> *added_vertices(const Mesh<dim> &mesh)
{
  const auto *simplices = dynamic_cast<const WithSimplices<dim> *>(&mesh);
  return simplices != nullptr && simplices->was_divided ? &simplices->is_added : nullptr;
}

template <int dim>
bool has_curved_simplices(const Mesh<dim> &mesh)
{
  const auto *simplices = dynamic_cast<const WithSimplices<dim> *>(&mesh);
  return simplices != nullptr && simplices->is_curved;
}

template <int dim>
std::unique_ptr<dealii::Mapping<dim>> mapping_of_simplices(const Mesh<dim> &mesh, const unsigned int degree)
{
  if (degree > 1)
    return std::make_unique<QuadraticMapping<dim>>(dynamic_cast<const WithSimplices<dim> &>(mesh));
  return std::make_unique<dealii::MappingFE<dim>>(dealii::FE_SimplexP<dim>(1));
}

template std::vector<bool> make_simplices<2>(unsigned int, dealii::Triangulation<2> &, FurtherNodes<2> &);
template std::vector<bool> make_simplices<3>(unsigned int, dealii::Triangulation<3> &, FurtherNodes<3> &);
template std::unique_ptr<Mesh<2>> distribute<2>(dealii::Triangulation<2> &, const FurtherNodes<2> &,
                                                const std::vector<bool> &, const std::string &,
                                                const MPI_Comm &);
template std::unique_ptr<Mesh<3>> distribute<3>(dealii::Triangulation<3> &, const FurtherNodes<3> &,
                                                const std::vector<bool> &, const std::string &,
                                                const MPI_Comm &);
template const std::vector<bool> *added_vertices<2>(const Mesh<2> &);
template const std::vector<bool> *added_vertices<3>(const Mesh<3> &);
template std::unique_ptr<dealii::Mapping<2>> mapping_of_simplices<2>(const Mesh<2> &, unsigned int);
template std::unique_ptr<dealii::Mapping<3>> mapping_of_simplices<3>(const Mesh<3> &, unsigned int);
template bool has_curved_simplices<2>(const Mesh<2> &);
template bool has_curved_simplices<3>(const Mesh<3> &);

} // namespace dovetail
