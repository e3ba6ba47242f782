// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "level_operator.h"

#include <EpetraExt_MatrixMatrix.h>
#include <EpetraExt_Transpose_RowMatrix.h>
#include <Epetra_Import.h>
#include <Epetra_IntVector.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace dovetail {

namespace {

/// P^T AP
std::unique_ptr<Epetra_CrsMatrix> transposed_product(const Epetra_CrsMatrix &P, const Epetra_CrsMatrix &AP)
{
  EpetraExt::RowMatrix_Transpose transposer;
  const auto &transposed = dynamic_cast<Epetra_CrsMatrix &>(transposer(const_cast<Epetra_CrsMatrix &>(P)));
  auto result = std::make_unique<Epetra_CrsMatrix>(Copy, P.DomainMap(), 0);
  EpetraExt::MatrixMatrix::Multiply(transposed, false, AP, false, *result, false);
  result->FillComplete(P.DomainMap(), P.DomainMap());
  return result;
}

Epetra_CrsMatrix product(const Epetra_CrsMatrix &A, const Epetra_CrsMatrix &P)
{
  Epetra_CrsMatrix AP(Copy, A.RowMap(), 0);
  EpetraExt::MatrixMatrix::Multiply(A, false, P, false, AP, false);
  AP.FillComplete(P.DomainMap(), A.RangeMap());
  return AP;
}

} // namespace

void LevelEntries::vmult(Epetra_Vector &y, const Epetra_Vector &x) const
{
  if (compact)
    compact->multiply(y, x);
  else
    A->Multiply(false, x, y);
}

Epetra_MultiVector at_columns(const Epetra_CrsMatrix &A, const Epetra_MultiVector &of_rows)
{
  Epetra_MultiVector result(A.ColMap(), of_rows.NumVectors());
  if (A.Importer() == nullptr)
    result = of_rows;
  else
    result.Import(of_rows, *A.Importer(), Insert);
  return result;
}

Epetra_Vector at_columns(const Epetra_CrsMatrix &A, const Epetra_Vector &of_rows)
{
  return Epetra_Vector(Copy, at_columns(A, static_cast<const Epetra_MultiVector &>(of_rows)), 0);
}

std::vector<int> columns_of_rows(const Epetra_CrsMatrix &A)
{
  std::vector<int> result(A.NumMyRows(), -1);
  if (A.Importer() == nullptr)
    std::iota(result.begin(), result.end(), 0);
  else // LCID of each row would take longer
    for (int column = 0; column < A.NumMyCols(); ++column)
      if (const int row = A.LRID(A.GCID(column)); row >= 0)
        result[row] = column;
  return result;
}

void LevelEntries::diagonal(Epetra_Vector &values) const
{
  int *begin = nullptr, *columns = nullptr;
  double *entries = nullptr;
  if (compact)
    compact->diagonal(values);
  else if (A->ExtractCrsDataPointers(begin, columns, entries) != 0)
    A->ExtractDiagonalCopy(values);
  else { // in ascending order
    const std::vector<int> column_of_row = columns_of_rows(*A);
    for (int row = 0; row < values.MyLength(); ++row) {
      const int *const first = columns + begin[row], *const end = columns + begin[row + 1],
                       *const found = std::lower_bound(first, end, column_of_row[row]);
      values[row] = found != end && *found == column_of_row[row] ? entries[found - columns] : 0;
    }
  }
}

/// Not by ML's Epetra_PtAP (Trilinos 13.2), which errs where P has columns of other ranks.
std::unique_ptr<Epetra_CrsMatrix> restrict_matrix(const Epetra_CrsMatrix &A, const Epetra_CrsMatrix &P)
{
  return transposed_product(P, product(A, P));
}

std::unique_ptr<Epetra_CrsMatrix> MatrixLevel::restricted(const Prolongation &P) const
{
  return restrict_matrix(A, *P.matrix());
}

std::unique_ptr<Epetra_CrsMatrix> restrict_few_rows(const Epetra_CrsMatrix &S, const Prolongation &P)
{
  std::vector<int> rows, columns;
  std::vector<double> entries;
  Prolongation::Rows rows_of_P(P);
  const auto read_row = [&](const int row) {
    int n = 0, *local = nullptr;
    double *values = nullptr;
    S.ExtractMyRowView(row, n, values, local);
    columns.clear();
    entries.clear();
    for (int k = 0; k < n; ++k)
      if (values[k] != 0) {
        columns.push_back(S.GCID(local[k]));
        entries.push_back(values[k]);
      }
  };
  for (int row = 0; row < S.NumMyRows(); ++row) {
    read_row(row);
    const bool is_coupled =
        std::any_of(columns.begin(), columns.end(), [&](const int column) { return column != S.GRID(row); });
    if (is_coupled || (!columns.empty() && rows_of_P[row].n > 0)) // an unknown may have no entry in P
      rows.push_back(row);
  }
  const int n_rows = rows.size();
  std::vector<int> global_rows;
  for (const int row : rows)
    global_rows.push_back(S.GRID(row));
  const Epetra_Map map(-1, n_rows, global_rows.data(), 0, S.Comm());
  if (map.NumGlobalElements() == 0) {
    auto nothing = std::make_unique<Epetra_CrsMatrix>(Copy, P.domain(), 0);
    nothing->FillComplete();
    return nothing;
  }
  Epetra_CrsMatrix few_of_S(Copy, map, 0), few_of_P(Copy, map, 0);
  for (const int row : rows) {
    read_row(row);
    few_of_S.InsertGlobalValues(S.GRID(row), columns.size(), entries.data(), columns.data());
    const Prolongation::Row row_of_P = rows_of_P[row];
    columns.clear();
    for (int k = 0; k < row_of_P.n; ++k)
      columns.push_back(P.columns().global(row_of_P.columns[k]));
    few_of_P.InsertGlobalValues(S.GRID(row), row_of_P.n, row_of_P.weights, columns.data());
  }
  few_of_S.FillComplete(map, map);
  few_of_P.FillComplete(P.domain(), map);
  return restrict_matrix(few_of_S, few_of_P);
}

void AugmentedLevel::vmult(Epetra_Vector &y, const Epetra_Vector &x) const
{
  MatrixLevel::vmult(y, x);
  add_product(R, x, y);
}

void AugmentedLevel::diagonal(Epetra_Vector &values) const
{
  MatrixLevel::diagonal(values);
  add_diagonal(R, values);
}

std::unique_ptr<Epetra_CrsMatrix> AugmentedLevel::restricted(const Prolongation &P) const
{
  return with_added_rows(*MatrixLevel::restricted(P), product(R, *P.matrix()));
}

std::unique_ptr<Epetra_CrsMatrix> product_with_transposed(const Epetra_CrsMatrix &R)
{
  EpetraExt::RowMatrix_Transpose transposer; // mult_A_Btrans compares all rows with all others
  const auto &transposed = dynamic_cast<Epetra_CrsMatrix &>(transposer(const_cast<Epetra_CrsMatrix &>(R)));
  return std::make_unique<Epetra_CrsMatrix>(product(R, transposed));
}

std::unique_ptr<Epetra_CrsMatrix> with_added_rows(const Epetra_CrsMatrix &A, const Epetra_CrsMatrix &R)
{
  const auto of_R = transposed_product(R, R);
  Epetra_CrsMatrix *sum = nullptr;
  EpetraExt::MatrixMatrix::Add(A, false, 1., *of_R, false, 1., sum);
  std::unique_ptr<Epetra_CrsMatrix> result(sum);
  result->FillComplete(A.OperatorDomainMap(), A.OperatorRangeMap());
  return result;
}

void add_product(const Epetra_CrsMatrix &R, const Epetra_Vector &x, Epetra_Vector &y)
{
  Epetra_Vector Rx(R.RangeMap(), false), product(R.DomainMap(), false);
  R.Multiply(false, x, Rx);
  R.Multiply(true, Rx, product);
  y.Update(1., product, 1.);
}

void add_diagonal(const Epetra_CrsMatrix &R, Epetra_Vector &values)
{
  Epetra_Vector squares(R.ColMap()), sums(R.DomainMap());
  for (int row = 0; row < R.NumMyRows(); ++row) {
    int n = 0, *columns = nullptr;
    double *entries = nullptr;
    R.ExtractMyRowView(row, n, entries, columns);
    for (int k = 0; k < n; ++k)
      squares[columns[k]] += entries[k] * entries[k];
  }
  sums.Export(squares, Epetra_Import(R.ColMap(), R.DomainMap()), Add);
  values.Update(1., sums, 1.);
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

namespace {

/// The rows of unknowns that follow others are empty, and get what they had before.
Epetra_CrsMatrix with_condensed_rows(const PartOperator &cells, const Epetra_CrsMatrix &entries)
{
  const Epetra_Map &map = entries.OperatorDomainMap();
  Epetra_Vector diagonal(map);
  cells.add_uncondensed_diagonal(diagonal);
  Epetra_CrsMatrix result(Copy, map, 0);
  for (int row = 0; row < entries.NumMyRows(); ++row) {
    const int itself = map.GID(row);
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    entries.ExtractMyRowView(row, n, values, columns);
    const bool is_empty = std::all_of(values, values + n, [](const double value) { return value == 0; });
    if (is_empty && cells.condensed()[row])
      result.InsertGlobalValues(itself, 1, &diagonal[row], &itself);
    for (int k = 0; k < n; ++k)
      if (values[k] != 0) {
        const int column = entries.GCID(columns[k]);
        result.InsertGlobalValues(itself, 1, &values[k], &column);
      }
  }
  result.FillComplete(map, map);
  return result;
}

} // namespace

std::unique_ptr<Epetra_CrsMatrix> make_matrix(const PartOperator &cells, const Epetra_CrsMatrix &entries)
{
  const Epetra_Map &map = entries.OperatorDomainMap();
  const Prolongation identity(map, map,
                              [&map](const int row, std::vector<int> &columns, std::vector<double> &weights) {
                                columns.assign(1, map.GID(row));
                                weights.assign(1, 1.);
                              });
  return cells.restricted(identity, with_condensed_rows(cells, entries));
}

} // namespace dovetail
