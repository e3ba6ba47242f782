// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What an iteration solves in place of a system with multipliers.

#pragma once

#include <dovetail/solve/group_solver.h>

namespace dovetail {

/// Another system of which the solution of K x = b follows. All of its unknowns, and residuals, have one
/// unit.
class IteratedForm : public GroupOperator
{
public:
  virtual GroupVector right_hand_side(const GroupVector &b) const = 0;                ///< from that of K
  virtual GroupVector solution(const GroupVector &x, const GroupVector &b) const = 0; ///< of K from its own
  virtual GroupVector sizes_of_residual(const GroupVector &sizes) const = 0;          ///< from those of K
};

} // namespace dovetail
