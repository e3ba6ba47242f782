// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A matrix of blocks most of which are empty.

#pragma once

#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/block_indices.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/full_matrix.h>
#include <deal.II/lac/trilinos_parallel_block_vector.h>
#include <deal.II/lac/trilinos_sparse_matrix.h>

#include <map>
#include <memory>
#include <vector>

namespace dovetail {

/// A square matrix with one block per pair of blocks of unknowns. A body is tied to few others, so of n^2
/// blocks some 3 n have entries; only these, and those on the diagonal, exist (deal.II's BlockSparseMatrix
/// keeps arrays of the length of the rows for each empty one). Which blocks exist is the same on all ranks.
class BlockMatrix
{
public:
  using value_type = double;
  using size_type = dealii::types::global_dof_index;
  using Block = dealii::TrilinosWrappers::SparseMatrix;
  using Vector = dealii::TrilinosWrappers::MPI::BlockVector;

  BlockMatrix() = default;
  virtual ~BlockMatrix() = default; // deal.II's constraints ask by dynamic_cast what it is

  /// @p owned: unknowns of each block that this rank owns; @p pattern: of all blocks together, which has the
  /// rows that this rank owns or writes to, and is emptied. Collective.
  void reinit(const std::vector<dealii::IndexSet> &owned, dealii::DynamicSparsityPattern &pattern,
              const MPI_Comm &communicator);
  void clear();

  unsigned int n_block_rows() const { return blocks.size(); }
  const dealii::BlockIndices &get_row_indices() const { return indices; }
  size_type m() const { return indices.total_size(); }
  size_type n() const { return indices.total_size(); }

  bool has_block(const unsigned int row, const unsigned int column) const
  {
    return blocks[row].count(column) > 0;
  }
  const Block &block(const unsigned int row, const unsigned int column) const
  {
    return *blocks[row].at(column);
  }
  /// The blocks of a row by their columns.
  const std::map<unsigned int, std::unique_ptr<Block>> &row(const unsigned int row) const
  {
    return blocks[row];
  }

  BlockMatrix &operator=(double zero);
  void copy_from(const BlockMatrix &other);
  void add(double factor, const BlockMatrix &other); ///< of the same pattern
  void add(size_type row, size_type n, const size_type *columns, const double *values,
           bool elide_zeros = true, bool columns_are_sorted = false);
  void add(size_type row, size_type column, double value);
  void compress(dealii::VectorOperation::values operation);

  void vmult(Vector &destination, const Vector &source) const;
  double el(size_type row, size_type column) const;

private:
  dealii::BlockIndices indices;
  std::vector<std::map<unsigned int, std::unique_ptr<Block>>> blocks;
  std::vector<size_type> local_columns; // scratch
};

/// Add a local matrix and vector on constraints, as AffineConstraints::distribute_local_to_global.
void distribute_local_to_global(const dealii::AffineConstraints<double> &constraints,
                                const dealii::FullMatrix<double> &local_matrix,
                                const dealii::Vector<double> &local_vector,
                                const std::vector<BlockMatrix::size_type> &dofs, BlockMatrix &matrix,
                                BlockMatrix::Vector &vector);

} // namespace dovetail
