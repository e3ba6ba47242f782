// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "degree_coarsening.h"
#include "semicoarsening.h"

#include <EpetraExt_MatrixMatrix.h>
#include <Epetra_Import.h>
#include <Epetra_IntVector.h>
#include <Epetra_Map.h>

namespace dovetail {

namespace {

/// What a row is: the number of an unknown of the coarse matrix, or
enum Kind { is_fixed = -1, is_sum = -2 };

/// The kinds of the rows that the columns of @p matrix, which is filled, refer to.
Epetra_IntVector column_values(const Epetra_CrsMatrix &matrix, const Epetra_IntVector &row_values)
{
  Epetra_IntVector result(matrix.ColMap());
  const Epetra_Import import(matrix.ColMap(), row_values.Map());
  result.Import(row_values, import, Insert);
  return result;
}

bool on_any_rank(const Epetra_Comm &communicator, const bool here)
{
  int mine = here, anyone = 0;
  communicator.MaxAll(&mine, &anyone, 1);
  return anyone != 0;
}

} // namespace

DegreeCoarsening::DegreeCoarsening(const LevelOperator &A, const Sums &sums, const Epetra_MultiVector &modes,
                                   const std::vector<GroupFacts::Place> &places,
                                   std::unique_ptr<Smoother> given_smoother, const MakeCoarse &make_coarse)
    : A(A), smoother(std::move(given_smoother))
{
  make_prolongation(sums);
  if (prolongation->NumGlobalCols() == 0) // all vertices are prescribed
    return;
  coarse_matrix = A.restricted(*prolongation);

  const Epetra_Map &coarse_rows = coarse_matrix->OperatorDomainMap();
  coarse_modes = std::make_unique<Epetra_MultiVector>(coarse_rows, modes.NumVectors());
  std::vector<GroupFacts::Place> coarse_places;
  unsigned int next = 0;
  for (unsigned int row = 0; row < sums.size(); ++row)
    if (sums[row].size() == 1 && sums[row][0].first == A.rows().GID(row)) {
      for (int mode = 0; mode < modes.NumVectors(); ++mode)
        (*coarse_modes)[mode][next] = modes[mode][row];
      if (!places.empty())
        coarse_places.push_back(places[row]);
      ++next;
    }
  coarse = make_coarse(*coarse_matrix, *coarse_modes, coarse_places);
}

std::unique_ptr<Cycle> DegreeCoarsening::make_usual_coarse(const Epetra_CrsMatrix &A_1,
                                                           const Epetra_MultiVector &modes,
                                                           const std::vector<GroupFacts::Place> &places)
{
  return make_cycle(A_1, modes, places, Semicoarsen::if_cheap, [](const auto &level) {
    return ChebyshevSmoother::with_factorisation(level, {6, 80}); // costs little beside the rows of A
  });
}

/// What functions of degree one leave reaches the further down the higher the degree is.
std::unique_ptr<ChebyshevSmoother> DegreeCoarsening::usual_smoother(const LevelOperator &A,
                                                                    const unsigned int degree)
{
  return ChebyshevSmoother::with_diagonal(A, {degree + 1, 12.5 * degree - 10});
}

/// The sums of @p sums, sums of sums, … until only unknowns of the coarse matrix are left.
std::unique_ptr<Epetra_CrsMatrix> DegreeCoarsening::follow(const Sums &sums) const
{
  auto result = std::make_unique<Epetra_CrsMatrix>(Copy, A.rows(), 0);
  Epetra_IntVector kind(A.rows());
  std::vector<int> columns;
  std::vector<double> weights;
  for (unsigned int row = 0; row < sums.size(); ++row) {
    columns.clear();
    weights.clear();
    for (const auto &[column, weight] : sums[row]) {
      columns.push_back(column);
      weights.push_back(weight);
    }
    const int own = A.rows().GID(row);
    kind[row] = columns.empty() ? is_fixed : columns.size() == 1 && columns[0] == own ? 0 : is_sum;
    result->InsertGlobalValues(own, columns.size(), weights.data(), columns.data());
  }
  result->FillComplete(A.rows(), A.rows());

  const unsigned int longest_chain = 4; // number of squares: 16 steps
  for (unsigned int i = 0; i < longest_chain; ++i) {
    const Epetra_IntVector column_kind = column_values(*result, kind);
    bool has_sums = false;
    for (int column = 0; column < column_kind.MyLength(); ++column)
      has_sums = has_sums || column_kind[column] == is_sum;
    if (!on_any_rank(A.rows().Comm(), has_sums))
      break;
    auto square = std::make_unique<Epetra_CrsMatrix>(Copy, A.rows(), 0);
    EpetraExt::MatrixMatrix::Multiply(*result, false, *result, false, *square);
    result = std::move(square);
  }
  return result;
}

void DegreeCoarsening::make_prolongation(const Sums &sums)
{
  const auto all = follow(sums);
  Epetra_IntVector number(A.rows());
  int n_own = 0, n_before = 0;
  for (unsigned int row = 0; row < sums.size(); ++row)
    if (sums[row].size() == 1 && sums[row][0].first == A.rows().GID(row))
      ++n_own;
  A.rows().Comm().ScanSum(&n_own, &n_before, 1);
  n_before -= n_own;
  for (unsigned int row = 0; row < sums.size(); ++row)
    number[row] = sums[row].size() == 1 && sums[row][0].first == A.rows().GID(row) ? n_before++ : is_fixed;

  // a condensed unknown is alone in its row of the matrix, and found afterwards from those it follows
  const Epetra_IntVector column_kind = column_values(*all, number);
  const Epetra_Map coarse(-1, n_own, 0, A.rows().Comm());
  prolongation = std::make_unique<Epetra_CrsMatrix>(Copy, A.rows(), all->MaxNumEntries());
  std::vector<int> columns;
  std::vector<double> weights;
  for (unsigned int row = 0; row < sums.size(); ++row) {
    int n = 0, *local = nullptr;
    double *values = nullptr;
    all->ExtractMyRowView(row, n, values, local);
    columns.clear();
    weights.clear();
    for (int k = 0; k < n; ++k)
      if (column_kind[local[k]] != is_fixed && values[k] != 0 && !A.is_condensed(row)) {
        columns.push_back(column_kind[local[k]]);
        weights.push_back(values[k]);
      }
    prolongation->InsertGlobalValues(A.rows().GID(row), columns.size(), weights.data(), columns.data());
  }
  prolongation->FillComplete(coarse, A.rows());
}

void DegreeCoarsening::vmult(Epetra_Vector &x, const Epetra_Vector &b) const
{
  smoother->smooth(x.Values(), b.Values(), true);
  if (coarse)
    correct(x, b);
  smoother->smooth(x.Values(), b.Values(), false);
}

/// By the functions of degree one.
void DegreeCoarsening::correct(Epetra_Vector &x, const Epetra_Vector &b) const
{
  Epetra_Vector residual(A.rows(), false), correction(A.rows(), false);
  A.vmult(residual, x);
  residual.Update(1., b, -1.);
  Epetra_Vector coarse_b(prolongation->DomainMap()), coarse_x(prolongation->DomainMap());
  prolongation->Multiply(true, residual, coarse_b);
  coarse->vmult(coarse_x, coarse_b);
  prolongation->Multiply(false, coarse_x, correction);
  x.Update(1., correction, 1.);
}

} // namespace dovetail
