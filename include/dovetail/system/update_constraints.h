// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The constraints on the unknowns of a model, and on Newton's update of them.

#pragma once

#include <dovetail/domain/constraint_lines.h>
#include <dovetail/system/model.h>

#include <deal.II/lac/affine_constraints.h>

#include <map>
#include <memory>
#include <set>
#include <vector>

namespace dovetail {

/// Hanging nodes, prescribed values and ties: x_i = sum_j w_j x_j + b_i. Newton's update dx, with which x +
/// dx satisfies them, has dx_i = sum_j w_j dx_j + (b_i + sum_j w_j x_j - x_i).
template <int dim>
class UpdateConstraints
{
public:
  /// @param model by reference; @param moves_nothing: dx_i = sum_j w_j dx_j, as in a transposed system
  UpdateConstraints(Model<dim> &model, const bool moves_nothing) : model(model), moves_nothing(moves_nothing)
  {
  }

  /// For what is active at time @p t. Collective.
  void set_up(double t);
  /// Prescribed values of another time, until the next set_up(). Collective.
  void set_time(double t);

  /// Those of dx, of the unknowns relevant to this rank, resolved.
  const dealii::AffineConstraints<double> &of_update() const { return constraints; }
  /// Of owned unknowns, without those that have been dropped.
  const std::shared_ptr<const ConstraintLines> &lines() const { return lines_of_x; }
  /// Unknowns of the domains, those behind interface points, and those to which constraints refer.
  const dealii::IndexSet &relevant_unknowns() const { return relevant; }
  /// Of this rank: constraints of ties that led back to themselves.
  unsigned int n_dropped() const { return unconstrained.size(); }
  double seconds_of_ties() const { return tie_seconds; } ///< this rank

  /// Find what dx has to move from @p ghosted, but for 1 - @p share of what has been held back. Collective.
  void move_from(const Vector &ghosted, double share);
  /// What has to be moved now.
  void hold_back();
  bool moves(const unsigned int block) const { return constraints_move[block]; }
  bool moves() const;
  double largest_move() const { return move; } ///< of any unknown

  /// Complete @p dx by the constrained unknowns; @p ghosted is a copy of it, as in all of these.
  void distribute(Vector &dx, const Vector &ghosted) const;
  /// Likewise a rate: what is prescribed has none. @p what_is_prescribed: else these unknowns stay as they
  /// are.
  void distribute_rate(Vector &rate, const Vector &ghosted, bool what_is_prescribed) const;
  /// Make those unknowns of @p x that follow others do so; what is prescribed stays as it is.
  void follow(Vector &x, const Vector &ghosted) const;
  /// Make @p x satisfy the constraints of the current time, by moving the constrained unknowns alone.
  void constrain(Vector &x, const Vector &ghosted) const;

private:
  void find_lines_of_ties(double t);
  void make_relevant_set(double t);
  ConstraintLines lines_at(double t) const;
  bool depend_on_time() const;
  bool are_prescribed(const ConstraintLines &lines) const;
  void make(ConstraintLines lines);
  template <typename Constant>
  void apply(Vector &x, const Vector &ghosted, const Constant &constant, bool what_is_prescribed) const;

  Model<dim> &model;
  const bool moves_nothing;
  dealii::IndexSet relevant;
  ConstraintLines tie_lines;                               ///< of owned unknowns
  std::set<dealii::types::global_dof_index> unconstrained; ///< of tie_lines, where they have no solution
  std::shared_ptr<const ConstraintLines> lines_of_x;
  dealii::AffineConstraints<double> constraints;
  std::vector<double> prescribed; ///< of each of their lines: the constant in that of x at the current time
  std::vector<bool> constraints_move; ///< by block
  double move = 0;
  std::map<dealii::types::global_dof_index, double> held_moves; ///< of relevant constrained unknowns
  double tie_seconds = 0;
};

} // namespace dovetail
