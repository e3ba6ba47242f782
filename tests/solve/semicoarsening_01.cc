// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Multigrid on two tied elastic bodies in 3D (4 764 unknowns) whose cells are ten times as long in x as in y
// and z: the solution of MUMPS (difference relative to it at most 1e-7) within 30 iterations. Coarsening in
// all directions takes 35 on one rank, and more on finer meshes. On three ranks up to 50: each factorises its
// part of a cross-section by itself.
//
// ranks: 1, 3

#include "assembled_scene.h"

using namespace test;

namespace {

std::string body(const std::string &mesh, const std::string &more = "")
{
  return set("Material", "one") + set("Degree", "1") +
         subsection("Source", set("displacement", "0; 1e-3; 2e-3")) + box(mesh) + more;
}

std::string scene(const std::string &height)
{
  const std::string clamp =
      set("Boundary conditions", "clamp") +
      subsection("Boundary condition clamp", set("Type", "value") + set("Field", "displacement") +
                                                 set("Boundary ids", "0") + set("Expression", "0; 0; 0"));
  return set("Materials", "one") + set("Domains", "left, right") + set("Interfaces", "seam") +
         subsection("Material one",
                    subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "1") +
                                            set("Poisson ratio", "0.3"))) +
         subsection("Domain left", body("4, 8, 8 : 0, 0, 0 : 5, " + height + ", 1", clamp)) +
         subsection("Domain right", body("6, 12, 12 : 5, 0, 0 : 10, " + height + ", 1")) +
         subsection("Interface seam",
                    set("Type", "Nitsche") + set("Source", "left : 1") + set("Destination", "right : 0"));
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_multigrid<3>("10 : 1 : 1", scene("1"),
                     dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) == 1 ? 30 : 50);
}
