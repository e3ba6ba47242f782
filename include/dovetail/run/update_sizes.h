// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#pragma once

#include <dovetail/domain/numbering.h>
#include <dovetail/solve/block_matrix.h>

#include <vector>

namespace dovetail {

/// How large updates dx of a state x are in the bodies, and what rounding may make of them [-]. Multipliers
/// and pressures follow the bodies: they do not count.
class UpdateSizes
{
public:
  using Vector = BlockMatrix::Vector;

  /// @p fields: by block, the number of its field. Both live longer than this object.
  UpdateSizes(const std::vector<Block> &blocks, const std::vector<unsigned int> &fields)
      : blocks(blocks), fields(fields)
  {
  }

  /// @f$ u \, \| |K| |dx| \| \, \| dx \| / | dx \cdot K dx | @f$, what rounding of K may change of the
  /// energy, of the field where this is largest. A stiff body that a slender one holds, of the same
  /// stiffness, moves as far as the rounding of its forces moves it. @pre dx is zero where it is constrained
  double rounding_of_energy(const BlockMatrix &K, const Vector &dx) const;

  /// Of bodies: the largest norm of @p correction relative to that of @p dx. What is nothing beside @p x or
  /// beside other bodies is rounding.
  double share_of(const Vector &correction, const Vector &x, const Vector &dx) const;

  /// How much of x + dx the update is, of the field where this is largest: where nothing happens in a step,
  /// dx is rounding.
  double part_of_solution(const Vector &x, const Vector &dx) const;

private:
  const std::vector<Block> &blocks;
  const std::vector<unsigned int> &fields;
};

} // namespace dovetail
