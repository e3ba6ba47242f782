// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Every format of mesh files: cells, vertices, volume and the measures by boundary id. The four files in this
// folder hold the same two cells, 2.5 x 1, with the ids 1 left, 2 right, 3 bottom, 4 top (1, 1, 2.5, 2.5).
// One cell of second order has bars on its left and lower side and on a diagonal, which is no face: both
// sides are in the set 1, the left one in the set 2, too, and has the new id 3. The numbers of the blade
// (Gmsh 4.1) and the disk (Gmsh 2.2) stand in meshes/README.md (here in cm).
//
// ranks: 1, 2, 3

#include "../system/scene_model.h"

#include <dovetail/domain/mesh.h>

#include <deal.II/grid/grid_tools.h>

using namespace test;

template <int dim>
void show(const std::string &file, const std::string &entries = "")
{
  const auto text = SceneText::from_prm(set("Dimension", std::to_string(dim)) + set("File", file) + entries);
  const auto mesh = make_mesh<dim>(SceneText::root(text), MPI_COMM_WORLD);
  print(file + ": cells, volume", {double(mesh->n_global_active_cells()), dealii::GridTools::volume(*mesh)});
  for (const auto &[id, measure] : boundary_measures<dim>(*mesh))
    print("  boundary " + std::to_string(id), {measure});
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const std::string name : {"_abaqus.inp", "_ucd.inp", ".vtk", ".unv"})
    show<2>("tests/domain/two_cells" + name);
  show<2>("tests/domain/two_cells.vtk", set("Refinements", "2") + set("Scale", "2") + set("Shift", "1; 2"));
  show<2>("tests/domain/one_cell_bars.inp");
  show<3>("meshes/blade.msh", set("Scale", "0.1"));
  show<3>("meshes/disk.msh", set("Scale", "0.1"));

  // both, neither, not there, not known: one message each
  for (const std::string &entries :
       {set("File", "tests/domain/two_cells.vtk") + set("Generator", "hyper_cube"), std::string(),
        set("File", "tests/domain/no_such_file.msh"), set("File", "tests/domain/mesh_files_01.cc")})
    try {
      make_mesh<2>(SceneText::root(SceneText::from_prm(set("Dimension", "2") + entries)), MPI_COMM_WORLD);
      report("no error", false);
    } catch (const UserError &error) {
      if (is_rank_0())
        std::cout << error.what() << std::endl;
    }
}
