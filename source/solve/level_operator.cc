// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "level_operator.h"

#include <EpetraExt_MatrixMatrix.h>
#include <EpetraExt_Transpose_RowMatrix.h>
#include <Epetra_Import.h>
#include <Epetra_IntVector.h>

#include <cmath>
#include <limits>
#include <vector>

namespace dovetail {

/// Not by ML's Epetra_PtAP (Trilinos 13.2), which errs where P has columns of other ranks.
std::unique_ptr<Epetra_CrsMatrix> MatrixLevel::restricted(const Epetra_CrsMatrix &P) const
{
  Epetra_CrsMatrix AP(Copy, A.RowMap(), 0);
  EpetraExt::MatrixMatrix::Multiply(A, false, P, false, AP, false);
  AP.FillComplete(P.DomainMap(), A.RangeMap());
  EpetraExt::RowMatrix_Transpose transposer;
  const auto &transposed = dynamic_cast<Epetra_CrsMatrix &>(transposer(const_cast<Epetra_CrsMatrix &>(P)));
  auto result = std::make_unique<Epetra_CrsMatrix>(Copy, P.DomainMap(), 0);
  EpetraExt::MatrixMatrix::Multiply(transposed, false, AP, false, *result, false);
  result->FillComplete(P.DomainMap(), P.DomainMap());
  return result;
}

std::unique_ptr<Epetra_CrsMatrix> make_symmetric_part(const Epetra_CrsMatrix &A,
                                                      const std::vector<int> &field_of_row)
{
  EpetraExt::RowMatrix_Transpose transposer;
  const auto &transposed = dynamic_cast<Epetra_CrsMatrix &>(transposer(const_cast<Epetra_CrsMatrix &>(A)));
  const Epetra_IntVector row_field(Copy, A.RowMap(), const_cast<int *>(field_of_row.data()));
  Epetra_IntVector column_field(A.ColMap());
  column_field.Import(row_field, Epetra_Import(A.ColMap(), A.RowMap()), Insert);

  auto sum = std::make_unique<Epetra_CrsMatrix>(Copy, A.Graph()); // the same graph, held once
  std::vector<double> partner(A.NumMyCols());                     // by column, of one row; NaN: none
  for (int row = 0; row < A.NumMyRows(); ++row) {
    int n = 0, n_transposed = 0, *columns = nullptr, *transposed_columns = nullptr;
    double *values = nullptr, *transposed_values = nullptr, *result = nullptr;
    A.ExtractMyRowView(row, n, values, columns);
    transposed.ExtractMyRowView(row, n_transposed, transposed_values, transposed_columns);
    sum->ExtractMyRowView(row, n, result);
    for (int k = 0; k < n; ++k)
      partner[columns[k]] = std::numeric_limits<double>::quiet_NaN();
    for (int k = 0; k < n_transposed; ++k)
      if (const int column = A.LCID(transposed.GCID(transposed_columns[k])); column >= 0)
        partner[column] = transposed_values[k];
    for (int k = 0; k < n; ++k) {
      const bool is_left_out = std::isnan(partner[columns[k]]) || column_field[columns[k]] != row_field[row];
      result[k] = is_left_out ? 0 : (values[k] + partner[columns[k]]) / 2;
    }
  }
  return sum;
}

} // namespace dovetail
