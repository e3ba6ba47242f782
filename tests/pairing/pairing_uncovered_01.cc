// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// `Uncovered` = error, warn, allow: what is noted or thrown, and by how many ranks, if both sides stick out;
// that a side that is merely larger is nothing to speak of; and that sides which do not meet are always an
// error.
//
// ranks: 1, 2, 3

#include "../system/scene_model.h"

#include <sstream>

using namespace test;

void check(const std::string &name, const std::string &right, const std::string &entries)
{
  const std::string prm =
      set("Materials", "steel") + set("Domains", "left, right") + set("Interfaces", "seam") +
      subsection("Material steel", subsection("Heat", set("Type", "Fourier") + set("Conductivity", "1"))) +
      subsection("Domain left", set("Material", "steel") + set("Boundary conditions", "cold") +
                                    subsection("Boundary condition cold",
                                               set("Type", "value") + set("Field", "temperature") +
                                                   set("Boundary ids", "0") + set("Expression", "0")) +
                                    box("2, 4 : 0, 0 : 1, 1")) +
      subsection("Domain right", set("Material", "steel") + box(right)) +
      subsection("Interface seam", set("Type", "Nitsche") + set("Source", "left : 1") +
                                       set("Destination", "right : 0") + entries);

  std::string thrown = "nothing", notes;
  try {
    SceneModel<2> scene_model(prm);
    for (const Note &note : scene_model.model.interfaces[0]->notes())
      notes += note.text();
  } catch (const UserError &error) {
    thrown = error.what();
  }
  const unsigned int n_ranks = dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD),
                     n_throw = dealii::Utilities::MPI::sum(thrown == "nothing" ? 0 : 1, MPI_COMM_WORLD),
                     n_note = dealii::Utilities::MPI::sum(notes.empty() ? 0 : 1, MPI_COMM_WORLD);
  if (!is_rank_0())
    return;
  const auto ranks = [&](const unsigned int n) { return n == n_ranks ? "all" : n == 0 ? "none" : "some"; };
  std::cout << name << "\n  noted by " << ranks(n_note) << ": " << notes << "\n  thrown by " << ranks(n_throw)
            << ": " << thrown << std::endl;
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string shifted = "2, 4 : 1, 0.5 : 2, 1.5";
  check("default", shifted, "");
  check("error", shifted, set("Uncovered", "error"));
  check("warn", shifted, set("Uncovered", "warn"));
  check("allow", shifted, set("Uncovered", "allow"));
  check("the destination is larger", "2, 8 : 1, -0.5 : 2, 1.5", "");
  check("the source is larger", "2, 2 : 1, 0.25 : 2, 0.75", "");
  check("too far away", "2, 4 : 1.1, 0 : 2, 1", set("Uncovered", "allow"));
  check("and found with a larger radius", "2, 4 : 1.1, 0 : 2, 1", set("Search radius", "0.5"));
}
