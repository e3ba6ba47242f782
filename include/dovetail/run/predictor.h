// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where a step may begin: the last solutions, extrapolated in time.

#pragma once

#include <deal.II/lac/trilinos_parallel_block_vector.h>

#include <optional>
#include <utility>
#include <vector>

namespace dovetail {

/// The polynomial in time through the last solutions, of degree two at most,
/// @f[ x(t) \approx \sum_i x_i \prod_{j \ne i} \frac{t - t_j}{t_i - t_j}. @f]
/// Constraints whose weights are constant hold for it, since they hold for each x_i.
///
/// P. Deuflhard: Newton Methods for Nonlinear Problems, 2004, section 5.1.
class Predictor
{
public:
  using Vector = dealii::TrilinosWrappers::MPI::BlockVector;

  /// @p x is the solution at time @p t, later than those before.
  void add(double t, const Vector &x);
  /// What comes does not go on from what was: a toggle switches, a step is rejected, meshes change.
  void forget() { solutions.clear(); }
  bool has_guess() const { return solutions.size() > 1; }
  const std::vector<std::pair<double, Vector>> &all() const { return solutions; } ///< for a checkpoint
  /// @pre has_guess()
  Vector guess(double t) const;

private:
  std::vector<std::pair<double, Vector>> solutions; ///< by time
};

} // namespace dovetail
