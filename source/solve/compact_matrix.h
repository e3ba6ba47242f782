// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Sparse matrices of multigrid's levels in little memory.

#pragma once

#include <dovetail/solve/column_exchange.h>

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
inline void with_known_number(const int n, const Action &action)
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
/// the components at a node, hold these once.
class RowPattern
{
public:
  /// Of the own rows of @p A, which is filled. If rows and domain are the same, every row has its diagonal
  /// entry.
  explicit RowPattern(const Epetra_CrsMatrix &A);

  static constexpr int most_rows = 8; ///< of a group

  /// Rows that share their columns, which ascend.
  struct Group
  {
    int first_row, n_rows;
    const int *columns;
    int n_lower, n_own, n_columns; ///< how many columns are less than the first row, are own ones, are there
    std::size_t first_entry;       ///< of n_rows * n_columns, column by column
  };
  unsigned int n_groups() const { return groups.size(); }
  Group group(const unsigned int g) const
  {
    const Stored &stored = groups[g];
    const int end_row = g + 1 < groups.size() ? groups[g + 1].first_row : number_of_rows;
    const std::size_t end = g + 1 < groups.size() ? groups[g + 1].first_column : columns.size();
    return {stored.first_row,
            end_row - stored.first_row,
            columns.data() + stored.first_column,
            stored.n_lower,
            stored.n_own,
            static_cast<int>(end - stored.first_column),
            stored.first_entry};
  }

  int n_rows() const { return number_of_rows; }
  std::size_t n_entries() const { return number_of_entries; }
  std::size_t memory_consumption() const;

private:
  struct Stored
  {
    std::size_t first_column, first_entry;
    int first_row, n_lower, n_own;
  };
  std::vector<Stored> groups;
  std::vector<int> columns;
  int number_of_rows = 0;
  std::size_t number_of_entries = 0;
};

/// A matrix in single precision. The largest size of an entry is the unit of the others, as single precision
/// may not hold it. Products are summed in double precision.
class CompactMatrix
{
public:
  explicit CompactMatrix(const Epetra_CrsMatrix &A);
  /// In place of @p A, whose rows give back their memory as soon as they have been read.
  explicit CompactMatrix(std::unique_ptr<Epetra_CrsMatrix> A);

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
  std::vector<float> values;
  double unit = 0;
};

} // namespace dovetail
