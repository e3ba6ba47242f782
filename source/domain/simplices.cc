// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The division of tetrahedra: J. Bey, Tetrahedral grid refinement, Computing 55 (1995). deal.II's own
// flattens them more and more before version 9.6.

#include <dovetail/domain/simplices.h>

#include <deal.II/base/mpi.h>
#include <deal.II/distributed/fully_distributed_tria.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/grid/grid_tools.h>
#include <deal.II/grid/tria_description.h>
#include <deal.II/lac/sparsity_tools.h>

#include <algorithm>
#include <map>

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
    const auto [middle, is_new] = of_edge.insert({std::minmax(a, b), vertices.size()});
    if (is_new)
      vertices.push_back((vertices[a] + vertices[b]) / 2);
    return middle->second;
  }

  const dealii::Point<dim> &point(const unsigned int vertex) const { return vertices[vertex]; }

private:
  std::vector<dealii::Point<dim>> &vertices;
  std::map<std::pair<unsigned int, unsigned int>, unsigned int> of_edge;
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

/// Divide every triangle into 4, every tetrahedron into 8.
template <int dim>
void divide_simplices(dealii::Triangulation<dim> &mesh)
{
  std::vector<dealii::Point<dim>> vertices = mesh.get_vertices();
  Middles<dim> middle(vertices);
  std::vector<dealii::CellData<dim>> cells;
  dealii::SubCellData faces;
  for (const auto &cell : mesh.active_cell_iterators()) {
    const auto v = [&](const unsigned int i) { return cell->vertex_index(i); };
    if constexpr (dim == 2)
      append(divide_triangle({v(0), v(1), v(2)}, middle), cell->material_id(), cells);
    else
      append(divide_tetrahedron({v(0), v(1), v(2), v(3)}, middle), cell->material_id(), cells);
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
}

template <int dim>
void convert_hypercubes(dealii::Triangulation<dim> &mesh)
{
  dealii::Triangulation<dim> flat, simplices;
  dealii::GridGenerator::flatten_triangulation(mesh, flat);
  for (const auto id : flat.get_manifold_ids())
    if (id != dealii::numbers::flat_manifold_id)
      flat.set_manifold(id, mesh.get_manifold(id));
  dealii::GridGenerator::convert_hypercube_to_simplex_mesh(flat, simplices);
  mesh.clear();
  mesh.copy_triangulation(simplices);
}

} // namespace

template <int dim>
void make_simplices(const unsigned int n_refinements, dealii::Triangulation<dim> &mesh)
{
  if (mesh.all_reference_cells_are_simplex())
    for (unsigned int i = 0; i < n_refinements; ++i)
      divide_simplices(mesh);
  else {
    mesh.refine_global(n_refinements);
    convert_hypercubes(mesh);
  }
  mesh.reset_all_manifolds();
  mesh.set_all_manifold_ids(dealii::numbers::flat_manifold_id);
}

template <int dim>
std::unique_ptr<Mesh<dim>> distribute(dealii::Triangulation<dim> &mesh, const MPI_Comm &communicator)
{
  const unsigned int n_ranks = dealii::Utilities::MPI::n_mpi_processes(communicator);
  if (mesh.n_active_cells() > n_ranks)
    dealii::GridTools::partition_triangulation(n_ranks, mesh, dealii::SparsityTools::Partitioner::metis);
  else // METIS wants more
    for (const auto &cell : mesh.active_cell_iterators())
      cell->set_subdomain_id(cell->active_cell_index());
  auto distributed = std::make_unique<dealii::parallel::fullydistributed::Triangulation<dim>>(communicator);
  distributed->create_triangulation(
      dealii::TriangulationDescription::Utilities::create_description_from_triangulation(mesh, communicator));
  return distributed;
}

template void make_simplices<2>(unsigned int, dealii::Triangulation<2> &);
template void make_simplices<3>(unsigned int, dealii::Triangulation<3> &);
template std::unique_ptr<Mesh<2>> distribute<2>(dealii::Triangulation<2> &, const MPI_Comm &);
template std::unique_ptr<Mesh<3>> distribute<3>(dealii::Triangulation<3> &, const MPI_Comm &);

} // namespace dovetail
