// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Multigrid where a stiff body with a coarser mesh follows a soft one: elastic hexahedra of degrees 1 and 2,
// dual mortar and pointwise, moduli 1e6 and 1e8 apart, also with hanging nodes on the stiff side, which is
// finer there: the solution of MUMPS (difference relative to it at most 1e-6) within 30 iterations. Without
// the two spaces of SoftLeaders they take 120, 363 and 251.
//
// ranks: 1, 3

#include "assembled_scene.h"

using namespace test;

namespace {

struct Case
{
  std::string name, tie, modulus = "1e6", left_cells = "4, 6, 6", more_of_left = "";
  unsigned int degree = 1;
};

std::string material(const std::string &name, const std::string &modulus)
{
  return subsection("Material " + name,
                    subsection("Solid", set("Type", "linear elastic") + set("Young modulus", modulus) +
                                            set("Poisson ratio", "0.3")));
}

std::string scene(const Case &of)
{
  const std::string common =
      set("Degree", std::to_string(of.degree)) + subsection("Source", set("displacement", "0; 1; 2"));
  const std::string clamp =
      set("Boundary conditions", "clamp") +
      subsection("Boundary condition clamp", set("Type", "value") + set("Field", "displacement") +
                                                 set("Boundary ids", "0") + set("Expression", "0; 0; 0"));
  const std::string cells_of_right = of.degree == 1 ? "5, 10, 10" : "3, 5, 5";
  return set("Materials", "stiff, soft") + set("Domains", "left, right") + set("Interfaces", "seam") +
         material("stiff", of.modulus) + material("soft", "1") +
         subsection("Domain left", set("Material", "stiff") + common + clamp +
                                       box(of.left_cells + " : 0, 0, 0 : 0.5, 1, 1", of.more_of_left)) +
         subsection("Domain right",
                    set("Material", "soft") + common + box(cells_of_right + " : 0.5, 0, 0 : 1, 1, 1")) +
         subsection("Interface seam",
                    set("Type", of.tie) + set("Source", "right : 0") + set("Destination", "left : 1"));
}

void check(const Case &of)
{
  check_multigrid<3>(of.name + ", " + of.tie, scene(of), 30, 1e-6);
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check({"degree 1", "mortar"});
  check({"finer in part", "pointwise", "1e8", "4, 6, 6", set("Refine boxes", "0; 0; 0 : 1; 0.4; 1")});
  check({"degree 2", "mortar", "1e6", "2, 3, 3", "", 2});
}
