// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Chains of constraints over ranks. In a shuffled order p of the unknowns every fifth is free and the others
// follow the two before them, x_p = 0.5 x_(p-1) + 0.25 x_(p-2) + 0.125 (the first one only the one before),
// so four links, mostly on other ranks, lead to x_p = a x_free + b with (a, b) = (1/2, 1/8), (1/2, 3/16),
// (3/8, 1/4), (5/16, 19/64).
//
// ranks: 1, 2, 3

#include "scene_model.h"

#include <dovetail/system/constraints.h>

using namespace test;

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  SceneModel<2> scene_model(
      set("Materials", "steel") + set("Domains", "left, right") +
      subsection("Material steel", subsection("Heat", set("Type", "Fourier") + set("Conductivity", "2"))) +
      subsection("Domain left", set("Material", "steel") + set("Boundary conditions", "cold") +
                                    subsection("Boundary condition cold",
                                               set("Type", "value") + set("Field", "temperature") +
                                                   set("Boundary ids", "0") + set("Expression", "1")) +
                                    box("6, 6 : 0, 0 : 1, 1")) +
      subsection("Domain right", set("Material", "steel") + set("Boundary conditions", "cold") +
                                     subsection("Boundary condition cold",
                                                set("Type", "value") + set("Field", "temperature") +
                                                    set("Boundary ids", "0") + set("Expression", "1")) +
                                     box("4, 8 : 1, 0 : 2, 1")));
  const Numbering &numbering = *scene_model.model.numbering;
  const unsigned int n = numbering.n_dofs(), step = 37;
  print("unknowns", {double(n)}); // 49 + 45, no common divisor with 37

  std::vector<unsigned int> position(n), at(n);
  for (unsigned int i = 0; i < n; ++i) {
    position[i] = (i * step) % n;
    at[position[i]] = i;
  }
  ConstraintLines lines;
  for (const auto dof : numbering.owned)
    if (const unsigned int p = position[dof]; p % 5 != 0) {
      ConstraintLine &line = lines[dof];
      line.entries.emplace_back(at[p - 1], 0.5);
      if (p % 5 > 1)
        line.entries.emplace_back(at[p - 2], 0.25);
      line.inhomogeneity = 0.125;
    }
  const auto constraints = close_constraints(lines, numbering, numbering.relevant, MPI_COMM_WORLD);

  const double a[] = {1, 1. / 2, 1. / 2, 3. / 8, 5. / 16}, b[] = {0, 1. / 8, 3. / 16, 1. / 4, 19. / 64};
  double error = 0;
  bool is_right = true;
  std::vector<double> by_link(5, 0.);
  for (const auto dof : numbering.relevant) {
    const unsigned int link = position[dof] % 5;
    if (link == 0) {
      is_right = is_right && !constraints.is_constrained(dof);
      continue;
    }
    is_right = is_right && constraints.is_constrained(dof);
    const auto *entries = constraints.get_constraint_entries(dof);
    is_right = is_right && entries != nullptr && entries->size() == 1 &&
               (*entries)[0].first == at[position[dof] - link];
    if (entries != nullptr && entries->size() == 1)
      error = std::max(error, std::abs((*entries)[0].second - a[link]));
    error = std::max(error, std::abs(constraints.get_inhomogeneity(dof) - b[link]));
    if (numbering.owned.is_element(dof))
      by_link[link] += 1;
  }
  dealii::Utilities::MPI::sum(by_link, MPI_COMM_WORLD, by_link);
  report("each follows its free unknown only", is_right);
  report("factors and constants", error, 1e-15);
  print("lines by number of links", by_link);

  // a rank asks for nothing although others do
  const dealii::IndexSet nothing(n);
  const auto of_one =
      close_constraints(lines, numbering, is_rank_0() ? numbering.relevant : nothing, MPI_COMM_WORLD);
  report("one rank asks", of_one.n_constraints() >= lines.size());

  // the first free unknown follows the last of its followers: a circle, B_0 = 5/16 B_0 + 19/64
  if (numbering.owned.is_element(at[0]))
    lines[at[0]].entries.emplace_back(at[4], 1.);
  std::set<dealii::types::global_dof_index> unconstrained;
  const auto solved = close_constraints(lines, numbering, numbering.relevant, MPI_COMM_WORLD, &unconstrained);
  const double x = 19. / 44;
  double error_of_circle = dealii::Utilities::MPI::sum(unconstrained.size(), MPI_COMM_WORLD);
  for (unsigned int link = 0; link < 5; ++link)
    if (numbering.relevant.is_element(at[link]))
      error_of_circle =
          std::max(error_of_circle, std::abs(solved.get_inhomogeneity(at[link]) - (a[link] * x + b[link])));
  report("a circle with a solution", error_of_circle, 1e-14);

  // three unknowns that are equal: the one with the largest index is set free
  ConstraintLines equal;
  for (unsigned int link = 0; link < 3; ++link)
    if (numbering.owned.is_element(at[link])) {
      equal[at[link]].entries.emplace_back(at[(link + 1) % 3], 1.);
      equal[at[link]].tie = 0;
    }
  const auto opened = close_constraints(equal, numbering, numbering.relevant, MPI_COMM_WORLD, &unconstrained);
  const auto largest = *std::max_element(at.begin(), at.begin() + 3);
  bool is_opened = dealii::Utilities::MPI::sum(unconstrained.size(), MPI_COMM_WORLD) == 1 &&
                   (unconstrained.empty() || *unconstrained.begin() == largest);
  for (unsigned int link = 0; link < 3; ++link)
    if (numbering.relevant.is_element(at[link]))
      is_opened = is_opened && opened.is_constrained(at[link]) == (at[link] != largest);
  report("a circle without", is_opened);
}
