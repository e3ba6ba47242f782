// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The prolongation from aggregates, and the matrix of the coarser level.

#pragma once

#include "aggregation.h"
#include "cycle.h"

#include <deal.II/base/exceptions.h>

#include <Epetra_CrsMatrix.h>

#include <memory>

namespace dovetail {

/// The entries of a row.
struct SparseRow
{
  int n = 0;
  const int *columns = nullptr;
  const double *values = nullptr;
};

/// Of a matrix that is complete, or of what has its rows.
class SparseRows
{
public:
  explicit SparseRows(const Epetra_CrsMatrix &A)
  {
    int *first = nullptr, *all_columns = nullptr;
    double *all_values = nullptr;
    const int error = A.ExtractCrsDataPointers(first, all_columns, all_values);
    AssertThrow(error == 0, dealii::ExcMessage("The rows of a matrix do not follow each other in memory."));
    begin = first;
    columns = all_columns;
    values = all_values;
  }

  SparseRows(const int *begin, const int *columns, const double *values)
      : begin(begin), columns(columns), values(values)
  {
  }

  SparseRow operator[](const int row) const
  {
    return {begin[row + 1] - begin[row], columns + begin[row], values + begin[row]};
  }

private:
  const int *begin = nullptr, *columns = nullptr;
  const double *values = nullptr;
};

/// (I - w D^-1 A_near) T, where T are the bases of @p aggregates and D = diag(A). Each row of the result has
/// whole blocks of as many columns as there are modes.
/// @param near the rows of A_near, whose columns are those of A. Collective.
std::unique_ptr<Epetra_CrsMatrix> smooth_bases(const Epetra_CrsMatrix &A, const SparseRows &near,
                                               const Aggregation &aggregates, double w);

/// Sums P^T A P now, and makes the matrix when neither A nor P is needed any more. A P is never stored, which
/// would need more memory than A. Collective.
/// @param block_length of the rows of P
Cycle::MakeMatrix sum_coarse_matrix(const Epetra_CrsMatrix &A, const Epetra_CrsMatrix &P, int block_length);

} // namespace dovetail
