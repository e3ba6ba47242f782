// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "nested_dissection.h"

#include <metis.h>

#include <algorithm>
#include <csignal>
#include <cstddef>
#include <limits>

namespace dovetail {

std::vector<int> rows_of_nodes(const Epetra_CrsMatrix &A)
{
  std::vector<int> result;
  int n_last = 0, *last = nullptr;
  for (int row = 0; row < A.NumMyRows(); ++row) {
    int n = 0, *local = nullptr;
    double *values = nullptr;
    A.ExtractMyRowView(row, n, values, local);
    if (row > 0 && std::equal(local, local + n, last, last + n_last))
      ++result.back();
    else
      result.push_back(1);
    n_last = n;
    last = local;
  }
  return result;
}

namespace {

/// The neighbours of each node, without itself, in both directions.
std::vector<std::vector<idx_t>> neighbours(const std::vector<int> &rows_of_nodes,
                                           const std::vector<int> &rows, const std::vector<int> &columns)
{
  std::vector<idx_t> node_of_row(1, -1); // from 1
  for (std::size_t node = 0; node < rows_of_nodes.size(); ++node)
    node_of_row.insert(node_of_row.end(), rows_of_nodes[node], static_cast<idx_t>(node));
  std::vector<std::vector<idx_t>> result(rows_of_nodes.size());
  std::vector<idx_t> seen_by(rows_of_nodes.size(), -1); // the rows of a node follow each other
  for (std::size_t k = 0; k < rows.size(); ++k)
    if (const idx_t node = node_of_row[rows[k]], other = node_of_row[columns[k]];
        node != other && seen_by[other] != node) {
      seen_by[other] = node;
      result[node].push_back(other);
      result[other].push_back(node);
    }
  for (auto &list : result) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return result;
}

/// METIS catches SIGTERM during its work and stops: a request to end the run, which it must not swallow.
int run_metis(std::vector<idx_t> weights, std::vector<idx_t> &first, std::vector<idx_t> &edges,
              std::vector<idx_t> &node_at)
{
  auto n_nodes = static_cast<idx_t>(weights.size());
  std::vector<idx_t> place_of(n_nodes);
  const int status = METIS_NodeND(&n_nodes, first.data(), edges.data(), weights.data(), nullptr,
                                  node_at.data(), place_of.data());
  if (status == METIS_ERROR)
    std::raise(SIGTERM);
  return status;
}

} // namespace

std::vector<int> nested_dissection(const std::vector<int> &rows_of_nodes, const std::vector<int> &rows,
                                   const std::vector<int> &columns)
{
  std::vector<idx_t> first(1, 0), edges;
  for (const auto &list : neighbours(rows_of_nodes, rows, columns)) {
    if (list.size() > std::numeric_limits<idx_t>::max() - edges.size())
      return {};
    edges.insert(edges.end(), list.begin(), list.end());
    first.push_back(static_cast<idx_t>(edges.size()));
  }
  std::vector<idx_t> node_at(rows_of_nodes.size());
  if (edges.empty() ||
      run_metis({rows_of_nodes.begin(), rows_of_nodes.end()}, first, edges, node_at) != METIS_OK)
    return {};
  std::vector<int> first_row(1, 0);
  for (const int n : rows_of_nodes)
    first_row.push_back(first_row.back() + n);
  std::vector<int> result(first_row.back());
  int place = 0;
  for (const idx_t node : node_at)
    for (int row = first_row[node]; row < first_row[node + 1]; ++row)
      result[row] = ++place;
  return result;
}

} // namespace dovetail
