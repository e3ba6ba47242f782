// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The largest eigenvalue of a problem whose matrices are known by their factors.

#pragma once

#include <vector>

namespace dovetail {

/// @f[ S^T S\, x = \lambda\, (B^T B - C^T C)\, x @f]
/// The products are never formed: they would square the condition number, which on thin cells is that of the
/// aspect ratio already.
struct FactoredProblem
{
  unsigned int n = 0;          ///< the length of x
  std::vector<double> S, B, C; ///< row by row
  /// Orthonormal vectors, orthogonal to the kernel of B and C, that are taken out where C is not empty: the
  /// right-hand side is lifted by their dyads times its trace.
  std::vector<std::vector<double>> lifted = {};
  double rounding = 0; ///< of the rows of B and C, relative to the largest ones
};

/// Outside the kernel of B and C, by a QR factorisation with pivoting, [B; C] P = Q R, whose rank is decided
/// at 1e-12 of its largest pivot, or at the rounding if that is larger: with y = R P^T x the problem is (S P
/// R^-1)^T (S P R^-1) y = lambda (I - 2 Q_C^T Q_C) y. Infinite if the right-hand side is not positive or S
/// does not vanish on the kernel, NaN if all is kernel.
double largest_eigenvalue(const FactoredProblem &problem);

} // namespace dovetail
