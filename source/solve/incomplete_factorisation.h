// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// M = LU of some of the entries of a matrix.

#pragma once

#include "approximation.h"
#include "compact_matrix.h"

#include <memory>
#include <vector>

namespace dovetail {

/// M = LU, the incomplete factorisation without fill-in of the own rows and columns of A + shift diag(A), in
/// single precision. Without a shift it may be indefinite although A is not.
///
/// T. A. Manteuffel: An incomplete factorization technique for positive definite linear systems, 1980.
class IncompleteFactorisation : public Approximation
{
public:
  /// Copies of @p A share the columns of the entries.
  IncompleteFactorisation(CompactMatrix A, double shift);
  void vmult(double *z, const double *r) const override;

private:
  void factorise();
  void eliminate(const RowPattern::Group &group, const std::vector<unsigned int> &group_of_row,
                 const std::vector<int> &position);
  float *entries(const RowPattern::Group &group, const int k)
  {
    return &values[group.first_entry + static_cast<std::size_t>(k) * group.n_rows];
  }

  std::shared_ptr<const RowPattern> pattern;
  std::vector<float> values; ///< L without its diagonal, which is one, and U with the inverse of its diagonal
  double unit;               ///< of A
};

} // namespace dovetail
