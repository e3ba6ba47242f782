// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// GMRES with the inner product of a preconditioner.

#pragma once

#include "least_squares.h"

#include <dovetail/solve/group_solver.h>

#include <deal.II/lac/solver_control.h>

#include <functional>
#include <utility>
#include <vector>

namespace dovetail {

/// Of K x = b. Among the residuals r that its vectors allow, it takes the one with the smallest r^T H r,
/// which is about the energy of the error: a stiff body that moves with a soft one may have a large residual
/// on the way. It starts again after a hundred vectors, and where rounding hides the residual from them.
class EnergyGmres
{
public:
  /// z, about the solution of K z = r, and H r. H is symmetric and positive definite, or solve() ends.
  using Apply = std::function<void(GroupVector &z, GroupVector &Hr, const GroupVector &r)>;

  EnergyGmres(const GroupOperator &K, Apply apply) : K(K), apply(std::move(apply)) {}

  /// From @p x. @p control checks |r|.
  /// @return whether r^T H r was positive. If not, x is what was reached.
  /// @throw dealii::SolverControl::NoConvergence
  bool solve(GroupVector &x, const GroupVector &b, dealii::SolverControl &control);
  /// @p x becomes what is reached; for where @p control is asked.
  void update(GroupVector &x);

private:
  using State = dealii::SolverControl::State;

  void start(const GroupVector &x);
  State solve_for(const GroupVector &r, const GroupVector &x, const GroupVector &b,
                  dealii::SolverControl &control);
  bool is_left_behind(const GroupVector &x, const GroupVector &b, double claimed, double at_begin) const;
  double append(const GroupVector &w);

  const GroupOperator &K;
  const Apply apply;
  bool has_only_positive = true;           ///< so far, r^T H r
  bool was_asked = false;                  ///< for x, in the present iteration
  bool looks_again = false;                ///< soon after it starts again
  unsigned int n = 0;                      ///< iterations
  GroupVector begin;                       ///< x where the vectors begin
  std::vector<GroupVector> basis, times_H; ///< v and H v, orthonormal to each other
  GroupVector z;                           ///< of the last v
  LeastSquares projected;                  ///< on the vectors
};

} // namespace dovetail
