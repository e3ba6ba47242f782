// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "sum_of_small.h"

#include <Epetra_CrsGraph.h>
#include <Epetra_MpiComm.h>

#include <algorithm>
#include <numeric>

namespace dovetail {

SumOfSmall::SumOfSmall(const Epetra_Map &own, const std::vector<int> &globals) : own(own), globals(globals)
{
  for (unsigned int k = own.NumMyElements(); k < globals.size(); ++k)
    others.emplace(globals[k], k);
}

int SumOfSmall::number(const int global)
{
  if (const int here = own.LID(global); here >= 0)
    return here;
  const auto [found, is_new] = others.emplace(global, globals.size());
  if (is_new)
    globals.push_back(global);
  return found->second;
}

MPI_Comm SumOfSmall::communicator() const
{
  return dynamic_cast<const Epetra_MpiComm &>(own.Comm()).Comm();
}

void SumOfSmall::allocate()
{
  sort_by_row();
  if (own.Comm().NumProc() > 1)
    exchange_columns();
  make_matrix();
  for (auto *const each : {&unknowns, &last_row, &columns})
    *each = std::vector<int>(); // = {} would keep the memory
  first_unknown = first_matrix = std::vector<std::size_t>();
  matrices = std::vector<unsigned int>();
  further.clear();
}

void SumOfSmall::sort_by_row()
{
  first_matrix.assign(globals.size() + 1, 0);
  for (const int row : unknowns)
    ++first_matrix[row + 1];
  std::partial_sum(first_matrix.begin(), first_matrix.end(), first_matrix.begin());
  matrices.resize(unknowns.size());
  std::vector<std::size_t> next(first_matrix.begin(), first_matrix.end() - 1);
  for (unsigned int m = 0; m + 1 < first_unknown.size(); ++m)
    for (std::size_t i = first_unknown[m]; i < first_unknown[m + 1]; ++i)
      matrices[next[unknowns[i]]++] = m;
  last_row.assign(globals.size(), -1);
}

void SumOfSmall::find_columns(const int row)
{
  columns.clear();
  const auto meet = [&](const int column) {
    if (last_row[column] != row) {
      last_row[column] = row;
      columns.push_back(column);
    }
  };
  for (std::size_t k = first_matrix[row]; k < first_matrix[row + 1]; ++k)
    for (std::size_t i = first_unknown[matrices[k]]; i < first_unknown[matrices[k] + 1]; ++i)
      meet(unknowns[i]);
  if (const auto found = further.find(row); found != further.end())
    for (const std::vector<int> *others : found->second)
      std::for_each(others->begin(), others->end(), meet);
}

/// Row by row, a message has the global number of the row, how many columns it has, and those of them.
void SumOfSmall::exchange_columns()
{
  const int n_own = own.NumMyElements(), n_others = globals.size() - n_own;
  std::vector<int> rank(n_others), local(n_others);
  own.RemoteIDList(n_others, globals.data() + n_own, rank.data(), local.data());
  std::map<unsigned int, std::vector<int>> messages;
  for (int k = 0; k < n_others; ++k) {
    find_columns(n_own + k);
    std::sort(columns.begin(), columns.end());
    of_others.push_back({n_own + k, rank[k], columns, std::vector<double>(columns.size(), 0.)});
    if (columns.empty())
      continue;
    auto &message = messages[rank[k]];
    message.insert(message.end(), {globals[n_own + k], static_cast<int>(columns.size())});
    for (const int column : columns)
      message.push_back(globals[column]);
  }
  for (const auto &[sender, message] : dealii::Utilities::MPI::some_to_some(communicator(), messages))
    for (auto next = message.begin(); next != message.end();) {
      Row row{own.LID(*next), static_cast<int>(sender), {}, {}};
      const auto begin = next + 2, end = begin + next[1];
      for (next = begin; next != end; ++next)
        row.columns.push_back(number(*next));
      from_others.push_back(std::move(row));
    }
  for (const Row &row : from_others)
    meet(row.number, row.columns);
  last_row.assign(globals.size(), -1);
}

/// The own ones first, then those of other ranks in ascending order, without those that own rows do not have.
Epetra_Map SumOfSmall::place_columns(std::vector<int> &lengths)
{
  const int n_own = own.NumMyElements();
  std::map<int, int> needed; // by global number
  for (int row = 0; row < n_own; ++row) {
    find_columns(row);
    lengths[row] = columns.size();
    for (const int column : columns)
      if (column >= n_own)
        needed.emplace(globals[column], column);
  }
  std::fill(last_row.begin(), last_row.end(), -1);
  place.assign(globals.size(), -1);
  std::iota(place.begin(), place.begin() + n_own, 0);
  if (own.Comm().NumProc() == 1)
    return own;
  std::vector<int> all(globals.begin(), globals.begin() + n_own);
  for (const auto &[global, column] : needed) {
    place[column] = all.size();
    all.push_back(global);
  }
  return Epetra_Map(-1, static_cast<int>(all.size()), all.data(), 0, own.Comm());
}

void SumOfSmall::make_matrix()
{
  std::vector<int> lengths(own.NumMyElements());
  const Epetra_Map all_columns = place_columns(lengths);
  Epetra_CrsGraph graph(Copy, own, all_columns, lengths.data(),
                        true); // values that are inserted are held twice
  for (unsigned int row = 0; row < lengths.size(); ++row) {
    find_columns(row);
    for (int &column : columns)
      column = place[column];
    std::sort(columns.begin(), columns.end());
    graph.InsertMyIndices(row, columns.size(), columns.data());
  }
  graph.FillComplete(own, own);
  graph.OptimizeStorage();
  sum = std::make_unique<Epetra_CrsMatrix>(Copy, graph);
  sum->FillComplete(own, own);
}

/// To an own row. Its entries are in the order of places, as those that are added.
template <typename Entry>
void SumOfSmall::add_sorted(const int row, const Entry &entry)
{
  int n = 0, *places = nullptr;
  double *values = nullptr;
  sum->ExtractMyRowView(row, n, values, places);
  int k = 0;
  for (const auto &[its_place, index] : order) {
    while (places[k] != its_place)
      ++k;
    values[k] += entry(index);
  }
}

template <typename Entry>
void SumOfSmall::add_row(const int row, const std::vector<int> &numbers, const Entry &entry)
{
  if (row < own.NumMyElements()) {
    add_sorted(row, entry);
    return;
  }
  Row &other = of_others[row - own.NumMyElements()];
  for (unsigned int k = 0; k < numbers.size(); ++k)
    other.parts[std::lower_bound(other.columns.begin(), other.columns.end(), numbers[k]) -
                other.columns.begin()] += entry(k);
}

void SumOfSmall::sort(const std::vector<int> &numbers)
{
  order.clear();
  for (unsigned int k = 0; k < numbers.size(); ++k)
    order.emplace_back(place[numbers[k]], k);
  std::sort(order.begin(), order.end());
}

void SumOfSmall::add(const std::vector<int> &numbers, const dealii::FullMatrix<double> &entries)
{
  sort(numbers);
  for (unsigned int i = 0; i < numbers.size(); ++i)
    add_row(numbers[i], numbers, [&](const unsigned int j) { return entries(i, j); });
}

void SumOfSmall::add(const int row, const std::vector<int> &numbers, const double *entries)
{
  sort(numbers);
  add_row(row, numbers, [&](const unsigned int k) { return entries[k]; });
}

std::unique_ptr<Epetra_CrsMatrix> SumOfSmall::finish()
{
  if (own.Comm().NumProc() == 1)
    return std::move(sum);
  std::map<unsigned int, std::vector<double>> messages;
  for (const Row &row : of_others)
    if (!row.parts.empty())
      messages[row.rank].insert(messages[row.rank].end(), row.parts.begin(), row.parts.end());
  const auto received = dealii::Utilities::MPI::some_to_some(communicator(), messages);
  std::map<unsigned int, std::size_t> next; // in the messages
  for (const Row &row : from_others) {
    add(row.number, row.columns, received.at(row.rank).data() + next[row.rank]);
    next[row.rank] += row.columns.size();
  }
  return std::move(sum);
}

} // namespace dovetail
