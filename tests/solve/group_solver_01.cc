// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Solvers from outside on two tied cubes that conduct heat: one that is an iteration with a preconditioner of
// its own, for every kind of group (difference from MUMPS relative to the solution at most 1e-8); one that
// does not fit and is refused, with its message; some that fail, that fail on one rank, that lie about their
// result or give no number, which must all end with the solution of MUMPS and a note.
//
// ranks: 1, 2, 3

#include "assembled_scene.h"
#include "tied_cubes.h"

#include <dovetail/scene/user_error.h>
#include <dovetail/solve/krylov.h>

#include <limits>
#include <new>

using namespace test;

namespace {

/// z = diag(K)^-1 r
class Jacobi : public GroupSolver
{
public:
  Jacobi(const Section &section, const GroupFacts &facts)
      : facts(facts), damping(section.read<double>("Damping", 1, "Of the preconditioner [-]"))
  {
  }
  std::string description() const override { return describe_iteration(facts, "Jacobi"); }
  void prepare(const GroupOperator &K, const Agreement &) override
  {
    inverse = K.bodies().vector();
    K.bodies().diagonal(inverse);
    inverse.trilinos_vector().Reciprocal(inverse.trilinos_vector());
    inverse *= damping;
  }
  unsigned int solve(const GroupOperator &K, GroupVector &x, const GroupVector &b, const double goal) override
  {
    const auto scale = [this](GroupVector &z, const GroupVector &r) {
      z = r;
      z.scale(inverse);
    };
    return solve_by_iteration(K, facts, scale, x, b, goal);
  }

private:
  const GroupFacts &facts;
  const double damping;
  GroupVector inverse;
};

/// What is wrong with it is chosen by the scene.
class Bad : public GroupSolver
{
public:
  Bad(const Section &section, const GroupFacts &facts)
      : facts(facts), how(section.read<std::string>("How", "", "What is wrong [-]"))
  {
  }
  std::string description() const override { return "nothing"; }
  std::string objection() const override { return facts.is_symmetric ? "" : "its matrix is not symmetric"; }
  void prepare(const GroupOperator &, const Agreement &) override
  {
    if (how == "fails in prepare")
      throw std::runtime_error(how);
  }
  unsigned int solve(const GroupOperator &, GroupVector &x, const GroupVector &b, double) override
  {
    const bool is_last = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) + 1 ==
                         dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD);
    if (how == "fails" || (how == "fails on one rank" && is_last))
      throw std::bad_alloc();
    x = b;
    if (how == "gives no number")
      x.trilinos_vector().PutScalar(std::numeric_limits<double>::quiet_NaN());
    return 7;
  }

private:
  const GroupFacts &facts;
  const std::string how;
};

const bool registered =
    SolverCatalogue::add<Jacobi>("Jacobi", "For this test.") && SolverCatalogue::add<Bad>("bad", "Likewise.");

void check(const std::string &name, const std::string &tie, const std::vector<std::string> &settings)
{
  const AssembledScene<3> assembled(tied_cubes(tie));
  if (is_rank_0())
    std::cout << name << std::endl;

  Vector reference;
  const auto solve = [&](const std::string &entries) {
    LinearSolver solver(SceneText::root(SceneText::from_prm(entries)), assembled.groups());
    Vector solution;
    const auto n_iterations = assembled.solve(solver, solution);
    if (reference.n_blocks() == 0)
      reference = solution;
    Vector difference = solution;
    difference -= reference;
    report(solver.description()[0], n_iterations ? difference.l2_norm() / reference.l2_norm() : 1, 1e-8);
    if (is_rank_0())
      for (const Note &note : solver.notes())
        std::cout << "  " << note.text() << std::endl;
  };
  for (const std::string &entries : settings)
    try {
      solve(entries);
    } catch (const UserError &error) {
      if (is_rank_0())
        std::cout << error.what() << std::endl;
    }
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const auto bad = [](const std::string &how) { return set("Type", "bad") + set("How", how); };
  const std::string direct = set("Type", "direct"), jacobi = set("Type", "Jacobi") + set("Damping", "0.7");
  check("symmetric", set("Type", "Nitsche"),
        {direct, jacobi, bad("fails in prepare"), bad("fails"), bad("fails on one rank"),
         bad("gives no number"), bad("lies")});
  check("not symmetric", set("Type", "Nitsche") + set("Theta", "0"), {direct, jacobi, bad("")});
  check("multipliers", set("Type", "mortar") + set("Multiplier space", "standard"),
        {direct, jacobi, bad("")});
}
