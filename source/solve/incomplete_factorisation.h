// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The incomplete Cholesky factorisation of some of the entries of a matrix.

#pragma once

#include "compact_matrix.h"

#include <dovetail/solve/approximation.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace dovetail {

/// The incomplete factorisation without fill-in of the own rows and columns of A + s diag(A), which are
/// symmetric,
/// @f[ M = (D + U)^T D^{-1} (D + U), @f]
/// in single precision and by blocks: D are the diagonal blocks of rows that share their columns, and U is
/// what A has above them. Only D^-1 and W = D^-1 U are stored, half of the entries of A:
/// @f[ M = (I + W)^T D (I + W). @f]
/// Without a shift s it may break down although A is positive definite.
///
/// J. A. Meijerink, H. A. van der Vorst: An iterative solution method for linear systems of which the
/// coefficient matrix is a symmetric M-matrix, 1977. T. A. Manteuffel: An incomplete factorization technique
/// for positive definite linear systems, 1980.
class IncompleteFactorisation : public Approximation
{
public:
  /// @param A shares its columns
  /// @throws dealii::ExcMessage if a diagonal block is not positive definite
  IncompleteFactorisation(const CompactMatrix &A, double shift);
  void vmult(double *z, const double *r) const override;

  std::size_t memory_consumption() const; ///< in bytes, without the columns

private:
  void copy_upper(const CompactMatrix &A, double shift);
  void factorise();

  std::shared_ptr<const RowPattern> pattern;
  std::vector<std::size_t> first; ///< entry of each group
  std::vector<float> entries;     ///< of each group those of D^-1, then those of W as FourColumns; and zeros
  double unit;                    ///< of A
};

} // namespace dovetail
