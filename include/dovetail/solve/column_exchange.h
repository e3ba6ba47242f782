// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a sparse matrix needs of the vectors of other ranks.

#pragma once

#include <dovetail/solve/partners.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Map.h>
#include <Epetra_Vector.h>

#include <memory>
#include <vector>

namespace dovetail {

/// The values at the columns of a matrix: own ones, and after them those of other ranks in the order of the
/// column map.
class ColumnExchange
{
public:
  explicit ColumnExchange(const Epetra_CrsMatrix &A);
  /// @param others global numbers of the columns that other ranks own. Collective.
  ColumnExchange(const Epetra_Map &own, const std::vector<int> &others);

  const Epetra_Map &own() const { return own_columns; }
  /// @param buffer is used if other ranks have some. Collective.
  const double *of_columns(const Epetra_Vector &x, std::vector<double> &buffer) const;
  unsigned int n_columns() const;
  int number(int global) const; ///< of a column; -1: none of this rank
  int global(int number) const;
  /// y = the sums of all ranks. @p sums: of this rank, changed. Collective.
  void add_up(std::vector<double> &sums, Epetra_Vector &y) const;

private:
  Epetra_Map own_columns;
  std::shared_ptr<const Epetra_Map> other_columns; ///< nullptr if no rank has any
  MPI_Comm communicator;
  Partners given, taken; ///< among the values at the columns: own ones of others' columns, and others' ones
};

} // namespace dovetail
