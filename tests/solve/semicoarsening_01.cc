// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Multigrid on two tied elastic bodies in 3D (4 764 unknowns) whose cells are ten times as long in x as in y
// and z: the solution of MUMPS (difference relative to it at most 1e-7) within 26 iterations. Coarsening in
// all directions takes 35 on one rank, and more on finer meshes.
//
// ranks: 1, 3

#include "slender_bodies.h"

using namespace test;

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_multigrid<3>("10 : 1 : 1", slender_bodies("5", "10"), 26);
}
