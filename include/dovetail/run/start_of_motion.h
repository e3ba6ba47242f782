// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rates with which a motion begins, or a new start of its scheme: the mass alone decides what ties, pressures
// and prescribed values do to them.

#pragma once

#include <dovetail/run/step_problem.h>

#include <optional>
#include <vector>

namespace dovetail {

/// A second rate by so much of the value: rounding leaves nothing of other terms, in any system of units.
constexpr double mass_alone = 1e40;

/// Of the step that ends at a given time. @pre The system has begun that step; it is at the time of its end
/// afterwards again, with rates that have to be set.
template <int dim>
class StartOfMotion
{
public:
  StartOfMotion(const Model<dim> &model, BlockSystem<dim> &system, StepProblem<dim> &equations,
                LinearSolver &solver, Phases &phases, double end);

  /// The second rates at a state @p x that moves with @p rate for which the equations of time @p now hold;
  /// those of constrained unknowns are given. Later in the step, of the size @p h, its equations are
  /// assembled anew. @p forces: what pressures and multipliers are then, in its blocks of them
  /// @return nothing if a law is not defined at x.
  std::optional<Vector> second_rates(double now, const Vector &x, const Vector &rate,
                                     const Vector &of_constrained, double h, Vector &forces);
  /// Change the @p rate at @p x, by as little as the mass allows, such that incompressible bodies at large
  /// strain keep their volume from the time @p now on.
  void keep_volume(double now, const Vector &x, Vector &rate);
  /// Before the first step: change what moves in the state @p x and its @p rate, by as little as the mass
  /// allows, such that it follows by constraints of ties and cells, and that multipliers of interfaces and
  /// pressures of incompressible bodies find their equations solved. Momentum is kept.
  void satisfy_ties(Vector &x, Vector &rate);

  /// Whether incompressible bodies at large strain are there, perhaps.
  bool may_limit_volume() const { return has_pressures() && model.has_large_strain(); }
  const NoteList &notes() const { return all_notes; } ///< of satisfy_ties()

private:
  using Rows = std::vector<std::vector<unsigned int>>; ///< owned ones, by block

  bool is_of_pressure(const unsigned int b) const { return model.numbering->blocks()[b].is_of_pressure(); }
  bool is_of_multipliers(const unsigned int b) const
  {
    return model.numbering->blocks()[b].is_of_multipliers;
  }
  bool has_inertia(unsigned int block) const;
  bool has_pressures() const;
  Rows incompressible_rows() const;
  bool is_any(const Rows &rows) const;
  bool assemble_mass(const Vector &x);
  Vector solve_mass(const Vector &x, const Vector &right_hand_side);
  void set_rates_alone(const Vector &x, const Vector &rate, const Vector &second_rate);
  void compare_start(const Vector &x);
  void project_start(Vector &x, Vector &rate);
  void follow_rates(Vector &rate);
  void assemble_mass_of_start(const Vector &x);
  bool assemble_at_rest(const Vector &x);
  Vector limits(const Rows &of_volume, const Vector &residual) const;
  Vector projection(const Vector &x, const Vector &change, const Vector &limited);
  void project_positions(const Rows &of_volume, const Vector &x_change, Vector &x);
  void refuse_positions(const Vector &limited) const;
  void find_pressures(const Rows &of_volume, Vector &x);
  void find_rates_of_volume(double begin, const Vector &x, const Vector &rate, const Rows &rows,
                            Vector &negative_rates);

  const Model<dim> &model;
  BlockSystem<dim> &system;
  StepProblem<dim> &equations;
  LinearSolver &linear_solver;
  Phases &phases;
  const double end;
  NoteList all_notes;
};

} // namespace dovetail
