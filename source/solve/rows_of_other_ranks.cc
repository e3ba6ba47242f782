// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/rows_of_other_ranks.h>

#include <deal.II/base/mpi.h>

#include <Epetra_MpiComm.h>

#include <boost/serialization/utility.hpp>
#include <boost/serialization/vector.hpp>

#include <map>
#include <utility>

namespace dovetail {

void read_row(const Epetra_CrsMatrix &A, const int row, std::vector<int> &columns,
              std::vector<double> &values)
{
  int n = 0, *local = nullptr;
  double *entries = nullptr;
  A.ExtractMyRowView(row, n, entries, local);
  values.assign(entries, entries + n);
  columns.clear();
  for (int k = 0; k < n; ++k)
    columns.push_back(A.GCID(local[k]));
}

std::vector<RowOfOtherRank> rows_of_other_ranks(
    const Epetra_Map &rows, const std::vector<int> &wanted,
    const std::function<void(int row, std::vector<int> &columns, std::vector<double> &values)> &read)
{
  /// Row by row, the numbers of columns and of values before the columns.
  using Message = std::pair<std::vector<int>, std::vector<double>>;
  const MPI_Comm communicator = dynamic_cast<const Epetra_MpiComm &>(rows.Comm()).Comm();
  const int n = wanted.size();
  std::vector<int> rank(n), local(n);
  rows.RemoteIDList(n, wanted.data(), rank.data(), local.data());
  std::map<unsigned int, std::vector<int>> questions;
  for (int k = 0; k < n; ++k)
    questions[rank[k]].push_back(local[k]);
  std::map<unsigned int, Message> answers;
  RowOfOtherRank own;
  for (const auto &[asking, asked] : dealii::Utilities::MPI::some_to_some(communicator, questions))
    for (const int row : asked) {
      auto &[numbers, values] = answers[asking];
      read(row, own.columns, own.values);
      numbers.push_back(own.columns.size());
      numbers.push_back(own.values.size());
      numbers.insert(numbers.end(), own.columns.begin(), own.columns.end());
      values.insert(values.end(), own.values.begin(), own.values.end());
    }
  answers = dealii::Utilities::MPI::some_to_some(communicator, answers);

  std::map<unsigned int, std::pair<std::size_t, std::size_t>> next; // in the messages
  std::vector<RowOfOtherRank> result(n);
  for (int k = 0; k < n; ++k) {
    const auto &[numbers, values] = answers.at(rank[k]);
    auto &[number, value] = next[rank[k]];
    const int n_columns = numbers[number], n_values = numbers[number + 1];
    number += 2;
    result[k].columns.assign(numbers.begin() + number, numbers.begin() + number + n_columns);
    result[k].values.assign(values.begin() + value, values.begin() + value + n_values);
    number += n_columns;
    value += n_values;
  }
  return result;
}

} // namespace dovetail
