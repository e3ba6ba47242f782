// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A unit test to copy: the surface of the unit square, added up over the ranks, is 4.
//
// ranks: 1 2 3

#include <deal.II/grid/grid_generator.h>

#include <iostream>

int main(int argc, char **argv)
{
  using namespace dealii;
  Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);

  parallel::distributed::Triangulation<2> square(MPI_COMM_WORLD);
  GridGenerator::hyper_cube(square);
  square.refine_global(3);

  double surface = 0;
  for (const auto &cell : square.active_cell_iterators())
    if (cell->is_locally_owned())
      for (const auto &face : cell->face_iterators())
        if (face->at_boundary())
          surface += face->measure();
  surface = Utilities::MPI::sum(surface, MPI_COMM_WORLD);

  if (Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
    std::cout << "surface " << surface << std::endl;
}
