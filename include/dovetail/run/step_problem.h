// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The equations of one step, as Newton's method asks for them.

#pragma once

#include <dovetail/material/content_update.h>
#include <dovetail/output/log.h>
#include <dovetail/output/phases.h>
#include <dovetail/run/update_sizes.h>
#include <dovetail/solve/convergence.h>
#include <dovetail/solve/linear_solver.h>
#include <dovetail/solve/newton.h>
#include <dovetail/system/block_system.h>

#include <array>
#include <string>
#include <vector>

namespace dovetail {

/// The system of all domains and interfaces at the time of a step, measured by Convergence and solved by
/// LinearSolver. Made anew with the system.
template <int dim>
class StepProblem : public NonlinearProblem
{
public:
  StepProblem(const Model<dim> &model, BlockSystem<dim> &system, const Newton &newton, LinearSolver &solver,
              Phases &phases, Log &log);

  /// From @p x to time @p t. @pre The system has begun the step.
  void begin_step(double t, const Vector &x);
  /// From now on steps do not start from a guess.
  void set_converged() { starts_from_guess = false; }
  /// Whether solids may jump past limit points; not as long as a smaller step may find a solution nearby.
  void allow_jumps(const bool are_allowed) { may_jump = are_allowed; }

  /// Add to the scalar fields of @p x how the tangent at x answers to the prescribed values of the step, as
  /// if nothing else acted on them: what a constant conductivity without sources would do.
  /// @return false if x stays as it is because that cannot be found.
  bool spread_prescribed_values(Vector &x);

  /// Of a linear scene: about what the next solve(x, dx) will find. Taken if it leaves a smaller residual.
  void set_guess(const Vector &dx) { guess = dx; }
  unsigned int n_guesses_taken() const { return n_guesses; }

  /// As residual_and_tangent(x), where Newton's method will begin: it does not assemble there again.
  double start_at(const Vector &x);

  /// The tangent of the last assembly becomes the linear solver's matrix, but for the rows of pressures that
  /// no equation sees.
  void give_matrix();
  /// Where the linear solver lacks an operator: with entries in place of products, or the other way round.
  void make_other_matrix();

  double time() const { return t; }
  bool is_vector(const unsigned int b) const { return !is_scalar(b) && !is_of_multipliers(b); } ///< a block
  /// Norms at the first state of the step: of the residual, of what is prescribed.
  const std::array<double, 2> &loads() const { return loads_at_start; }
  const Convergence &convergence() const { return criterion; }
  double last_residual() const { return residual_of_last; } ///< of the last assembly, NaN if not defined
  const NoteList &notes() const { return all_notes; }
  /// Whether the last tangent of displacements in this step has a negative eigenvalue, as far as the solver
  /// knows. Not if the step needed no update.
  bool is_unstable() const;

  bool is_linear() const override { return model.is_linear(); }
  void first_stage() override { enter_stage(0); }
  bool next_stage(const Vector &x) override;
  bool has_linear_stage() const override { return stages[present_stage].is_linear; }
  bool is_remembered() const override { return system.has_rates(); }
  bool has_hidden_load() const override;
  double residual(const Vector &x) override;
  double residual_and_tangent(const Vector &x) override;
  std::optional<unsigned int> solve(const Vector &x, Vector &dx) override;
  double linear_residual() const override { return residual_of_solver; }
  bool moves_constraints() const override;
  bool correct(const Vector &x, const Vector &trial, double damping, Vector &correction) override;
  void move(const Vector &x, double damping, const Vector &dx, Vector &trial) override;
  bool may_overshoot() const override;
  double sensible_share(const Vector &dx) override;
  double norm(const Vector &dx) const override;
  bool is_small(const Vector &dx, const Vector &x) const override;
  void accept_state() override { system.accept_state(); }
  bool adapt(const Vector &x) override;
  bool may_cross_limit_points() const override
  {
    return may_jump && model.has_large_strain() &&
           model.order_in_time() < 2; // with inertia a small step has a solution
  }
  bool stabilise(const Vector &x, double share) override;
  void iteration_ends(unsigned int number, double residual, unsigned int linear_iterations,
                      double damping) override;

private:
  /// Groups of fields that follow each other, and iterate together; they may depend on those before.
  struct Stage
  {
    unsigned int first_group, end_group;
    std::vector<bool> has_block;
    bool is_linear;
  };

  std::vector<Stage> make_stages() const;
  void enter_stage(unsigned int number);
  void enter_all_stages();
  void keep_stage(Vector &dx) const;
  LinearSolver::Demand demand() const;
  LinearSolver::Demand demand_of_update();
  LinearSolver::Demand rough_demand(double share) const;
  double forcing() const;
  std::optional<unsigned int> solve_from_guess(const Vector &x, Vector &dx);
  std::optional<unsigned int> solve_with_any_matrix(const Vector &x, Vector &dx, const Vector &b,
                                                    const LinearSolver::Demand &needed);
  double measure(bool is_defined);
  double share_of_update(const Vector &x) const;
  bool has_residual_above(double size) const;
  void forget_updates();
  std::vector<bool> blocks_of_residual(bool with_tangent) const;
  double linear_residual(const Vector &dx, Vector &rest) const;
  double excess(const Vector &dx, const std::vector<unsigned int> &blocks) const;
  bool is_left_to_laws() const;
  double residual_without_constrained(const Vector &dx) const;
  void copy_unconstrained(const Vector &from, Vector &to) const;
  double refine_linear_solution(const Vector &x, Vector &dx, unsigned int most_passes);
  unsigned int refine_by_laws(const Vector &x, Vector &dx, bool of_all, std::optional<double> &inexact);
  bool is_rounded(const Vector &x, const Vector &dx);
  void explain_linear_residual();
  void explain_share(double share);
  Vector find_moving_loads(const Vector &x);
  void learn_scales(const Vector &x, const Vector &dx);
  void check_is_held() const;
  void centre_pressures(const Vector &x, Vector &dx) const;
  bool are_volumes_kept() const;
  void make_other_tangent(const Vector &x);
  void give_tangent(); ///< to the linear solver, if it is new
  bool is_scalar(unsigned int block) const;
  bool is_of_multipliers(const unsigned int b) const
  {
    return model.numbering->blocks()[b].is_of_multipliers;
  }

  const Model<dim> &model;
  BlockSystem<dim> &system;
  LinearSolver &linear_solver;
  Phases &phases;
  Log &log;
  Convergence criterion;
  std::vector<Stage> stages;
  const UpdateSizes sizes;
  const bool may_predict_stress; ///< some law
  bool predicts_stress = false;  ///< since a first update has raised the residual
  std::vector<std::unique_ptr<const ContentUpdate<dim>>> content_updates; ///< by block; nullptr: not needed

  // of a solve
  std::vector<bool> has_block; ///< the present stage, or all of them
  unsigned int present_stage = 0;

  // of a step
  double t = 0;
  Vector start;
  std::vector<double> smallest_at_start, largest_at_start; ///< values, by block
  std::vector<double> scales;                              ///< of the updates, by block
  std::array<double, 2> loads_at_start{};
  std::vector<double> last_residuals;        ///< by block, of the last assembly
  std::vector<double> residuals_of_solution; ///< likewise where the last step ended that needed an update
  bool has_solved = false;                   ///< in this step
  unsigned int n_updates = 0;                ///< that were solved for, since a stage began
  double size_of_update = 0;                 ///< of the last one
  Vector linearised_at;  ///< where its tangent was; empty if no tangent predicts from there
  Vector came_from;      ///< from where that tangent predicted; empty: it did not
  Vector predicted_from; ///< likewise the last tangent that was assembled
  bool is_first_assembly = true;
  bool may_adapt_penalties = true; ///< once, in a step from a guess
  bool may_jump = false;           ///< past limit points
  bool starts_from_guess = true;   ///< before the first step has converged
  BlockMatrix tangent_at_rest;     ///< without displacements; empty until a step needs it

  // of the last assembly and of the last update
  double residual_of_last = 0, residual_of_solver = 0;
  bool has_solver_failed = false; ///< for what was left of a linear scene
  bool leaves_rounding = false;   ///< likewise: nothing is left but that
  bool has_new_tangent = false;   ///< that the linear solver has not seen
  bool update_moves = false;      ///< prescribed values
  Vector update_loads;
  std::optional<Vector> moving_loads;
  std::optional<Vector> guess; ///< of the next update
  unsigned int n_guesses = 0;
  double told_share = 0;                         ///< the largest one, by explain_share()
  double residual_of_update = 0;                 ///< where the last update of this stage began; 0: none yet
  bool is_stabilised = false;                    ///< the tangent
  bool has_all_residuals = true;                 ///< those of other stages, too
  bool is_at_start = false;                      ///< the last assembly, with the tangent, was start_at()
  std::vector<FreePressure<dim>> free_pressures; ///< by the tangent that the linear solver has
  BlockMatrix tangent_of_held;                   ///< which it has if there are any
  std::optional<double> rounding_of_tangent;     ///< once it is asked for
  NoteList all_notes;
};

} // namespace dovetail
