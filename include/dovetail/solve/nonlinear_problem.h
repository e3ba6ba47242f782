// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What Newton's method asks of a system of equations.

#pragma once

#include <deal.II/lac/trilinos_parallel_block_vector.h>

#include <optional>

namespace dovetail {

/// A nonlinear system R(x) = 0 with linear constraints, its tangent K = dR/dx and the solver for
/// @f[ K(x)\, \Delta x = -R(x). @f]
/// Newton's method owns the vectors; the system keeps what was assembled last: one R and one K.
class NonlinearProblem
{
public:
  using Vector = dealii::TrilinosWrappers::MPI::BlockVector;

  virtual ~NonlinearProblem() = default;

  virtual bool is_linear() const = 0; ///< one iteration is exact

  /// Some unknowns that only receive from others are found after them. The problem has stages; all that
  /// follows means the unknowns of the present one. Others are as they are: their updates are zero.
  virtual void first_stage() {}
  /// When the present one is solved. @pre The last assembly was at the iterate @p x. @return whether there is
  /// one.
  virtual bool next_stage(const Vector & /*x*/) { return false; }
  virtual bool has_linear_stage() const { return false; } ///< one iteration of the present one is exact

  /// Whether what is left of the residual counts, too: in time the next steps would remember it. Then a
  /// system is solved even if its first residual is within the tolerance, and the last tangent is used once
  /// more.
  virtual bool is_remembered() const { return false; }

  /// Whether the residual where a step begins differs from that where the last one ended, by less than what
  /// rounding may leave, but not by rounding: many small steps add up.
  virtual bool has_hidden_load() const { return false; }

  /// Assemble R(x). @return its size relative to the forces at work, NaN if it is not defined.
  virtual double residual(const Vector &x) = 0;
  /// Likewise with K.
  virtual double residual_and_tangent(const Vector &x) = 0;

  /// The update @p dx at @p x. @pre The last assembly was that of the tangent at x.
  /// @return the number of linear iterations; nothing if the solver failed.
  virtual std::optional<unsigned int> solve(const Vector &x, Vector &dx) = 0;
  /// Of the last solve() of a linear problem: ||K dx + R|| relative to the forces at work.
  virtual double linear_residual() const = 0;
  /// Whether the constraints move prescribed values at the state of the last assembly. Then the residual
  /// there says nothing about a good damping.
  virtual bool moves_constraints() const = 0;

  /// The simplified Newton correction c, K c = -R(x + damping dx), with the tangent that was assembled last
  /// and the share 1 - damping of what the constraints have still to move. @pre R(@p trial) was assembled
  /// last, at trial = x + damping dx. @return whether the solver succeeded.
  virtual bool correct(const Vector &x, const Vector &trial, double damping, Vector &correction) = 0;

  /// The state @p trial to which the share @p damping of the update @p dx leads from @p x: their sum, or
  /// another state that differs from it by what is of second order in dx.
  virtual void move(const Vector &x, const double damping, const Vector &dx, Vector &trial)
  {
    trial = x;
    trial.add(damping, dx);
  }

  /// Whether the last solve() may have led too far, as the last assembly shows.
  virtual bool may_overshoot() const { return false; }
  /// Then the share of its update @p dx up to which its linear equations say something of the state.
  virtual double sensible_share(const Vector & /*dx*/) { return 1; }

  /// The size of an update, each field in units of its own, the same during a step.
  virtual double norm(const Vector &dx) const = 0;
  /// Whether the last @p dx was small enough for @p x, where it led to, to be a solution.
  virtual bool is_small(const Vector &dx, const Vector &x) const = 0;

  /// The state of the last assembly is the iterate from now on.
  virtual void accept_state() {}
  /// At the iterate @p x, after each full update that does not end the iteration: whether the equations have
  /// changed, what is frozen in them being adapted to x.
  virtual bool adapt(const Vector & /*x*/) { return false; }

  /// Whether a limit point may be crossed; then stabilise() is called.
  virtual bool may_cross_limit_points() const { return false; }
  /// Add @p share of a tangent that is positive definite to K(@p x). @return false if there is none.
  virtual bool stabilise(const Vector & /*x*/, double /*share*/) { return false; }

  /// Told of each iteration.
  virtual void iteration_ends(unsigned int /*number*/, double /*residual*/,
                              unsigned int /*linear_iterations*/, double /*damping*/)
  {
  }
};

} // namespace dovetail
