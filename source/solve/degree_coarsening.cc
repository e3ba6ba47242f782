// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "degree_coarsening.h"
#include "semicoarsening.h"

#include <dovetail/solve/free_memory.h>

#include <EpetraExt_MatrixMatrix.h>
#include <Epetra_Import.h>
#include <Epetra_IntVector.h>
#include <Epetra_Map.h>

#include <algorithm>
#include <map>
#include <unordered_map>
#include <vector>

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

DegreeCoarsening::DegreeCoarsening(const LevelOperator &A, RowSums &&sums, const MakeModes &make_modes,
                                   const GroupFacts &facts, std::unique_ptr<Smoother> given_smoother,
                                   const MakeCoarse &make_coarse)
    : A(A), smoother(std::move(given_smoother))
{
  give_back_freed_memory();
  prolongation = make_prolongation(std::move(sums));
  if (prolongation->domain().NumGlobalElements() == 0) // all vertices are prescribed
    return;
  auto modes = make_modes(prolongation->domain(), &coarse_rows);
  std::vector<GroupFacts::Place> places = facts.known_places(&coarse_rows);
  coarse_rows = Selection(); // = {} would keep the memory
  give_back_freed_memory();
  auto A_1 = A.restricted(*prolongation);
  give_back_freed_memory();
  coarse = make_coarse(std::move(A_1), std::move(modes), std::move(places));
}

std::unique_ptr<Epetra_MultiVector> DegreeCoarsening::select(const Epetra_MultiVector &modes,
                                                             const Epetra_Map &map, const Selection &rows)
{
  auto result = std::make_unique<Epetra_MultiVector>(map, modes.NumVectors());
  for (unsigned int i = 0; i < rows.size(); ++i)
    for (int mode = 0; mode < modes.NumVectors(); ++mode)
      (*result)[mode][i] = modes[mode][rows[i]];
  return result;
}

std::unique_ptr<Cycle> DegreeCoarsening::make_usual_coarse(Cycle::Finest A_1,
                                                           std::shared_ptr<const Epetra_MultiVector> modes,
                                                           std::vector<GroupFacts::Place> places)
{
  return make_cycle_with_factorisations(std::move(A_1), std::move(modes), std::move(places),
                                        Semicoarsen::if_cheap, false); // costs little beside the rows of A
}

/// What functions of degree one leave reaches the further down the higher the degree is. Solves in cells see
/// all functions of the degree.
std::unique_ptr<ChebyshevSmoother> DegreeCoarsening::usual_smoother(const LevelOperator &A,
                                                                    const unsigned int degree)
{
  if (auto M = A.approximation())
    return ChebyshevSmoother::with_approximation(A, std::move(M), {std::max(3u, degree), 7. * degree + 1});
  return ChebyshevSmoother::with_diagonal(A, {degree + 1, 12.5 * degree - 10});
}

namespace {

/// The sums of own rows, in which own rows that are sums themselves are replaced. Those of this kind are
/// remembered.
class OwnSums
{
public:
  OwnSums(const RowSums &sums, const Epetra_Map &rows) : sums(sums), rows(rows), is_done(sums.size()) {}
  /// Until the next call.
  const GroupFacts::Sum &operator[](int row);

private:
  bool is_itself(const int row, const int global_row) const { return sums.is_only(row, global_row); }
  void expand(int row);
  template <typename Visit>
  void for_sum(int row, const Visit &visit) const;

  const RowSums &sums;
  const Epetra_Map &rows;
  std::vector<bool> is_done;
  std::unordered_map<int, GroupFacts::Sum> replaced;
  GroupFacts::Sum result;
};

const GroupFacts::Sum &OwnSums::operator[](const int row)
{
  expand(row);
  result.clear();
  for_sum(row, [this](const int column, const double weight) { result.emplace_back(column, weight); });
  return result;
}

template <typename Visit>
void OwnSums::for_sum(const int row, const Visit &visit) const
{
  if (const auto found = replaced.find(row); found != replaced.end()) {
    for (const auto &[column, weight] : found->second)
      visit(column, weight);
    return;
  }
  const RowSums::Row sum = sums[row];
  for (unsigned int k = 0; k < sum.n; ++k)
    visit(static_cast<int>(sum.columns[k]), sum.weights[k]);
}

void OwnSums::expand(const int row)
{
  if (is_done[row] || is_itself(row, rows.GID(row)))
    return;
  is_done[row] = true;
  bool is_final = true;
  const RowSums::Row given = sums[row];
  for (unsigned int k = 0; k < given.n; ++k)
    if (const int column = given.columns[k], own = rows.LID(column); own >= 0 && !is_itself(own, column)) {
      expand(own);
      is_final = false;
    }
  if (is_final)
    return;
  std::map<int, double> sum;
  for (unsigned int k = 0; k < given.n; ++k) {
    const int column = given.columns[k], own = rows.LID(column);
    const double weight = given.weights[k];
    if (own < 0)
      sum[column] += weight;
    else
      for_sum(own, [&](const int other, const double its_weight) { sum[other] += weight * its_weight; });
  }
  replaced[row].assign(sum.begin(), sum.end());
}

} // namespace

/// The sums of @p sums, sums of sums, … until only unknowns of the coarse matrix are left.
std::unique_ptr<Epetra_CrsMatrix> DegreeCoarsening::follow(RowSums &&given_sums) const
{
  Epetra_IntVector kind(A.rows());
  std::unique_ptr<Epetra_CrsMatrix> result;
  {
    const RowSums sums = std::move(given_sums);
    OwnSums own_sums(sums, A.rows());
    std::vector<int> lengths, columns;
    std::vector<double> weights;
    for (unsigned int row = 0; row < sums.size(); ++row)
      lengths.push_back(own_sums[row].size());
    result = std::make_unique<Epetra_CrsMatrix>(Copy, A.rows(), lengths.data(), true);
    for (unsigned int row = 0; row < sums.size(); ++row) {
      columns.clear();
      weights.clear();
      for (const auto &[column, weight] : own_sums[row]) {
        columns.push_back(column);
        weights.push_back(weight);
      }
      const int own = A.rows().GID(row);
      kind[row] = columns.empty() ? is_fixed : sums.is_only(row, own) ? 0 : is_sum;
      result->InsertGlobalValues(own, columns.size(), weights.data(), columns.data());
    }
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

/// P.
std::unique_ptr<Prolongation> DegreeCoarsening::make_prolongation(RowSums &&given_sums)
{
  RowSums sums = std::move(given_sums);
  for (unsigned int row = 0; row < sums.size(); ++row)
    if (sums.is_only(row, A.rows().GID(row)))
      coarse_rows.push_back(row);
  const Epetra_Map coarse(-1, static_cast<int>(coarse_rows.size()), 0, A.rows().Comm());
  Epetra_IntVector number(A.rows());
  number.PutValue(is_fixed);
  for (unsigned int i = 0; i < coarse_rows.size(); ++i)
    number[coarse_rows[i]] = coarse.GID(i);

  // a condensed unknown is alone in its row of the matrix, and found afterwards from those it follows
  if (A.rows().Comm().NumProc() == 1) {
    OwnSums own_sums(sums, A.rows());
    return std::make_unique<Prolongation>(
        A.rows(), coarse, [&](const int row, std::vector<int> &columns, std::vector<double> &weights) {
          columns.clear();
          weights.clear();
          if (A.is_condensed(row))
            return;
          for (const auto &[column, weight] : own_sums[row])
            if (const int its_number = number[A.rows().LID(column)]; its_number != is_fixed && weight != 0) {
              columns.push_back(its_number);
              weights.push_back(weight);
            }
        });
  }
  const auto all = follow(std::move(sums));
  const Epetra_IntVector column_number = column_values(*all, number);
  return std::make_unique<Prolongation>(
      A.rows(), coarse, [&](const int row, std::vector<int> &columns, std::vector<double> &weights) {
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
