// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The iteration that fits a group, around any preconditioner of its bodies.

#pragma once

#include <dovetail/solve/group_solver.h>

#include <functional>
#include <string>

namespace dovetail {

/// z = P r, with about the inverse of GroupOperator::bodies().
using Preconditioner = std::function<void(GroupVector &z, const GroupVector &r)>;

/// What is known of an iteration at its end.
struct CourseOfIteration
{
  double decades = 0;        ///< by which the residual has fallen, perhaps far below the goal
  bool met_negative = false; ///< CG, a direction p with p.Kp < 0: K is not positive definite
};

/// Solve K x = b from x = 0 to |b - K x| <= goal: by CG if the group is symmetric and positive definite, else
/// by flexible GMRES with 100 vectors. With multipliers by GMRES with the block triangular preconditioner
/// [A 0; B -S]^-1, A^-1 by P and S^-1 by K.solve_schur_complement() (doc/theory/linear_solvers.md), in the
/// inner product of about K^-1 where K is symmetric. CG and this one ask GroupFacts::next_goal how to go on.
/// @param gives_up whether to stop after n iterations with a residual of r; never if it is empty
/// @return the number of iterations
/// @throw dealii::SolverControl::NoConvergence after 500 of them, or when it gives up, with what was reached
/// in x
unsigned int solve_by_iteration(const GroupOperator &K, const GroupFacts &facts, const Preconditioner &P,
                                GroupVector &x, const GroupVector &b, double goal,
                                const std::function<bool(unsigned int n, double r)> &gives_up = {},
                                CourseOfIteration *course = nullptr);

/// x of K x = b from 0 by @p first. If that ends without convergence, @p second solves for what it leaves.
/// @return the number of iterations of both
using Attempt = std::function<unsigned int(GroupVector &x, const GroupVector &b)>;
unsigned int solve_in_two_attempts(const GroupOperator &K, GroupVector &x, const GroupVector &b,
                                   const Attempt &first, const Attempt &second);

/// "CG with @p preconditioner", "GMRES with @p preconditioner and Schur complement", …
std::string describe_iteration(const GroupFacts &facts, const std::string &preconditioner);

} // namespace dovetail
