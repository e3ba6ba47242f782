// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// One thermo-elastic scene of two tied bodies, several ways to the same solution (relative difference at most
// 1e-8): everything at once by MUMPS, or first the temperature and then the displacement, each by MUMPS, CG
// (symmetric) or GMRES (theta = 0) with multigrid.
//
// ranks: 1, 2, 3

#include "assembled_scene.h"

using namespace test;

std::string scene(const std::string &theta, const std::string &cells)
{
  const auto law = [](const std::string &stiffness) {
    return subsection("Solid", set("Type", "linear elastic") + set("Young modulus", stiffness) +
                                   set("Poisson ratio", "0.3") + set("Expansion coefficient", "0.01")) +
           subsection("Heat", set("Type", "Fourier") + set("Conductivity", stiffness));
  };
  return set("Materials", "soft, stiff") + set("Domains", "left, right") + set("Interfaces", "seam") +
         subsection("Material soft", law("1")) + subsection("Material stiff", law("100")) +
         subsection("Domain left",
                    set("Material", "soft") + set("Boundary conditions", "clamp, cold") +
                        subsection("Boundary condition clamp",
                                   set("Type", "value") + set("Field", "displacement") +
                                       set("Boundary ids", "0") + set("Expression", "0.01; 0; 0")) +
                        subsection("Boundary condition cold",
                                   set("Type", "value") + set("Field", "temperature") +
                                       set("Boundary ids", "0") + set("Expression", "1")) +
                        box("4, 4, 5 : 0, 0, 0 : 1, 1, 1")) +
         subsection("Domain right",
                    set("Material", "stiff") + set("Boundary conditions", "heat, pull") +
                        subsection("Boundary condition heat",
                                   set("Type", "flux") + set("Field", "temperature") +
                                       set("Boundary ids", "1") + set("Expression", "10")) +
                        subsection("Boundary condition pull",
                                   set("Type", "flux") + set("Field", "displacement") +
                                       set("Boundary ids", "3") + set("Expression", "0; 0.1; 0.1")) +
                        box(cells + " : 1, 0, 0 : 2, 1, 1")) +
         subsection("Interface seam", set("Type", "Nitsche") + set("Source", "left : 1") +
                                          set("Destination", "right : 0") + set("Theta", theta));
}

void check(const std::string &theta)
{
  const AssembledScene<3> assembled(scene(theta, "3, 5, 4"));
  const BlockSystem<3> &system = assembled.system;
  const auto groups = assembled.groups();
  SolveGroup everything;
  everything.name = "everything";
  everything.is_symmetric = false;
  for (const SolveGroup &group : groups)
    everything.blocks.insert(everything.blocks.end(), group.blocks.begin(), group.blocks.end());

  const auto solve = [&](const std::vector<SolveGroup> &of_groups, const std::string &settings,
                         Vector &solution) {
    LinearSolver solver(SceneText::root(SceneText::from_prm(settings)), of_groups);
    const auto n_iterations = assembled.solve(solver, solution);
    report("solved", n_iterations && *n_iterations > 0);
    if (is_rank_0())
      for (const std::string &line : solver.description())
        std::cout << "  " << line << std::endl;
    return n_iterations.value_or(0);
  };

  Vector reference;
  solve({everything}, set("Type", "direct"), reference);
  Vector residual = system.owned_vector();
  system.tangent().vmult(residual, reference);
  residual -= system.negative_residual();
  report("residual", residual.l2_norm() / system.negative_residual().l2_norm(), 1e-11);
  print("norms", {reference.block(0).l2_norm(), reference.block(1).l2_norm()});

  const auto compare = [&](const std::string &name, const Vector &solution) {
    for (unsigned int b = 0; b < reference.n_blocks(); ++b) {
      dealii::TrilinosWrappers::MPI::Vector difference(solution.block(b));
      difference -= reference.block(b);
      report(name + ", block " + std::to_string(b), difference.l2_norm() / reference.block(b).l2_norm(),
             1e-8);
    }
  };
  Vector solution;
  solve(groups, set("Type", "direct"), solution);
  compare("direct, group by group", solution);
  const unsigned int n_iterations =
      solve(groups, set("Type", "multigrid") + set("Relative tolerance", "1e-12"), solution);
  compare("multigrid", solution);
  report("at most 60 iterations for each group", n_iterations <= 60 * groups.size());
  solve(groups, set("Type", "automatic"), solution);
  compare("automatic", solution);
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check("1");
  check("0");
}
