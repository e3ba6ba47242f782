// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "followed_sums.h"

#include <EpetraExt_MatrixMatrix.h>
#include <Epetra_Comm.h>
#include <Epetra_Import.h>
#include <Epetra_Map.h>

#include <algorithm>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

namespace dovetail {

namespace {

/// What a row is: one that is not replaced, or
enum RowKind { is_fixed = -1, is_sum = -2 };

using Sum = std::vector<std::pair<int, double>>;

/// What belongs to the rows that the columns of @p matrix, which is filled, refer to.
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

/// The sums of own rows, in which own rows that are sums themselves are replaced. Those of this kind are
/// remembered.
class OwnSums
{
public:
  OwnSums(const RowSums &sums, const Epetra_Map &rows) : sums(sums), rows(rows), is_done(sums.size()) {}
  /// Until the next call.
  const Sum &operator[](int row);

private:
  bool is_itself(const int row, const int global_row) const { return sums.is_only(row, global_row); }
  void expand(int row);
  template <typename Visit>
  void for_sum(int row, const Visit &visit) const;

  const RowSums &sums;
  const Epetra_Map &rows;
  std::vector<bool> is_done;
  std::unordered_map<int, Sum> replaced;
  Sum result;
};

const Sum &OwnSums::operator[](const int row)
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

/// The sums of sums, sums of sums, … until only rows are left that are themselves.
std::unique_ptr<Epetra_CrsMatrix> follow(RowSums &&given_sums, const Epetra_Map &rows, Epetra_IntVector &kind)
{
  std::unique_ptr<Epetra_CrsMatrix> result;
  {
    const RowSums sums = std::move(given_sums);
    OwnSums own_sums(sums, rows);
    std::vector<int> lengths, columns;
    std::vector<double> weights;
    for (unsigned int row = 0; row < sums.size(); ++row)
      lengths.push_back(own_sums[row].size());
    result = std::make_unique<Epetra_CrsMatrix>(Copy, rows, lengths.data(), true);
    for (unsigned int row = 0; row < sums.size(); ++row) {
      columns.clear();
      weights.clear();
      for (const auto &[column, weight] : own_sums[row]) {
        columns.push_back(column);
        weights.push_back(weight);
      }
      const int own = rows.GID(row);
      kind[row] = columns.empty() ? is_fixed : sums.is_only(row, own) ? 0 : is_sum;
      result->InsertGlobalValues(own, columns.size(), weights.data(), columns.data());
    }
  }
  result->FillComplete(rows, rows);

  const unsigned int longest_chain = 4; // number of squares: 16 steps from rank to rank
  for (unsigned int i = 0; i < longest_chain; ++i) {
    const Epetra_IntVector column_kind = column_values(*result, kind);
    const int *const begin = column_kind.Values(), *const end = begin + column_kind.MyLength();
    if (!on_any_rank(rows.Comm(), std::find(begin, end, static_cast<int>(is_sum)) != end))
      break;
    auto square = std::make_unique<Epetra_CrsMatrix>(Copy, rows, 0);
    EpetraExt::MatrixMatrix::Multiply(*result, false, *result, false, *square);
    result = std::move(square);
  }
  return result;
}

} // namespace

/// On one rank, rows are followed when they are read.
class FollowedSums::OnOneRank
{
public:
  OnOneRank(RowSums &&given_sums, const Epetra_Map &rows) : sums(std::move(given_sums)), own(sums, rows) {}

  const RowSums sums;
  OwnSums own;
};

FollowedSums::FollowedSums(RowSums &&sums, const Epetra_Map &rows, const Epetra_IntVector &given_number)
    : number(given_number)
{
  if (rows.Comm().NumProc() == 1) {
    on_one_rank = std::make_unique<OnOneRank>(std::move(sums), rows);
    return;
  }
  Epetra_IntVector kind(rows);
  all = follow(std::move(sums), rows, kind);
  for (int row = 0; row < kind.MyLength(); ++row)
    if (number[row] >= 0 || kind[row] != is_sum)
      kind[row] = number[row];
  number_of_column = std::make_unique<Epetra_IntVector>(column_values(*all, kind));
}

FollowedSums::~FollowedSums() = default;

void FollowedSums::read(const int row, std::vector<int> &columns, std::vector<double> &weights)
{
  columns.clear();
  weights.clear();
  const auto take = [&](const int its_number, const bool is_left_sum, const double weight) {
    has_circle = has_circle || (is_left_sum && weight != 0);
    if (its_number >= 0 && weight != 0) {
      columns.push_back(its_number);
      weights.push_back(weight);
    }
  };
  if (on_one_rank) {
    for (const auto &[column, weight] : on_one_rank->own[row]) {
      const int other = number.Map().LID(column);
      take(number[other], number[other] < 0 && on_one_rank->sums[other].n > 0, weight);
    }
    return;
  }
  int n = 0, *local = nullptr;
  double *values = nullptr;
  all->ExtractMyRowView(row, n, values, local);
  for (int k = 0; k < n; ++k)
    take((*number_of_column)[local[k]], (*number_of_column)[local[k]] == is_sum, values[k]);
}

} // namespace dovetail
