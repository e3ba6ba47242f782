// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Two plates of degree two that are one cell thick, tied at x = 0.01 by pointwise constraints. The iteration
// is slow with the levels of the functions of degree one, so that their matrix is factorised: at most 30
// iterations. If one rank in turn has no memory for these factors, all ranks go on without them, and MUMPS
// takes over as the iteration is slow. The solution is the same (relative difference at most 1e-7).
//
// ranks: 1 2 3

#include "slender_bodies.h"

#include <iostream>
#include <new>
#include <string>
#include <tuple>

using namespace test;

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string degree = set("Degree", "2");
  const AssembledScene<3> assembled(slender_bodies({"1, 7, 7", "0, 0, 0", "0.01, 1, 1", degree},
                                                   {"1, 10, 10", "0.01, 0, 0", "0.02, 1, 1", degree},
                                                   "pointwise", "2"));
  const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD),
                     n_ranks = dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD);
  Vector reference;
  const auto solve = [&](const std::string &type, const unsigned int faulty_rank) {
    LinearSolver solver(SceneText::root(SceneText::from_prm(set("Type", type))), assembled.groups());
    solver.set_fault([&](const std::string &place) {
      if (rank == faulty_rank && place == "factors of degree one")
        throw std::bad_alloc();
    });
    Vector solution;
    const unsigned int n_iterations = assembled.solve(solver, solution).value_or(0);
    if (type == "direct")
      reference = solution;
    solution.block(1) -= reference.block(1);
    return std::make_tuple(n_iterations, solver.description()[0],
                           solution.block(1).l2_norm() / reference.block(1).l2_norm());
  };
  solve("direct", n_ranks);
  const auto tell = [&](const std::string &name, const unsigned int faulty_rank) {
    const auto [n_iterations, description, difference] = solve("multigrid", faulty_rank);
    if (is_rank_0())
      std::cout << name << ": " << description << std::endl;
    report(name + ", iterations", n_iterations > 0 ? n_iterations : 1000., 30.);
    report(name + ", solution", difference, 1e-7);
  };
  tell("factors", n_ranks);
  tell("no memory on the first rank", 0);
  tell("no memory on the last rank", n_ranks - 1);
}
