// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Triangles and tetrahedra: cells, volume and the measures by boundary id of generated and of read meshes,
// refined, scaled and shifted. By hand: a box of sides 2.5, 1 (and 2); every refinement multiplies the cells
// by 4 or 8, a quadrilateral has 8 triangles, a hexahedron 24 tetrahedra. The files hold cells of both
// orientations. The shape of a cell, its measure by diameter^dim, stays or becomes one of a few: it must not
// go on falling. The sum of (number of the cell in its CellId) * (x of its centre) tells whether cells are
// numbered alike on all numbers of ranks, of which some have no cell. Vertices on a round boundary lie on it.
//
// ranks: 1, 2, 3, 5, 7

#include "../system/scene_model.h"

#include <dovetail/domain/mesh.h>

using namespace test;

template <int dim>
void show(const std::string &what, const std::string &entries)
{
  const auto text = SceneText::from_prm(set("Dimension", std::to_string(dim)) + entries);
  const auto mesh = make_mesh<dim>(SceneText::root(text), MPI_COMM_WORLD);
  double volume = 0, numbered = 0, worst = 1;
  std::vector<double> measures(8, 0.);
  for (const auto &cell : mesh->active_cell_iterators())
    if (cell->is_locally_owned()) {
      volume += cell->measure();
      worst = std::min(worst, cell->measure() / std::pow(cell->diameter(), dim));
      numbered += (cell->id().get_coarse_cell_id() + 1.) * cell->center()[0];
      for (const auto &face : cell->face_iterators())
        if (face->at_boundary())
          measures.at(face->boundary_id()) += face->measure();
    }
  const double n_cells = mesh->n_global_active_cells();
  dealii::Utilities::MPI::sum(measures, MPI_COMM_WORLD, measures);
  print(what + ": cells, volume, worst shape, numbering",
        {n_cells, dealii::Utilities::MPI::sum(volume, MPI_COMM_WORLD),
         dealii::Utilities::MPI::min(worst, MPI_COMM_WORLD),
         dealii::Utilities::MPI::sum(numbered, MPI_COMM_WORLD) / n_cells / n_cells});
  print("  boundaries", measures);
  report("  simplices, straight, one level",
         has_simplices(*mesh) && is_straight(*mesh) && mesh->n_global_levels() == 1);
}

template <int dim>
void show_round(const std::string &generator, const std::string &arguments, const std::vector<double> &radii)
{
  const auto text = SceneText::from_prm(
      set("Dimension", std::to_string(dim)) + set("Generator", generator) + set("Arguments", arguments) +
      set("Cells", "simplices") + set("Refinements", "1") + set("Scale", "0.01") + set("Shift", "3; 0; 0"));
  const auto mesh = make_mesh<dim>(SceneText::root(text), MPI_COMM_WORLD);
  dealii::Point<dim> centre;
  centre[0] = 3;
  double off = 0;
  for (const auto &cell : mesh->active_cell_iterators())
    if (cell->is_locally_owned())
      for (const auto &face : cell->face_iterators())
        if (face->at_boundary())
          for (const unsigned int v : face->vertex_indices())
            off =
                std::max(off, std::abs(face->vertex(v).distance(centre) / 0.01 - radii[face->boundary_id()]));
  report(generator + " in " + std::to_string(dim) + "D: vertices on the boundary", off, 1e-12);
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const std::string n : {"0", "1", "2"}) {
    show<2>("box in 2D, " + n, set("Generator", "subdivided_hyper_rectangle") +
                                   set("Arguments", "2, 1 : 0, 0 : 2.5, 1 : true") +
                                   set("Cells", "simplices") + set("Refinements", n));
    show<2>("file in 2D, " + n, set("File", "tests/domain/two_triangles.msh") + set("Refinements", n));
  }
  for (const std::string n : {"0", "1"})
    show<3>("box in 3D, " + n, set("Generator", "subdivided_hyper_rectangle") +
                                   set("Arguments", "2, 1, 2 : 0, 0, 0 : 2.5, 1, 2 : true") +
                                   set("Cells", "simplices") + set("Refinements", n));
  for (const std::string n : {"0", "1", "2", "3"})
    show<3>("file in 3D, " + n, set("File", "tests/domain/six_tetrahedra.msh") + set("Refinements", n));
  show<2>("file in 2D, moved", set("File", "tests/domain/two_triangles.msh") + set("Cells", "simplices") +
                                   set("Refinements", "1") + set("Scale", "2") + set("Shift", "1; 2"));
  show<3>("file in 3D, moved", set("File", "tests/domain/six_tetrahedra.msh") + set("Refinements", "1") +
                                   set("Scale", "2") + set("Shift", "1; 2; 3"));
  show<2>("quadrilaterals from a file",
          set("File", "tests/domain/two_cells.unv") + set("Cells", "simplices"));
  show_round<2>("hyper_shell", "0, 0 : 0.5 : 1 : 8 : true", {0.5, 1});
  show_round<2>("hyper_ball_balanced", "0, 0 : 1", {1});
  show_round<3>("hyper_shell", "0, 0, 0 : 0.5 : 1 : 6 : true", {0.5, 1});
}
