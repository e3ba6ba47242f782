// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What Newton's method asks for, answered by the system of all domains and interfaces.

#pragma once

#include <dovetail/output/log.h>
#include <dovetail/run/phases.h>
#include <dovetail/solve/convergence.h>
#include <dovetail/solve/linear_solver.h>
#include <dovetail/solve/newton.h>
#include <dovetail/system/block_system.h>

#include <array>
#include <functional>
#include <string>
#include <vector>

namespace dovetail {

/// Solves the steps of one system; made anew with it.
template <int dim>
class NewtonStep
{
public:
  NewtonStep(const Model<dim> &model, BlockSystem<dim> &system, const Newton &newton, LinearSolver &solver,
             Phases &phases, Log &log);

  /// Whether solids may jump past limit points; not as long as a smaller step may find a solution nearby.
  void allow_jumps(const bool are_allowed) { may_jump = are_allowed; }
  /// Before the first solve() of a step to time @p t, from @p x.
  void begin(double t, const Vector &x);
  /// Newton's method from @p x, which becomes the last state that was accepted. @p check_tangent is called
  /// with each new tangent of a linear scene.
  NewtonResult solve(Vector &x, const std::function<void()> &check_tangent);

  /// Let the scalar fields of @p x follow the prescribed values of the step through the tangent at x, as if
  /// nothing else acted on them: what a constant conductivity without sources would do. Nothing if that
  /// fails.
  void spread_prescribed_values(Vector &x);

  /// Norms at the beginning of the step: of the residual, of what is prescribed.
  const std::array<double, 2> &loads() const { return loads_at_start; }
  /// Those of a step that begins at @p x, if it were solved.
  const std::array<double, 2> &loads_at(const Vector &x);
  /// The size of the residual at @p x, relative as Newton's method sees it, and the residual itself.
  double residual_at(const Vector &x);
  const Convergence &convergence() const { return criterion; }
  const std::vector<std::string> &notes() const { return all_notes; }
  /// After a failure: what the last iteration left, as the beginning of "… of the temperature of left".
  std::string what_failed() const;
  /// Likewise: what may help.
  std::string suggestion() const;

private:
  double assemble(bool with_tangent);
  std::optional<unsigned int> solve_for_update(const std::function<void()> &check_tangent);
  std::optional<NewtonProblem::Correction> correct(double damping);
  double refine_linear_solution();
  void find_moving_loads();
  void learn_scales();
  double norm(const Vector &of_update) const;
  bool is_update_small() const;
  bool adapt_ties();
  bool has_large_strain() const;
  bool stabilise(double share);
  bool is_scalar(unsigned int block) const;

  const Model<dim> &model;
  BlockSystem<dim> &system;
  const Newton &newton;
  LinearSolver &linear_solver;
  Phases &phases;
  Log &log;
  Convergence criterion;
  Vector solution, trial, update, correction, update_loads, moving_loads;
  double t = 0;
  BlockMatrix tangent_at_rest; ///< without displacements; empty until a step needs it
  bool may_jump = false;       ///< past limit points
  Vector start;                ///< of the step
  bool has_converged = false;  ///< some step; the first starts from a guess
  bool may_adapt = true;       ///< the ties, once in a step that does
  bool is_spread = false;      ///< the next solve() starts so
  std::vector<double> smallest_at_start, largest_at_start; ///< values, by block
  std::vector<double> scales;                              ///< of the updates, by block
  std::array<double, 2> loads_at_start{};
  bool is_first_assembly = true; ///< of a step
  bool has_new_tangent = false;  ///< that the linear solver has not seen
  bool update_moves = false, has_moving_loads = false;
  double linear_residual = 0, last_residual = 0;
  bool needs_iterations = false, found_no_damping = false; ///< that the scene does not allow
  std::vector<std::string> all_notes;
};

} // namespace dovetail
