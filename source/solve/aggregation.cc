// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "aggregation.h"

#include <deal.II/base/exceptions.h>

#include <Epetra_Map.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace dovetail {

namespace {

/// The nodes of this rank and their couplings.
class CoupledNodes
{
public:
  /// @pre A is complete
  CoupledNodes(const Epetra_CrsMatrix &A, const int rows_per_node)
      : n_nodes(A.NumMyRows() / rows_per_node), rows_per_node(rows_per_node), own_row(A.NumMyCols())
  {
    for (int column = 0; column < A.NumMyCols(); ++column)
      own_row[column] = A.Importer() == nullptr ? column : A.LRID(A.GCID(column));
    const int error = A.ExtractCrsDataPointers(begin, columns, values);
    AssertThrow(error == 0, dealii::ExcMessage("The rows of a matrix do not follow each other in memory."));
  }

  int size() const { return n_nodes; }
  int node_of(const int row) const { return row / rows_per_node; }
  bool is_coupled(int row) const; ///< or prescribed
  /// Calls @p visit(other) for each entry that couples the node with another one.
  template <typename Visit>
  void for_others(int node, const Visit &visit) const;

private:
  /// Calls @p visit(column) for the entries of a row that are not zero; column: the own row of this number,
  /// or negative.
  template <typename Visit>
  void for_entries(int row, const Visit &visit) const;

  const int n_nodes, rows_per_node;
  std::vector<int> own_row; ///< of each column
  int *begin = nullptr, *columns = nullptr;
  double *values = nullptr;
};

template <typename Visit>
void CoupledNodes::for_entries(const int row, const Visit &visit) const
{
  for (int k = begin[row]; k < begin[row + 1]; ++k)
    if (values[k] != 0)
      visit(own_row[columns[k]]);
}

bool CoupledNodes::is_coupled(const int row) const
{
  bool is_any_other = false;
  for_entries(row, [&](const int column) { is_any_other = is_any_other || column != row; });
  return is_any_other;
}

template <typename Visit>
void CoupledNodes::for_others(const int node, const Visit &visit) const
{
  const int first = node * rows_per_node, end = first + rows_per_node;
  for (int row = first; row < end; ++row)
    for_entries(row, [&](const int column) {
      if (column >= 0 && (column < first || column >= end))
        visit(node_of(column));
    });
}

/// By node the number of its set; negative: nothing is coupled with it.
class Sets
{
public:
  explicit Sets(const CoupledNodes &nodes);

  std::vector<int> of_node;
  int number = 0;

private:
  void begin(int node);
  void join(int node, const std::vector<int> &first);

  const CoupledNodes &nodes;
  std::vector<int> seen; ///< by set; all zero
};

Sets::Sets(const CoupledNodes &nodes) : of_node(nodes.size(), -1), nodes(nodes)
{
  for (const double least_share : {1., 1. / 3})
    for (int node = 0; node < nodes.size(); ++node) {
      if (of_node[node] >= 0)
        continue;
      unsigned int n_others = 0, n_free = 0;
      nodes.for_others(node, [&](const int other) {
        ++n_others;
        n_free += of_node[other] < 0 ? 1 : 0;
      });
      if (n_others > 0 && n_free >= least_share * n_others)
        begin(node);
    }
  const std::vector<int> first = of_node;
  seen.assign(number, 0);
  for (int node = 0; node < nodes.size(); ++node)
    if (first[node] < 0)
      join(node, first);
  for (int node = 0; node < nodes.size(); ++node)
    if (of_node[node] < 0) {
      bool has_others = false;
      nodes.for_others(node, [&](int) { has_others = true; });
      if (has_others)
        begin(node);
    }
}

void Sets::begin(const int node)
{
  of_node[node] = number;
  nodes.for_others(node, [&](const int other) {
    if (of_node[other] < 0)
      of_node[other] = number;
  });
  ++number;
}

/// The set of @p first that most entries lead to.
void Sets::join(const int node, const std::vector<int> &first)
{
  nodes.for_others(node, [&](const int other) {
    if (const int set = first[other]; set >= 0)
      if (++seen[set]; of_node[node] < 0 || seen[set] > seen[of_node[node]])
        of_node[node] = set;
  });
  nodes.for_others(node, [&](const int other) {
    if (first[other] >= 0)
      seen[first[other]] = 0;
  });
}

/// Makes the modes on some rows orthonormal. What they were in that basis: column c of the coarse modes, by
/// mode, begins at row @p first.
void make_basis(const std::vector<int> &rows, const Epetra_MultiVector &modes, std::vector<double> &basis,
                Epetra_MultiVector &coarse_modes, const int first)
{
  const double least = 1e-7;
  const int n_modes = modes.NumVectors();
  std::vector<std::vector<double>> vectors;
  for (int mode = 0; mode < n_modes; ++mode) {
    std::vector<double> v;
    for (const int row : rows)
      v.push_back(modes[mode][row]);
    const auto norm = [&v]() { return std::sqrt(std::inner_product(v.begin(), v.end(), v.begin(), 0.)); };
    const double before = norm();
    for (unsigned int pass = 0; pass < 2; ++pass)
      for (int k = 0; k < mode; ++k) {
        const double part = std::inner_product(v.begin(), v.end(), vectors[k].begin(), 0.);
        coarse_modes[mode][first + k] += part;
        for (unsigned int i = 0; i < v.size(); ++i)
          v[i] -= part * vectors[k][i];
      }
    const double length = norm();
    const bool depends = !(length > least * before);
    coarse_modes[mode][first + mode] = depends ? 0 : length;
    for (unsigned int i = 0; i < v.size(); ++i) {
      v[i] = depends ? 0 : v[i] / length;
      basis[static_cast<std::size_t>(rows[i]) * n_modes + mode] = v[i];
    }
    vectors.push_back(std::move(v));
  }
}

} // namespace

Aggregation make_bases(std::vector<int> set_of_row, const int n_sets, const Epetra_MultiVector &modes)
{
  const int n_modes = modes.NumVectors();
  std::vector<std::vector<int>> rows(n_sets);
  for (unsigned int row = 0; row < set_of_row.size(); ++row)
    if (set_of_row[row] >= 0)
      rows[set_of_row[row]].push_back(row);
  Aggregation result;
  result.basis.assign(set_of_row.size() * n_modes, 0.);
  result.of_row = std::move(set_of_row);
  result.modes =
      std::make_unique<Epetra_MultiVector>(Epetra_Map(-1, n_sets * n_modes, 0, modes.Comm()), n_modes);
  for (int set = 0; set < n_sets; ++set)
    make_basis(rows[set], modes, result.basis, *result.modes, set * n_modes);
  return result;
}

Aggregation make_aggregation(const Epetra_CrsMatrix &A, const Epetra_MultiVector &modes,
                             const int rows_per_node)
{
  const CoupledNodes nodes(A, rows_per_node);
  const Sets sets(nodes);
  std::vector<int> set_of_row(A.NumMyRows(), -1);
  for (int row = 0; row < A.NumMyRows(); ++row)
    if (const int set = sets.of_node[nodes.node_of(row)]; set >= 0 && nodes.is_coupled(row))
      set_of_row[row] = set;
  return make_bases(std::move(set_of_row), sets.number, modes);
}

} // namespace dovetail
