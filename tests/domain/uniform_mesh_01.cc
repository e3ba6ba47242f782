// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Meshes that are refined all at once have the cells of p4est, with the same CellIds at the same places. Each
// cell has one owner, all cells at the vertices of own cells are known with their owners, and the shares
// differ by no more than the parts of one cell, also where ranks have no cells.
//
// ranks: 1, 2, 3, 7

#include "../system/scene_model.h"

#include <dovetail/domain/mesh.h>

#include <deal.II/distributed/tria.h>
#include <deal.II/grid/cell_id.h>

using namespace test;

/// Owners and centres by the name of the cell.
template <int dim>
std::map<std::string, std::pair<unsigned int, dealii::Point<dim>>> all_cells(const Mesh<dim> &mesh)
{
  std::map<std::string, std::pair<unsigned int, dealii::Point<dim>>> own, all;
  for (const auto &cell : mesh.active_cell_iterators())
    if (cell->is_locally_owned())
      own[cell->id().to_string()] = {cell->subdomain_id(), cell->center()};
  for (const auto &of_rank : dealii::Utilities::MPI::all_gather(MPI_COMM_WORLD, own))
    all.insert(of_rank.begin(), of_rank.end());
  return all;
}

template <int dim>
unsigned int n_wrong_neighbours(const Mesh<dim> &mesh)
{
  const auto cells = all_cells(mesh);
  std::vector<bool> is_own(mesh.n_vertices(), false);
  for (const auto &cell : mesh.active_cell_iterators())
    if (cell->is_locally_owned())
      for (const unsigned int v : cell->vertex_indices())
        is_own[cell->vertex_index(v)] = true;
  unsigned int n_wrong = 0;
  for (const auto &cell : mesh.active_cell_iterators()) {
    bool is_near = false;
    for (const unsigned int v : cell->vertex_indices())
      is_near = is_near || is_own[cell->vertex_index(v)];
    const auto found = cells.find(cell->id().to_string());
    const bool is_right =
        is_near ? found != cells.end() && found->second.first == cell->subdomain_id() : cell->is_artificial();
    n_wrong += is_right ? 0 : 1;
  }
  return dealii::Utilities::MPI::sum(n_wrong, MPI_COMM_WORLD);
}

template <int dim>
void check(const std::string &generator, const std::string &arguments, const unsigned int n_refinements)
{
  const std::string entries = set("Dimension", std::to_string(dim)) + set("Generator", generator) +
                              set("Arguments", arguments) + set("Refinements", std::to_string(n_refinements));
  const auto make = [](const std::string &prm) {
    return make_mesh<dim>(SceneText::root(SceneText::from_prm(prm)), MPI_COMM_WORLD);
  };
  const auto mesh = make(entries), by_p4est = make(entries + set("Adaptive cycles", "1"));
  const bool has_p4est =
      dynamic_cast<const dealii::parallel::distributed::Triangulation<dim> *>(by_p4est.get()) != nullptr &&
      dynamic_cast<const dealii::parallel::distributed::Triangulation<dim> *>(mesh.get()) == nullptr;
  const auto cells = all_cells(*mesh), expected = all_cells(*by_p4est);
  double distance = has_p4est && cells.size() == expected.size() ? 0 : 1;
  for (const auto &[name, cell] : expected)
    distance = std::max(distance, cells.count(name) == 0 ? 1. : cells.at(name).second.distance(cell.second));
  const double n_parts = n_refinements > 0 ? 1 << dim : 1,
               n_least =
                   dealii::Utilities::MPI::min(1. * mesh->n_locally_owned_active_cells(), MPI_COMM_WORLD),
               n_most =
                   dealii::Utilities::MPI::max(1. * mesh->n_locally_owned_active_cells(), MPI_COMM_WORLD);
  print(generator + ", cells", {1. * mesh->n_global_active_cells(), 1. * mesh->n_global_levels()});
  report("places of those of p4est", distance, 1e-14);
  report("wrong neighbours", n_wrong_neighbours(*mesh), 0.5);
  report("difference of shares, in cells before the last refinement", (n_most - n_least) / n_parts, 1.5);
  report("hanging nodes", mesh->has_hanging_nodes() ? 1 : 0, 0.5);
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check<2>("subdivided_hyper_rectangle", "1, 1 : 0, 0 : 1, 1 : true", 0);
  check<2>("subdivided_hyper_rectangle", "1, 1 : 0, 0 : 1, 1 : true", 4);
  check<2>("hyper_shell", "0, 0 : 0.5 : 1 : 5 : true", 2);
  check<3>("subdivided_hyper_rectangle", "3, 2, 1 : 0, 0, 0 : 3, 1, 2 : true", 1);
  check<3>("hyper_shell", "0, 0, 0 : 0.5 : 1 : 6 : true", 2);
}
