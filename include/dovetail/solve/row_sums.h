// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rows that are weighted sums of other rows, in little memory.

#pragma once

#include <deal.II/base/types.h>

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace dovetail {

/// For each of some rows the numbers of others, and the weights, that it is the sum of. Weights that many
/// rows share are held once.
class RowSums
{
public:
  using Index = dealii::types::global_dof_index;
  struct Row
  {
    unsigned int n;
    const Index *columns;
    const double *weights;
  };

  unsigned int size() const { return rows.size(); }
  Row operator[](const unsigned int row) const
  {
    const unsigned int begin = rows[row].first_column,
                       end = row + 1 < rows.size() ? rows[row + 1].first_column : columns.size();
    return {end - begin, columns.data() + begin, weights.data() + rows[row].first_weight};
  }
  /// Whether a row is nothing but the one with this number.
  bool is_only(const unsigned int row, const Index number) const
  {
    const Row sum = (*this)[row];
    return sum.n == 1 && sum.columns[0] == number;
  }

  void reserve(const unsigned int n_rows, const std::size_t n_columns)
  {
    rows.reserve(rows.size() + n_rows);
    columns.reserve(columns.size() + n_columns);
  }
  /// Of rows to come. @return where they are
  unsigned int add_weights(const std::vector<double> &list)
  {
    weights.insert(weights.end(), list.begin(), list.end());
    return weights.size() - list.size();
  }
  /// The next row, with weights that have been added. @return its columns, to be filled
  Index *add_row(const unsigned int n, const unsigned int first_weight)
  {
    rows.push_back({static_cast<unsigned int>(columns.size()), first_weight});
    columns.resize(columns.size() + n);
    return columns.data() + columns.size() - n;
  }
  /// The next row, with pairs of a number and a weight.
  template <typename Entries>
  void add_row(const Entries &entries)
  {
    rows.push_back({static_cast<unsigned int>(columns.size()), static_cast<unsigned int>(weights.size())});
    for (const auto &[column, weight] : entries) {
      columns.push_back(column);
      weights.push_back(weight);
    }
  }
  Index *columns_of(const unsigned int row) { return columns.data() + rows[row].first_column; }
  /// The rows of @p other come after those that are there.
  void append(RowSums &&other);
  /// With other rows in place of some: of those for which @p find(row, entries) is true, pairs of a number
  /// and a weight. Lists of weights stay shared.
  template <typename Find>
  RowSums replaced(const Find &find) const
  {
    RowSums result;
    result.weights = weights;
    std::vector<std::pair<Index, double>> entries;
    for (unsigned int row = 0; row < size(); ++row)
      if (find(row, entries))
        result.add_row(entries);
      else {
        const Row sum = (*this)[row];
        std::copy(sum.columns, sum.columns + sum.n, result.add_row(sum.n, rows[row].first_weight));
      }
    return result;
  }
  /// Each number becomes @p number(number).
  template <typename Number>
  void renumber(const Number &number)
  {
    for (Index &column : columns)
      column = number(column);
  }

private:
  struct Begin
  {
    unsigned int first_column, first_weight;
  };
  std::vector<Begin> rows;
  std::vector<Index> columns;
  std::vector<double> weights;
};

} // namespace dovetail
