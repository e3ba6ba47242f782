// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A matrix of blocks most of which are empty. Blocks that are solved together are stored together.

#pragma once

#include <dovetail/solve/part_operator.h>
#include <dovetail/solve/row_numbering.h>

#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/block_indices.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/full_matrix.h>
#include <deal.II/lac/trilinos_parallel_block_vector.h>
#include <deal.II/lac/trilinos_sparse_matrix.h>

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

namespace dovetail {

/// A square matrix with one block per pair of blocks of unknowns. Blocks that a solver wants as one matrix
/// form a part, with a numbering of its rows; each pair of parts with entries, and each part with itself, has
/// one Trilinos matrix. So every entry exists once. Which pairs have entries is the same on all ranks. A part
/// may have a summand without entries, which counts in products and in the diagonal.
class BlockMatrix
{
public:
  using value_type = double;
  using size_type = dealii::types::global_dof_index;
  using Part = dealii::TrilinosWrappers::SparseMatrix;
  using Vector = dealii::TrilinosWrappers::MPI::BlockVector;

  BlockMatrix() = default;
  virtual ~BlockMatrix() = default; // deal.II's constraints ask by dynamic_cast what it is

  /// @p owned: unknowns of each block that this rank owns; @p part_of_block: 0, 1, … without a gap;
  /// @p pattern: of all blocks together, which has the rows that this rank owns or writes to, and is emptied.
  /// Collective.
  void reinit(const std::vector<dealii::IndexSet> &owned, const std::vector<unsigned int> &part_of_block,
              dealii::DynamicSparsityPattern &pattern, const MPI_Comm &communicator);
  void clear();

  unsigned int n_block_rows() const { return indices.size(); }
  const dealii::BlockIndices &get_row_indices() const { return indices; }
  size_type m() const { return indices.total_size(); }
  size_type n() const { return indices.total_size(); }
  MPI_Comm get_mpi_communicator() const { return parts[0].at(0)->get_mpi_communicator(); }

  /// Whether a block has entries on any rank; one on the diagonal counts always.
  bool has_block(const unsigned int row, const unsigned int column) const
  {
    if (columns_of[row].count(column) > 0)
      return true;
    const PartOperator *summand = part_of(row) == part_of(column) ? part_operator(part_of(row)) : nullptr;
    return summand != nullptr && summand->coupled_blocks().count({row, column}) > 0;
  }

  /// Unknowns of each block that this rank owns.
  const std::vector<dealii::IndexSet> &owned_unknowns() const { return owned; }
  unsigned int part_of(const unsigned int block) const { return place[block].part; }
  const RowNumbering &numbering(const unsigned int part) const { return numberings[part]; }
  bool has_part(const unsigned int row, const unsigned int column) const
  {
    return parts[row].count(column) > 0;
  }
  const Part &part(const unsigned int row, const unsigned int column) const { return *parts[row].at(column); }
  /// Until reinit() or clear().
  void set_operator(const unsigned int part, std::shared_ptr<PartOperator> summand)
  {
    operators[part] = std::move(summand);
  }
  const PartOperator *part_operator(const unsigned int part) const ///< nullptr: all there is are entries
  {
    const auto found = operators.find(part);
    return found == operators.end() ? nullptr : found->second.get();
  }

  BlockMatrix &operator=(double zero);
  void set_zero(const std::vector<bool> &rows); ///< of some blocks, which are whole parts
  void copy_from(const BlockMatrix &other);
  void add(double factor, const BlockMatrix &other); ///< of the same pattern
  void add(size_type row, size_type n, const size_type *columns, const double *values,
           bool elide_zeros = true, bool columns_are_sorted = false);
  void add(size_type row, size_type column, double value);
  void compress(dealii::VectorOperation::values operation);

  void vmult(Vector &destination, const Vector &source) const;
  /// y -= K x, rows of some blocks, columns of others, each as many as are whole parts.
  void subtract_product(const std::vector<unsigned int> &rows, const std::vector<unsigned int> &columns,
                        const Vector &x, Vector &y) const;
  /// Calls @p visit with K_rc x_c for every block that there is. Collective; so may @p visit be.
  using VisitProduct =
      std::function<void(unsigned int row, unsigned int column, const Vector::BlockType &product)>;
  void for_each_product(const Vector &x, const VisitProduct &visit) const;
  /// The unknowns that the own rows of a pair of parts multiply, by local column. Collective.
  Epetra_Vector ghosted(unsigned int row, unsigned int column, const Vector &x) const;
  /// || |K| |x| || of the rows of each block. Collective.
  std::vector<double> sizes_of_products(const Vector &x) const;

  /// Of an unknown that this rank owns. @pre Its part has entries only.
  void extract_row(size_type row, std::vector<size_type> &columns, std::vector<double> &values) const;
  /// Of the unknowns of a block that this rank owns.
  std::vector<double> diagonal(unsigned int block) const;
  /// Likewise, but of products before unknowns follow others: a body's own.
  std::vector<double> uncondensed_diagonal(unsigned int block) const;
  double el(size_type row, size_type column) const;

private:
  struct Place
  {
    unsigned int part, position; ///< of a block, in the part
  };

  using AddDiagonal = void (PartOperator::*)(Epetra_Vector &) const;
  std::vector<double> diagonal(unsigned int block, AddDiagonal of_operator) const;
  void find_blocks(const dealii::DynamicSparsityPattern &pattern, const MPI_Comm &communicator);
  std::map<unsigned int, dealii::DynamicSparsityPattern>
  split_rows(unsigned int part, dealii::DynamicSparsityPattern &pattern) const;
  void add_to_own_row(const Epetra_CrsMatrix &matrix, int row, const double *values) const;
  void add_product(unsigned int row, unsigned int column, double factor, const Vector &x, Vector &y) const;
  void visit_operator(unsigned int part, const Vector &x, const VisitProduct &visit) const;
  void visit_products(unsigned int row, unsigned int column, const Vector &x,
                      const VisitProduct &visit) const;

  dealii::BlockIndices indices;
  std::vector<Place> place;
  std::vector<dealii::IndexSet> owned;
  std::vector<std::set<unsigned int>> columns_of; ///< of each block row: the blocks that there are
  std::vector<RowNumbering> numberings;           ///< of each part
  std::vector<std::map<unsigned int, std::unique_ptr<Part>>> parts;
  std::map<unsigned int, std::shared_ptr<PartOperator>> operators; ///< by part
  std::vector<size_type> part_columns;                             // scratch
};

/// Add a local matrix and vector on constraints, as AffineConstraints::distribute_local_to_global.
/// @tparam Rows BlockMatrix::Vector or SharedSums
template <typename Rows>
void distribute_local_to_global(const dealii::AffineConstraints<double> &constraints,
                                const dealii::FullMatrix<double> &local_matrix,
                                const dealii::Vector<double> &local_vector,
                                const std::vector<BlockMatrix::size_type> &dofs, BlockMatrix &matrix,
                                Rows &vector);

} // namespace dovetail
