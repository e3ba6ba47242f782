// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The same as semicoarsening_01 with cells a hundred times as long in x: within 25 iterations. Aggregates
// that contain nodes of both bodies take 59, because Nitsche's tie is a weak spring there. On three ranks,
// prolongations with the long couplings to nodes of other ranks take 208.
//
// ranks: 1, 3

#include "slender_bodies.h"

using namespace test;

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_multigrid<3>("100 : 1 : 1", slender_bodies("50", "100"), 25, 1e-6);
}
