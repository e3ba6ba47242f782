// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Whether conditions whose toggles look at fields act elsewhere than in the step before.

#pragma once

#include <dovetail/system/model.h>

#include <optional>
#include <utility>
#include <vector>

namespace dovetail {

/// Remembers where such conditions act in this step and where they acted in the last good one before it, by
/// the rules of Domain::last_good: a step that fails is followed by one that ends earlier, and is compared
/// with the same good one again.
template <int dim>
class ConditionSwitches
{
public:
  /// A step to time @p t has begun (BlockSystem::begin_step()). Collective.
  void look(const Model<dim> &model, double t);
  /// Materials have chosen their phases of the step to time @p t after the good step to time @p last, which
  /// has led to @p x, ghosted. A step that switches them has switched. Collective.
  void look_at_phases(const Model<dim> &model, double last, double t, const Vector &x);
  bool have_switched() const { return is_new; }
  bool have_pushed() const { return pushes; } ///< and act on what has inertia

private:
  struct Places ///< quadrature points of this rank
  {
    std::vector<dealii::Point<dim>> all, with_inertia;
  };
  static Places find(const Model<dim> &model, double t);
  void learn(bool has_switched, bool has_pushed, const MPI_Comm &communicator);

  std::optional<std::pair<double, Places>> now, before; ///< with the time at which the step ends
  bool is_new = false, pushes = false;
};

} // namespace dovetail
