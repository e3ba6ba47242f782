// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The equations of a group of blocks, as its solver sees them.

#pragma once

#include "merged_matrix.h"
#include "saddle_point.h"

#include <dovetail/solve/linear_solver.h>

#include <memory>
#include <utility>
#include <vector>

namespace dovetail {

/// Owns the operators of a group, and turns what the system knows by block and unknown into facts by row.
class GroupSystem
{
public:
  using Modes = std::vector<std::vector<double>>; ///< [mode][own row]

  explicit GroupSystem(SolveGroup group);
  GroupSystem(const GroupSystem &) = delete; // the facts refer to it

  const GroupFacts &facts() const { return all_facts; }
  const SolveGroup &blocks() const { return group; }

  /// The matrix has new entries.
  void set_matrix(const BlockMatrix &matrix);
  void forget_matrix();
  void consider_constraints();
  void limit_iterations(const double most) { all_facts.most_iterations = most; }
  void set_next_goal(GroupFacts::NextGoal next_goal) { all_facts.next_goal = std::move(next_goal); }
  /// Between set_matrix and the first use of scaled(). Collective.
  void make_scaled();

  const MergedMatrix &plain() const { return *merged; } ///< entries as they are
  /// For iterations, one norm for all unknowns.
  const GroupOperator &scaled() const;
  void scale_multipliers(GroupVector &x) const; ///< solution or right-hand side of scaled()
  /// Of one field, coupled or not: then what rounding leaves of K x may move a stiff body. Collective.
  bool has_stiff_and_soft_bodies() const;

private:
  Modes near_null_space(const Selection *rows) const;
  Selection of_block(unsigned int i, const Selection &rows) const;
  RowSums linear_part() const;
  MeshLevels mesh_levels(bool with_parents) const;
  void renumber(RowSums &sums) const;
  std::vector<int> field_of_block() const;
  std::vector<int> field_of_row() const;
  std::vector<GroupFacts::Place> places(const Selection *rows) const;
  unsigned int largest_number_of_modes() const;
  bool are_coupled(unsigned int block, unsigned int other) const;
  std::vector<double> mean_diagonals() const;
  double contrast() const;
  std::vector<double> usual_diagonals() const;
  std::vector<double> stiffness_of_row() const;
  std::vector<unsigned int> color_blocks() const;

  const SolveGroup group;
  GroupFacts all_facts;
  const BlockMatrix *matrix = nullptr;
  std::unique_ptr<MergedMatrix> merged;
  std::unique_ptr<SaddlePoint> saddle; ///< with multipliers
};

} // namespace dovetail
