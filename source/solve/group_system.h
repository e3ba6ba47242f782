// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The equations of a group of blocks, as its solver sees them.

#pragma once

#include "condensed_bodies.h"
#include "merged_matrix.h"
#include "saddle_point.h"

#include <dovetail/solve/linear_solver.h>

#include <functional>
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
  const GroupFacts &iterated_facts() const { return facts_of_iteration; } ///< of iterated()
  const SolveGroup &blocks() const { return group; }

  /// The matrix has new entries.
  void set_matrix(const BlockMatrix &matrix);
  void forget_matrix();
  void consider_constraints();
  void consider_shape();
  /// Whether the smoother of the finest level multiplies by cells, with no matrix.
  void smooth_by_products(const bool by_products) { is_smoothed_by_products = by_products; }
  void limit_iterations(const double most, const double most_before_change)
  {
    facts_of_iteration.most_iterations = most;
    facts_of_iteration.most_before_change = most_before_change;
  }
  void set_next_goal(GroupFacts::NextGoal next_goal) { facts_of_iteration.next_goal = std::move(next_goal); }
  /// Between set_matrix and the first use of iterated(). Calls @p forget before what has been iterated() so
  /// far is destroyed. Collective.
  void make_iterated(const std::function<void()> &forget);
  /// An iteration without multipliers has failed: keep them. @return whether it was without them
  bool keep_multipliers()
  {
    has_failed = has_failed || may_condense;
    return std::exchange(may_condense, false);
  }

  const MergedMatrix &plain() const { return *merged; } ///< entries as they are
  /// For iterations, one norm for all unknowns: without multipliers where these are of ties, if that serves.
  const GroupOperator &iterated() const;
  const IteratedForm *form() const { return form_of_iteration; } ///< nullptr: iterated() is plain()
  /// Multipliers stay, for which K must have all entries, and it does not.
  bool lacks_entries() const { return all_facts.has_multipliers && !may_condense && merged->has_products(); }
  /// Of one field, coupled or not: then what rounding leaves of K x may move a stiff body. Collective.
  bool has_stiff_and_soft_bodies() const;

private:
  void share_facts();
  bool condense();
  void make_saddle();
  std::vector<bool> dropped(unsigned int block) const;
  std::vector<CondensedBodies::Follower> followers() const;
  Modes near_null_space(const Selection *rows) const;
  std::unique_ptr<BodyMotions> motions_of_bodies(const Epetra_CrsMatrix &entries) const;
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
  double contrast(const std::function<bool(unsigned int i, unsigned int j)> &count) const;
  double contrast_of_neighbours() const;
  std::vector<double> usual_diagonals() const;
  std::vector<double> stiffness_of_row() const;
  std::vector<unsigned int> color_blocks() const;

  const SolveGroup group;
  GroupFacts all_facts, facts_of_iteration;
  const BlockMatrix *matrix = nullptr;
  std::unique_ptr<MergedMatrix> merged;
  const bool can_condense; ///< multipliers
  bool may_condense, has_failed = false, is_smoothed_by_products = false;
  std::unique_ptr<CondensedBodies> condensed; ///< with multipliers, or
  std::unique_ptr<SaddlePoint> saddle;
  const IteratedForm *form_of_iteration = nullptr; ///< one of these
};

} // namespace dovetail
