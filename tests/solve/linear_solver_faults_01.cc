// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What one rank alone meets. Two tied cubes that conduct heat, once with Nitsche's method (CG with
// multigrid), once with standard multipliers that are condensed (CG with multigrid, too), and once with those
// that stay (GMRES with multigrid and a Schur complement). At each place where memory is taken or a library
// is entered, one rank in turn is told that there is no memory. All ranks must go the same way: to MUMPS if
// the iteration fails, which gives the solution of an undisturbed run (relative difference at most 1e-8);
// nowhere if MUMPS fails. A rank that went another way would wait for the others, and the test would not end.
//
// ranks: 2 3

#include "assembled_scene.h"
#include "tied_cubes.h"

#include <algorithm>
#include <new>

using namespace test;

namespace {

/// One group of all blocks, as a simulation makes it.
/// What came out, the same on all ranks: "solved" by what, "not solved", or where the ranks differ.
std::string outcome(const std::optional<unsigned int> &n_iterations, const LinearSolver &solver,
                    const double error)
{
  const std::string own = n_iterations ? (error <= 1e-8 ? "solved" : "wrong") : "not solved";
  const std::string text = own + ", " + solver.description()[0];
  for (const std::string &of_rank : dealii::Utilities::MPI::all_gather(MPI_COMM_WORLD, text))
    if (of_rank != text)
      return "the ranks differ";
  return text;
}

void check(const std::string &name, const std::string &tie, const bool may_condense = true)
{
  const AssembledScene<3> assembled(tied_cubes(tie));
  std::vector<SolveGroup> groups = assembled.groups();
  for (SolveGroup &group : groups)
    if (!may_condense)
      group.follower = {};

  const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD),
                     n_ranks = dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD);
  Vector reference;
  const auto solve = [&](const std::string &type, const std::vector<std::string> &places,
                         const unsigned int faulty_rank) {
    LinearSolver solver(
        SceneText::root(SceneText::from_prm(set("Type", type) + set("Relative tolerance", "1e-12"))), groups);
    solver.set_fault([&](const std::string &place) {
      if (rank == faulty_rank && std::find(places.begin(), places.end(), place) != places.end())
        throw std::bad_alloc();
    });
    Vector solution;
    const auto n_iterations = assembled.solve(solver, solution);
    if (places.empty())
      reference = solution;
    Vector difference = solution;
    difference -= reference;
    return outcome(n_iterations, solver, difference.l2_norm() / reference.l2_norm());
  };
  const auto tell = [&](const std::string &type, const std::vector<std::string> &places) {
    std::vector<std::string> of_ranks;
    for (unsigned int faulty = 0; faulty < n_ranks; ++faulty)
      of_ranks.push_back(solve(type, places, faulty));
    const bool is_same =
        std::all_of(of_ranks.begin(), of_ranks.end(), [&](const auto &text) { return text == of_ranks[0]; });
    if (!is_rank_0())
      return;
    std::cout << "  " << type << ',';
    for (const std::string &place : places)
      std::cout << ' ' << place;
    std::cout << ": " << (is_same ? of_ranks[0] : "it depends on the rank") << std::endl;
  };

  if (is_rank_0())
    std::cout << name << std::endl;
  tell("multigrid", {});
  for (const std::string place : {"operator", "modes", "multigrid", "iteration"})
    tell("multigrid", {place});
  for (const std::string place : {"factorisation", "analysis", "factors", "solution"}) {
    tell("multigrid", {"iteration", place});
    tell("direct", {place});
  }
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check("Nitsche", set("Type", "Nitsche"));
  const std::string standard = set("Type", "mortar") + set("Multiplier space", "standard");
  check("standard multipliers", standard);
  check("standard multipliers that stay", standard, false);
}
