// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Multigrid on two tied elastic bodies of tetrahedra of degree two (16 092 unknowns) that are ten times as
// long in y and z as in x: the solution of MUMPS (difference relative to it at most 1e-7) within 35
// iterations (19 on one rank). With smoothers that are made of the diagonal alone, CG takes 60.
//
// ranks: 1, 3

#include "slender_bodies.h"

using namespace test;

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string degree = set("Degree", "2"), simplices = set("Cells", "simplices");
  check_multigrid<3>("1 : 10 : 10, tetrahedra",
                     slender_bodies({"2, 4, 4", "0, 0, 0", "0.05, 1, 1", degree, simplices},
                                    {"3, 6, 6", "0.05, 0, 0", "0.1, 1, 1", degree, simplices}),
                     35);
}
