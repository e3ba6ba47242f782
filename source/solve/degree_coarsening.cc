// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "degree_coarsening.h"
#include "free_memory.h"
#include "semicoarsening.h"

#include <EpetraExt_MatrixMatrix.h>
#include <Epetra_CrsGraph.h>
#include <Epetra_Import.h>
#include <Epetra_IntVector.h>
#include <Epetra_Map.h>

#include <map>

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

DegreeCoarsening::DegreeCoarsening(const LevelOperator &A, Sums &&sums, const MakeModes &make_modes,
                                   const GroupFacts &facts, std::unique_ptr<Smoother> given_smoother,
                                   const MakeCoarse &make_coarse)
    : A(A), smoother(std::move(given_smoother))
{
  give_back_freed_memory();
  auto P = make_prolongation(std::move(sums));
  if (P->NumGlobalCols() == 0) // all vertices are prescribed
    return;
  const Epetra_MultiVector coarse_modes = [&]() {
    const Modes modes = make_modes();
    Epetra_MultiVector result(P->DomainMap(), modes->NumVectors());
    for (unsigned int i = 0; i < coarse_rows.size(); ++i)
      for (int mode = 0; mode < modes->NumVectors(); ++mode)
        result[mode][i] = (*modes)[mode][coarse_rows[i]];
    return result;
  }();
  std::vector<GroupFacts::Place> coarse_places;
  if (const std::vector<GroupFacts::Place> places = facts.known_places(); !places.empty()) {
    coarse_places.reserve(coarse_rows.size());
    for (const int row : coarse_rows)
      coarse_places.push_back(places[row]);
  }
  coarse_rows = std::vector<int>(); // = {} would keep the memory
  give_back_freed_memory();
  auto A_1 = A.restricted(*P);
  prolongation = std::make_unique<Prolongation>(*P);
  P.reset();
  give_back_freed_memory();
  coarse = make_coarse(std::move(A_1), coarse_modes, coarse_places);
}

std::unique_ptr<Cycle> DegreeCoarsening::make_usual_coarse(Cycle::Finest A_1, const Epetra_MultiVector &modes,
                                                           const std::vector<GroupFacts::Place> &places)
{
  return make_cycle(std::move(A_1), modes, places, Semicoarsen::if_cheap, [](const auto &level, double) {
    return ChebyshevSmoother::with_factorisation(level, {4, 40}); // costs little beside the rows of A
  });
}

/// What functions of degree one leave reaches the further down the higher the degree is.
std::unique_ptr<ChebyshevSmoother> DegreeCoarsening::usual_smoother(const LevelOperator &A,
                                                                    const unsigned int degree)
{
  return ChebyshevSmoother::with_diagonal(A, {degree + 1, 12.5 * degree - 10});
}

namespace {

/// Replaces sums of own rows that are sums themselves.
class OwnSums
{
public:
  OwnSums(DegreeCoarsening::Sums &sums, const Epetra_Map &rows) : sums(sums), rows(rows), is_done(sums.size())
  {
    for (unsigned int row = 0; row < sums.size(); ++row)
      expand(row);
  }

private:
  void expand(int row);

  DegreeCoarsening::Sums &sums;
  const Epetra_Map &rows;
  std::vector<bool> is_done;
};

bool is_itself(const DegreeCoarsening::Sums &sums, const int row, const int global_row)
{
  return sums[row].size() == 1 && sums[row][0].first == global_row;
}

void OwnSums::expand(const int row)
{
  if (is_done[row] || is_itself(sums, row, rows.GID(row)))
    return;
  is_done[row] = true;
  bool is_final = true;
  for (const auto &[column, weight] : sums[row])
    if (const int own = rows.LID(column); own >= 0 && !is_itself(sums, own, column)) {
      expand(own);
      is_final = false;
    }
  if (is_final)
    return;
  std::map<int, double> sum;
  for (const auto &[column, weight] : sums[row]) {
    const int own = rows.LID(column);
    if (own < 0)
      sum[column] += weight;
    else
      for (const auto &[other, its_weight] : sums[own])
        sum[other] += weight * its_weight;
  }
  sums[row].assign(sum.begin(), sum.end());
}

} // namespace

/// The sums of @p sums, sums of sums, … until only unknowns of the coarse matrix are left.
std::unique_ptr<Epetra_CrsMatrix> DegreeCoarsening::follow(Sums &&given_sums) const
{
  Sums sums = std::move(given_sums);
  OwnSums(sums, A.rows());
  Epetra_IntVector kind(A.rows());
  std::vector<int> lengths, columns;
  std::vector<double> weights;
  for (const auto &sum : sums)
    lengths.push_back(sum.size());
  auto result = std::make_unique<Epetra_CrsMatrix>(Copy, A.rows(), lengths.data(), true);
  for (unsigned int row = 0; row < sums.size(); ++row) {
    columns.clear();
    weights.clear();
    for (const auto &[column, weight] : sums[row]) {
      columns.push_back(column);
      weights.push_back(weight);
    }
    const int own = A.rows().GID(row);
    kind[row] = columns.empty() ? is_fixed : is_itself(sums, row, own) ? 0 : is_sum;
    result->InsertGlobalValues(own, columns.size(), weights.data(), columns.data());
    sums[row] = GroupFacts::Sum(); // = {} would keep the memory
  }
  result->FillComplete(A.rows(), A.rows());

  const unsigned int longest_chain = 4; // number of squares: 16 steps from rank to rank
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

namespace {

/// A matrix whose rows are given: read(row, columns, weights). Of its graph, so that weights are held once.
template <typename Read>
std::unique_ptr<Epetra_CrsMatrix> matrix_of_rows(const Epetra_Map &rows, const Epetra_Map &coarse,
                                                 const Read &read)
{
  std::vector<int> lengths, columns;
  std::vector<double> weights;
  for (int row = 0; row < rows.NumMyElements(); ++row) {
    read(row, columns, weights);
    lengths.push_back(columns.size());
  }
  Epetra_CrsGraph graph(Copy, rows, lengths.data(), true);
  for (int row = 0; row < rows.NumMyElements(); ++row) {
    read(row, columns, weights);
    graph.InsertGlobalIndices(rows.GID(row), columns.size(), columns.data());
  }
  graph.FillComplete(coarse, rows);
  graph.OptimizeStorage();
  auto result = std::make_unique<Epetra_CrsMatrix>(Copy, graph);
  for (int row = 0; row < rows.NumMyElements(); ++row) {
    read(row, columns, weights);
    result->SumIntoGlobalValues(rows.GID(row), columns.size(), weights.data(), columns.data());
  }
  result->FillComplete(coarse, rows);
  return result;
}

} // namespace

/// P.
std::unique_ptr<Epetra_CrsMatrix> DegreeCoarsening::make_prolongation(Sums &&given_sums)
{
  Sums sums = std::move(given_sums);
  for (unsigned int row = 0; row < sums.size(); ++row)
    if (is_itself(sums, row, A.rows().GID(row)))
      coarse_rows.push_back(row);
  const Epetra_Map coarse(-1, static_cast<int>(coarse_rows.size()), 0, A.rows().Comm());
  Epetra_IntVector number(A.rows());
  number.PutValue(is_fixed);
  for (unsigned int i = 0; i < coarse_rows.size(); ++i)
    number[coarse_rows[i]] = coarse.GID(i);

  // a condensed unknown is alone in its row of the matrix, and found afterwards from those it follows
  if (A.rows().Comm().NumProc() == 1) {
    OwnSums(sums, A.rows());
    return matrix_of_rows(A.rows(), coarse, [&](const int row, auto &columns, auto &weights) {
      columns.clear();
      weights.clear();
      for (const auto &[column, weight] : sums[row])
        if (!A.is_condensed(row) && number[A.rows().LID(column)] != is_fixed && weight != 0) {
          columns.push_back(number[A.rows().LID(column)]);
          weights.push_back(weight);
        }
    });
  }
  const auto all = follow(std::move(sums));
  const Epetra_IntVector column_number = column_values(*all, number);
  return matrix_of_rows(A.rows(), coarse, [&](const int row, auto &columns, auto &weights) {
    int n = 0, *local = nullptr;
    double *values = nullptr;
    all->ExtractMyRowView(row, n, values, local);
    columns.clear();
    weights.clear();
    for (int k = 0; k < n && !A.is_condensed(row); ++k)
      if (column_number[local[k]] != is_fixed && values[k] != 0) {
        columns.push_back(column_number[local[k]]);
        weights.push_back(values[k]);
      }
  });
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
  Epetra_Vector residual(A.rows(), false), coarse_b(prolongation->domain(), false),
      coarse_x(prolongation->domain());
  A.vmult(residual, x);
  residual.Update(1., b, -1.);
  prolongation->multiply_transposed(coarse_b, residual);
  coarse->vmult(coarse_x, coarse_b);
  prolongation->multiply(residual, coarse_x);
  x.Update(1., residual, 1.);
}

} // namespace dovetail
