// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A group with multipliers, for iterations.

#pragma once

#include "merged_matrix.h"

#include <memory>
#include <vector>

namespace dovetail {

/// [A B^T; B -C] with the multipliers scaled: the diagonal of the Schur complement C + B diag(A)^-1 B^T
/// becomes the mean diagonal entry of A. Then all unknowns, and all residuals, have one unit. With D the
/// scale it is D K D, its unknowns D^-1 x, its right-hand side D b. A multiplier that was dropped is marked:
/// C may well have a diagonal.
class SaddlePoint : public GroupOperator
{
public:
  /// @p all: with the multipliers, last; @p bodies and @p multipliers: their blocks, a part each;
  /// @p dropped: of each own multiplier.
  SaddlePoint(const BlockMatrix &matrix, const MergedMatrix &all, const std::vector<unsigned int> &bodies,
              const std::vector<unsigned int> &multipliers, std::vector<bool> dropped);
  /// The matrix has new values. Collective.
  void update();

  void scale_multipliers(GroupVector &x) const; ///< x = D x

  GroupVector vector() const override { return all.vector(); }
  void vmult(GroupVector &destination, const GroupVector &source) const override;
  void diagonal(GroupVector &destination) const override;
  const GroupOperator &bodies() const override { return body_operator; }
  const std::vector<double> &schur_complement() const override { return schur; }

private:
  const BlockMatrix &matrix;
  const MergedMatrix &all;
  MergedMatrix body_operator;
  const unsigned int body_part, multiplier_part;
  const std::vector<bool> dropped;
  std::vector<double> scale, schur; ///< of the own multipliers
};

} // namespace dovetail
