// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Steps along the path of solutions, past limit points.

#pragma once

#include <dovetail/run/nonlinear_step.h>

#include <optional>

namespace dovetail {

/// The time t, which scales loads and prescribed values, is unknown as well: with Newton's method the state x
/// and t solve R(x, t) = 0 and |x - x_0| = L, the Euclidean norm of all unknowns of vectors, from the last
/// good state x_0 (Crisfield, Computers & Structures 13 (1981), 55; Riks, International Journal of Solids and
/// Structures 15 (1979), 529). Each update is a + s v with K a = -R and the rate v = dx/dt, found with the
/// same factors from the loads a little later; s follows from the length L. L grows where few iterations were
/// needed, up to what the first step has.
template <int dim>
class ArcLength
{
public:
  /// @p size: of the first step in time. @p smallest: L of a step that is tried, relative to the first one.
  ArcLength(NonlinearStep<dim> &step, double size, double smallest)
      : step(step), size(size), smallest(smallest)
  {
  }

  /// From the last good state @p x_0 of time @p t_0 to x at t; both are the last iterates if it fails.
  /// @pre the step has begun there. Collective.
  NewtonResult solve(const Vector &x_0, double t_0, Vector &x, double &t, unsigned int most_iterations);
  /// A step that led by @p change to x was good.
  void accept(const Vector &change, unsigned int n_iterations);
  bool shorten(); ///< after a step that failed. @return whether a shorter one may be tried

  void save(SavedState &to) const; ///< what the next step depends on
  void restore(const SavedState &from);

private:
  bool find_rate(double t, const Vector &x, const Vector &a, Vector &v);
  double product(const Vector &x, const Vector &y) const;

  NonlinearStep<dim> &step;
  const double size, smallest;
  double length = 0, first_length = 0; ///< 0: before the first step
  double length_after_good = 0;        ///< what the last good step has left, whatever has been tried since
  std::optional<Vector> last_change;   ///< of the last good step
};

} // namespace dovetail
