// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The prolongation between two degrees, in little memory.

#pragma once

#include "compact_matrix.h"

#include <Epetra_CrsMatrix.h>
#include <Epetra_Vector.h>

#include <cstddef>
#include <vector>

namespace dovetail {

/// A matrix P of weights in single precision. The components at a node are interpolated alike: rows that
/// follow each other with the same weights, and columns that are one further from row to row, hold both once.
class Prolongation
{
public:
  explicit Prolongation(const Epetra_CrsMatrix &P);

  const Epetra_Map &domain() const { return exchange.own(); }
  void multiply(Epetra_Vector &y, const Epetra_Vector &x) const;            ///< y = P x; collective
  void multiply_transposed(Epetra_Vector &y, const Epetra_Vector &x) const; ///< y = P^T x; collective

  std::size_t memory_consumption() const; ///< in bytes

private:
  struct Entry
  {
    int column; ///< of the first row
    float weight;
  };
  struct Group
  {
    unsigned int first_entry;
    int first_row;
  };
  /// Calls @p visit(row, shift of the columns, first entry, last entry) for the own rows.
  template <typename Visit>
  void for_rows(const Visit &visit) const;

  ColumnExchange exchange;
  std::vector<Group> groups; ///< and one at the end
  std::vector<Entry> entries;
};

} // namespace dovetail
