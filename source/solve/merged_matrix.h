// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Several blocks of a block matrix as one Epetra matrix.

#pragma once

#include <dovetail/solve/block_matrix.h>
#include <dovetail/solve/group_solver.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Map.h>

#include <memory>
#include <vector>

namespace dovetail {

/// The square matrix of some blocks, rows numbered so that each rank owns a contiguous range: its unknowns of
/// the first block, then of the second, … ML and MUMPS want one matrix. The structure is merged once; after
/// that only values are copied, through a table of positions. A single block is used as it is.
class MergedMatrix : public GroupOperator
{
public:
  using BlockVector = dealii::TrilinosWrappers::MPI::BlockVector;

  MergedMatrix(const BlockMatrix &matrix, const std::vector<unsigned int> &blocks);
  void copy_values(const BlockMatrix &matrix);

  GroupVector vector() const override;
  void vmult(GroupVector &destination, const GroupVector &source) const override;
  void diagonal(GroupVector &destination) const override;
  const Epetra_CrsMatrix *matrix() const override { return single ? single : merged.get(); }

  void gather(const BlockVector &from, GroupVector &to) const;
  void scatter(const GroupVector &from, BlockVector &to) const;
  unsigned int n_local() const { return first_local.back(); }
  /// Of the row with a global index in the i-th block.
  int global_row(unsigned int i, int index_in_block) const;
  unsigned int first_local_of(const unsigned int i) const { return first_local[i]; } ///< of the i-th block

private:
  void number_rows(const BlockMatrix &matrix);
  void merge_structure(const BlockMatrix &matrix);
  void fill_structure(const BlockMatrix &matrix, const std::vector<std::vector<std::vector<int>>> &column_of);

  std::vector<unsigned int> block_numbers;
  std::vector<std::vector<unsigned int>> columns_of; ///< of each block row those of block_numbers that exist
  std::vector<unsigned int> first_local; ///< first local row of each block, and the number of local rows
  const Epetra_CrsMatrix *single = nullptr;
  std::unique_ptr<Epetra_CrsMatrix> merged;
  /// Where each rank's part of each block begins, in the block (n_ranks + 1 entries) and merged (n_ranks).
  std::vector<std::vector<int>> begin_in_block, begin_merged;
  std::vector<bool> in_order; ///< the merged row is its parts in the blocks, one after another
  /// Else, in the merged row, of each entry in the order block row, row, block column, entry.
  std::vector<int> position;
};

} // namespace dovetail
