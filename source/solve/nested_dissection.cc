// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "nested_dissection.h"

#include <metis.h>

#include <algorithm>

namespace dovetail {

namespace {

struct Columns
{
  const int *begin = nullptr, *end = nullptr; ///< local numbers, sorted
};

Columns columns_of(const Epetra_CrsMatrix &A, const int row)
{
  int n = 0, *local = nullptr;
  double *values = nullptr;
  A.ExtractMyRowView(row, n, values, local);
  return {local, local + n};
}

std::vector<int> first_rows_of_equal_columns(const Epetra_CrsMatrix &A)
{
  std::vector<int> first_row;
  Columns last;
  for (int row = 0; row < A.NumMyRows(); ++row)
    if (const auto [begin, end] = columns_of(A, row);
        row == 0 || !std::equal(begin, end, last.begin, last.end)) {
      first_row.push_back(row);
      last = {begin, end};
    }
  first_row.push_back(A.NumMyRows());
  return first_row;
}

} // namespace

MatrixNodes::MatrixNodes(const Epetra_CrsMatrix &A, std::vector<int> first_row)
{
  if (first_row.empty() || first_row.back() != A.NumMyRows())
    first_row = first_rows_of_equal_columns(A);
  std::vector<int> local;
  for (auto row = first_row.begin(); row + 1 < first_row.end(); ++row) {
    local.clear();
    for (int of_node = *row; of_node < *(row + 1); ++of_node) {
      const auto [begin, end] = columns_of(A, of_node);
      local.insert(local.end(), begin, end);
    }
    std::sort(local.begin(), local.end());
    local.erase(std::unique(local.begin(), local.end()), local.end());
    n_rows.push_back(*(row + 1) - *row);
    n_columns.push_back(local.size());
    for (const int column : local)
      columns.push_back(A.GCID(column));
  }
}

namespace {

/// The neighbours of each node, without itself, in both directions.
std::vector<std::vector<idx_t>> neighbours(const MatrixNodes &all)
{
  std::vector<int> node_of_row;
  for (unsigned int node = 0; node < all.n_rows.size(); ++node)
    node_of_row.insert(node_of_row.end(), all.n_rows[node], node);
  std::vector<std::vector<idx_t>> result(all.n_rows.size());
  auto column = all.columns.begin();
  for (unsigned int node = 0; node < all.n_rows.size(); ++node)
    for (int k = 0; k < all.n_columns[node]; ++k)
      if (const unsigned int other = node_of_row[*column++]; other != node) {
        result[node].push_back(other);
        result[other].push_back(node);
      }
  for (auto &list : result) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return result;
}

} // namespace

std::vector<int> nested_dissection(const MatrixNodes &all)
{
  std::vector<idx_t> first(1, 0), edges;
  for (const auto &list : neighbours(all)) {
    edges.insert(edges.end(), list.begin(), list.end());
    first.push_back(edges.size());
  }
  idx_t n_nodes = all.n_rows.size();
  std::vector<idx_t> node_at(n_nodes), place_of(n_nodes);
  if (edges.empty() || METIS_NodeND(&n_nodes, first.data(), edges.data(), nullptr, nullptr, node_at.data(),
                                    place_of.data()) != METIS_OK)
    return {};
  std::vector<int> first_row(1, 0);
  for (const int n : all.n_rows)
    first_row.push_back(first_row.back() + n);
  std::vector<int> result(first_row.back());
  int place = 0;
  for (const idx_t node : node_at)
    for (int row = first_row[node]; row < first_row[node + 1]; ++row)
      result[row] = ++place;
  return result;
}

} // namespace dovetail
