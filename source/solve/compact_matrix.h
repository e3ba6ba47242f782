// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Sparse matrices of multigrid's levels in little memory.

#pragma once

#include <dovetail/solve/column_exchange.h>
#include <dovetail/widest_vectors.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Map.h>
#include <Epetra_Vector.h>

#include <cstddef>
#include <memory>
#include <type_traits>
#include <vector>

namespace dovetail {

/// Calls @p action(n) with a constant for the usual numbers of rows, so that the compiler knows it.
template <typename Action>
DOVETAIL_PART_OF_CALLER void with_known_number(const int n, const Action &action)
{
  if (n == 1)
    action(std::integral_constant<int, 1>());
  else if (n == 2)
    action(std::integral_constant<int, 2>());
  else if (n == 3)
    action(std::integral_constant<int, 3>());
  else if (n == 6)
    action(std::integral_constant<int, 6>());
  else
    action(n);
}

/// Local numbers of the columns of @p A as ColumnExchange has them.
std::vector<int> numbers_of_columns(const Epetra_CrsMatrix &A);

/// The columns of the entries of a matrix. Rows that follow each other and have the same columns, as those of
/// the components at a node, hold these once, and of columns that follow each other the first ones. A column
/// that is zero but for its diagonal entry, as of a prescribed unknown, is left out, and its row is by
/// itself. Every row of a symmetric matrix has its diagonal entry, and of the own columns those before the
/// rows of the group are left out.
class RowPattern
{
public:
  /// Of the own rows of @p A, which is filled.
  RowPattern(const Epetra_CrsMatrix &A, bool is_symmetric);

  static constexpr int most_rows = 8; ///< of a group

  /// Columns of a group, which ascend: @p block_length from each of the first ones on.
  struct Columns
  {
    const int *first;
    int block_length, size;

    Columns from(const int k) const { return {first + k / block_length, block_length, size - k}; }
  };
  /// Rows that share their columns.
  struct Group
  {
    int first_row, n_rows;
    Columns columns;
    int n_own;               ///< how many columns are own ones
    std::size_t first_entry; ///< of n_rows * columns.size, in the order of FourColumns
  };
  unsigned int n_groups() const { return groups.size(); }
  Group group(const unsigned int g) const
  {
    const Stored &stored = groups[g];
    const int end_row = g + 1 < groups.size() ? groups[g + 1].first_row : number_of_rows;
    return {stored.first_row,
            end_row - stored.first_row,
            {blocks.data() + stored.first_block, stored.block_length, stored.n_columns},
            stored.n_own,
            stored.first_entry};
  }

  bool is_symmetric() const { return symmetric; }
  int n_rows() const { return number_of_rows; }
  std::size_t n_entries() const { return number_of_entries; }
  int most_columns() const { return largest_number_of_columns; } ///< of a group
  std::size_t memory_consumption() const;

private:
  struct Stored
  {
    std::size_t first_block, first_entry;
    int first_row, block_length, n_columns, n_own;
  };

  std::vector<Stored> groups;
  std::vector<int> blocks; ///< first columns of all groups
  bool symmetric;
  int number_of_rows = 0, largest_number_of_columns = 0;
  std::size_t number_of_entries = 0;
};

/// A matrix in single precision. The largest size of an entry is the unit of the others, as single precision
/// may not hold it. Products are summed in double precision.
class CompactMatrix
{
public:
  explicit CompactMatrix(const Epetra_CrsMatrix &A, bool is_symmetric = true);
  /// In place of @p A, whose rows give back their memory as soon as they have been read.
  explicit CompactMatrix(std::unique_ptr<Epetra_CrsMatrix> A, bool is_symmetric = true);

  const Epetra_Map &rows() const { return range; }
  const Epetra_Map &domain() const { return exchange.own(); }

  void multiply(Epetra_Vector &y, const Epetra_Vector &x) const;            ///< y = A x; collective
  void multiply_transposed(Epetra_Vector &y, const Epetra_Vector &x) const; ///< y = A^T x; collective
  void diagonal(Epetra_Vector &values) const;

  std::size_t memory_consumption() const; ///< in bytes

private:
  friend class IncompleteFactorisation;

  template <typename Done>
  void set_values(const Epetra_CrsMatrix &A, const Done &done);

  Epetra_Map range;
  ColumnExchange exchange;
  std::shared_ptr<const RowPattern> pattern;
  std::vector<float> values; ///< and some zeros
  double unit = 0;
};

/// As a CompactMatrix holds it. P^T A P needs the rounded P that is applied: a stiff body resists the
/// difference of two of them more than soft ones resist its motion.
void round_to_single_precision(Epetra_CrsMatrix &P);

} // namespace dovetail
