// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#pragma once

#include <dovetail/solve/block_matrix.h>

#include <functional>
#include <optional>

namespace dovetail {

/// Solves r(x) = b - A x = 0 for an A that rounding hides from the matrix K: r is evaluated without K, and
/// K^-1 is known to a few digits. Iterative refinement adds c = K^-1 r(x). If A is symmetric, flexible
/// conjugate gradients (Notay 2000) make each c A-conjugate to the direction d before it, and go the length
/// (d . r)/(d . A d) along it, where A d = r(x) - r(x + d): some functions that K sees wrongly by half take a
/// few steps, and a step may be larger than the one before. Where d . A d is not positive, the whole of d is
/// taken.
class IterativeRefinement
{
public:
  using Vector = BlockMatrix::Vector;

  /// r(x). @return false where it is not defined
  using Residual = std::function<bool(const Vector &x, Vector &r)>;
  /// c = K^-1 r to a few digits. @return the number of linear iterations; nothing if the solver has failed
  using Inverse = std::function<std::optional<unsigned int>(const Vector &r, Vector &c)>;
  /// Of a step beside x: the largest share of a part.
  using Share = std::function<double(const Vector &step, const Vector &x)>;

  IterativeRefinement(Residual residual, Inverse inverse, Share share, bool is_symmetric);

  /// Until the next step is expected to be a share of 1e-11 at most, or steps no longer become smaller.
  void refine(Vector &x);

  /// Or of one that was larger and was not taken; 1 without any.
  double share_of_last_step() const { return last_share; }
  bool is_exact() const { return last_share < exact_share; }
  static constexpr double exact_share = 1e-8;
  unsigned int n_iterations() const { return iterations; } ///< linear ones

private:
  const Residual residual;
  const Inverse inverse;
  const Share share;
  const bool is_symmetric;
  double last_share = 1, smallest_share = 1;
  unsigned int iterations = 0;
};

} // namespace dovetail
