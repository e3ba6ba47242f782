// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The prolongation between two degrees, in little memory.

#pragma once

#include <dovetail/solve/column_exchange.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Map.h>
#include <Epetra_Vector.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

namespace dovetail {

/// A matrix P of weights in single precision, of which most rows have the weights of others. Rows that follow
/// each other with the same weights, and columns that are one further from row to row, as those of the
/// components at a node, are held once. Lists of weights that occur again are held once, too, and those of
/// columns, relative to the first one, if the row before has the same: the nodes inside of a cell are
/// interpolated from the same vertices.
class Prolongation
{
public:
  /// Gives the global columns and the weights of an own row.
  using ReadRow = std::function<void(int row, std::vector<int> &columns, std::vector<double> &weights)>;

  /// Collective. @param domain the columns
  Prolongation(const Epetra_Map &rows, const Epetra_Map &domain, const ReadRow &read);
  explicit Prolongation(const Epetra_CrsMatrix &P);

  const Epetra_Map &rows() const { return range; }
  const Epetra_Map &domain() const { return exchange.own(); }
  const ColumnExchange &columns() const { return exchange; }
  void multiply(Epetra_Vector &y, const Epetra_Vector &x) const;            ///< y = P x; collective
  void multiply_transposed(Epetra_Vector &y, const Epetra_Vector &x) const; ///< y = P^T x; collective

  std::unique_ptr<Epetra_CrsMatrix> matrix() const; ///< collective
  std::size_t memory_consumption() const;           ///< in bytes

  struct Row
  {
    int n;
    const int *columns; ///< numbers of the ColumnExchange
    const double *weights;
  };
  /// Of own rows, in any order.
  class Rows;

private:
  struct Group ///< of rows
  {
    unsigned int offsets, first_weight;
    int first_row, first_column; ///< of the first row
  };
  class Builder;
  /// Calls @p visit(row, first column, number of entries, offsets of the columns, weights) for the own rows.
  template <typename Visit>
  void for_rows(const Visit &visit) const;

  Epetra_Map range;
  ColumnExchange exchange;
  std::vector<Group> groups;
  std::vector<int> offsets; ///< of the columns from the first one; before those of a list, their number
  std::vector<float> weights;
};

class Prolongation::Rows
{
public:
  explicit Rows(const Prolongation &P); ///< by reference
  Row operator[](int row);              ///< until the next call

private:
  const Prolongation &P;
  std::vector<unsigned int> group_of_row;
  std::vector<int> columns;
  std::vector<double> weights;
};

} // namespace dovetail
