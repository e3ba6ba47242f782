// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// For tests of solvers: the linear system of a scene at t = 1, and its groups as a simulation has them.

#pragma once

#include "../system/scene_model.h"

#include <dovetail/solve/linear_solver.h>
#include <dovetail/system/solve_groups.h>

#include <optional>
#include <string>
#include <vector>

namespace test {

template <int dim>
struct AssembledScene
{
  explicit AssembledScene(const std::string &prm) : scene(prm), system(scene.model)
  {
    system.set_up(1.);
    const Vector x = system.owned_vector();
    system.begin_step(1., x);
    system.assemble(x, true);
  }

  std::vector<SolveGroup> groups() const
  {
    return make_solve_groups<dim>(scene.model, [this]() -> const BlockSystem<dim> & { return system; });
  }

  /// With entries or products, as it asks for.
  void give_matrix(LinearSolver &solver)
  {
    system.choose_entries(solver.needs_entries());
    system.make_matrix();
    system.assemble(system.owned_vector(), true);
    solver.set_matrix(system.tangent());
  }

  std::optional<unsigned int> solve(LinearSolver &solver, Vector &solution) const
  {
    solution = system.owned_vector();
    solver.set_matrix(system.tangent());
    return solver.solve(solution, system.negative_residual());
  }

  SceneModel<dim> scene;
  BlockSystem<dim> system;
};

/// That multigrid takes at most so many iterations, and finds what MUMPS finds.
template <int dim>
void check_multigrid(const std::string &name, const std::string &prm, const unsigned int most_iterations,
                     const double tolerance = 1e-7)
{
  const AssembledScene<dim> assembled(prm);
  const auto solve = [&](const std::string &type, Vector &solution) {
    LinearSolver solver(SceneText::root(SceneText::from_prm(set("Type", type))), assembled.groups());
    return assembled.solve(solver, solution).value_or(0);
  };
  Vector reference, solution;
  solve("direct", reference);
  const unsigned int n_iterations = solve("multigrid", solution);
  report(name + ", iterations", n_iterations > 1 ? n_iterations : 1000., most_iterations);
  solution.block(1) -= reference.block(1);
  report(name + ", solution", solution.block(1).l2_norm() / reference.block(1).l2_norm(), tolerance);
}

} // namespace test
