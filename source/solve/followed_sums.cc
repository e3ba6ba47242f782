// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "followed_sums.h"

#include <dovetail/solve/rows_of_other_ranks.h>

#include <Epetra_Comm.h>

#include <map>
#include <set>

namespace dovetail {

FollowedSums::FollowedSums(RowSums &&given_sums, const Epetra_Map &rows, const Epetra_IntVector &given_number)
    : rows(rows), sums(std::move(given_sums)),
      number(given_number.Values(), given_number.Values() + given_number.MyLength())
{
  int is_needed = rows.Comm().NumProc() > 1;
  for (unsigned int first_place = 0; is_needed != 0;) {
    const std::vector<int> wanted = unknown_columns(first_place);
    first_place = sums.size();
    int is_here = !wanted.empty();
    rows.Comm().MaxAll(&is_here, &is_needed, 1);
    if (is_needed != 0)
      add_rows_of_others(wanted);
  }
  is_done.assign(sums.size(), false);
}

/// Those of rows from a place on that have no place.
std::vector<int> FollowedSums::unknown_columns(const unsigned int first_place) const
{
  std::set<int> result;
  for (unsigned int i = first_place; i < sums.size(); ++i) {
    const RowSums::Row sum = sums[i];
    for (unsigned int k = 0; k < sum.n; ++k)
      if (const int column = sum.columns[k]; !rows.MyGID(column) && place_of_other.count(column) == 0)
        result.insert(column);
  }
  return {result.begin(), result.end()};
}

void FollowedSums::add_rows_of_others(const std::vector<int> &wanted)
{
  const auto read = [this](const int row, std::vector<int> &columns, std::vector<double> &values) {
    const RowSums::Row sum = sums[row];
    columns.assign(sum.columns, sum.columns + sum.n);
    values.assign(sum.weights, sum.weights + sum.n);
    columns.push_back(number[row]); // behind the row
    values.push_back(0);
  };
  std::vector<std::pair<int, double>> sum;
  unsigned int k = 0;
  for (const RowOfOtherRank &row : rows_of_other_ranks(rows, wanted, read)) {
    const unsigned int n = row.columns.size() - 1;
    sum.clear();
    for (unsigned int i = 0; i < n; ++i)
      sum.emplace_back(row.columns[i], row.values[i]);
    place_of_other.emplace(wanted[k++], sums.size());
    sums.add_row(sum);
    number.push_back(row.columns[n]);
  }
}

int FollowedSums::place(const int global_row) const
{
  const int own = rows.LID(global_row);
  return own >= 0 ? own : place_of_other.at(global_row);
}

template <typename Visit>
void FollowedSums::for_sum(const int place, const Visit &visit) const
{
  if (const auto found = replaced.find(place); found != replaced.end()) {
    for (const auto &[column, weight] : found->second)
      visit(column, weight);
    return;
  }
  const RowSums::Row sum = sums[place];
  for (unsigned int k = 0; k < sum.n; ++k)
    visit(static_cast<int>(sum.columns[k]), sum.weights[k]);
}

void FollowedSums::expand(const int global_row)
{
  const int row = place(global_row);
  if (is_done[row] || sums.is_only(row, global_row))
    return;
  is_done[row] = true;
  bool is_final = true;
  const RowSums::Row given = sums[row];
  for (unsigned int k = 0; k < given.n; ++k)
    if (const int column = given.columns[k]; !is_itself(column)) {
      expand(column);
      is_final = false;
    }
  if (is_final)
    return;
  std::map<int, double> sum;
  for (unsigned int k = 0; k < given.n; ++k) {
    const double weight = given.weights[k];
    for_sum(place(given.columns[k]),
            [&](const int other, const double its_weight) { sum[other] += weight * its_weight; });
  }
  replaced[row].assign(sum.begin(), sum.end());
}

void FollowedSums::read(const int row, std::vector<int> &columns, std::vector<double> &weights)
{
  columns.clear();
  weights.clear();
  expand(rows.GID(row));
  for_sum(row, [&](const int column, const double weight) {
    const int other = place(column);
    has_circle = has_circle || (number[other] < 0 && sums[other].n > 0 && weight != 0);
    if (number[other] >= 0 && weight != 0) {
      columns.push_back(number[other]);
      weights.push_back(weight);
    }
  });
}

} // namespace dovetail
