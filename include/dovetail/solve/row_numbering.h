// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The unknowns of several blocks as the rows of one matrix.

#pragma once

#include <deal.II/base/index_set.h>
#include <deal.II/lac/trilinos_parallel_block_vector.h>

#include <utility>
#include <vector>

namespace dovetail {

/// Rows so that each rank owns a contiguous range, as Trilinos wants them: its unknowns of the first block,
/// then those of the second, … The unknowns that a rank owns of a block are contiguous as well.
class RowNumbering
{
public:
  using Index = dealii::types::global_dof_index;
  using BlockVector = dealii::TrilinosWrappers::MPI::BlockVector;

  RowNumbering() = default;
  /// @p owned: unknowns of each block of the system that this rank owns; @p blocks: those that have rows
  /// here. Collective.
  RowNumbering(const std::vector<dealii::IndexSet> &owned, const std::vector<unsigned int> &blocks,
               const MPI_Comm &communicator);

  const std::vector<unsigned int> &blocks() const { return block_numbers; }
  Index size() const { return first_of_rank.back(); }
  unsigned int n_local() const { return first_local.back(); }
  /// Of the own unknowns of the i-th block, and of all blocks for the one after the last.
  unsigned int first_local_of(const unsigned int i) const { return first_local[i]; }
  dealii::IndexSet owned() const;

  /// Of an unknown of the i-th block.
  Index row(unsigned int i, Index index_in_block) const;
  /// Which of the blocks, and the index in it.
  std::pair<unsigned int, Index> unknown(Index row) const;

  /// The own unknowns of the blocks, one behind the other.
  void gather(const BlockVector &from, double *to) const;
  void scatter(const double *from, BlockVector &to) const;

private:
  std::vector<unsigned int> block_numbers, first_local;
  unsigned int this_rank = 0;
  std::vector<Index> first_of_rank;              ///< n_ranks + 1 entries
  std::vector<std::vector<Index>> first_unknown; ///< of each block, of each rank, in the block; likewise
  std::vector<std::vector<Index>> first_row;     ///< of each rank, of each block
};

} // namespace dovetail
