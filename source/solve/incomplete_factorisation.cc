// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "incomplete_factorisation.h"

#include <algorithm>
#include <array>
#include <utility>

namespace dovetail {

IncompleteFactorisation::IncompleteFactorisation(CompactMatrix A, const double shift)
    : pattern(A.pattern), values(std::move(A.values)), unit(A.unit)
{
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    const RowPattern::Group group = pattern->group(g);
    for (int i = 0; i < group.n_rows; ++i) {
      float &diagonal = entries(group, group.n_lower + i)[i];
      diagonal = diagonal == 0 ? 1 : static_cast<float>((1 + shift) * diagonal); // of an empty row
    }
  }
  factorise();
}

void IncompleteFactorisation::factorise()
{
  std::vector<unsigned int> group_of_row(pattern->n_rows());
  std::vector<int> position(pattern->n_rows(), -1); // of a column among those of the group
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    const RowPattern::Group group = pattern->group(g);
    std::fill_n(group_of_row.begin() + group.first_row, group.n_rows, g);
    for (int k = 0; k < group.n_own; ++k)
      position[group.columns[k]] = k;
    eliminate(group, group_of_row, position);
    for (int k = 0; k < group.n_own; ++k)
      position[group.columns[k]] = -1;
  }
}

/// Row by row, and within a row the columns from the left (Saad 2003, section 10.3).
void IncompleteFactorisation::eliminate(const RowPattern::Group &group,
                                        const std::vector<unsigned int> &group_of_row,
                                        const std::vector<int> &position)
{
  const int n = group.n_rows;
  for (int k = 0; k < group.n_lower + n; ++k) {
    const int column = group.columns[k];
    const RowPattern::Group other = pattern->group(group_of_row[column]);
    const int row = column - other.first_row, pivot = other.n_lower + row,
              first = std::max(0, column + 1 - group.first_row); // of the rows below the diagonal
    float &inverse = entries(other, pivot)[row];
    if (column >= group.first_row) // the columns before have made this row of U
      inverse = 1 / inverse;
    float *const l = entries(group, k);
    for (int i = first; i < n; ++i)
      l[i] *= inverse;
    for (int j = pivot + 1; j < other.n_own; ++j)
      if (const int here = position[other.columns[j]]; here >= 0) {
        const float u = entries(other, j)[row];
        float *const a = entries(group, here);
        for (int i = first; i < n; ++i)
          a[i] -= l[i] * u;
      }
  }
}

/// Sums in double precision.
void IncompleteFactorisation::vmult(double *const z, const double *const r) const
{
  const auto subtract = [&](const RowPattern::Group &group, const int begin, const int end,
                            double *const sum) {
    with_known_number(group.n_rows, [&](const auto n) {
      const float *entry = &values[group.first_entry + static_cast<std::size_t>(begin) * n];
      for (int k = begin; k < end; ++k, entry += n) {
        const double factor = z[group.columns[k]];
        for (int i = 0; i < n; ++i)
          sum[i] -= factor * static_cast<double>(entry[i]);
      }
    });
  };
  std::array<double, RowPattern::most_rows> sum{};
  const auto entry = [&](const RowPattern::Group &group, const int column, const int row) {
    return static_cast<double>(
        values[group.first_entry + static_cast<std::size_t>(group.n_lower + column) * group.n_rows + row]);
  };
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    const RowPattern::Group group = pattern->group(g);
    for (int i = 0; i < group.n_rows; ++i)
      sum[i] = r[group.first_row + i] / unit;
    subtract(group, 0, group.n_lower, sum.data());
    for (int i = 0; i < group.n_rows; ++i) {
      for (int j = 0; j < i; ++j)
        sum[i] -= entry(group, j, i) * sum[j];
      z[group.first_row + i] = sum[i];
    }
  }
  for (unsigned int g = pattern->n_groups(); g-- > 0;) {
    const RowPattern::Group group = pattern->group(g);
    std::copy_n(z + group.first_row, group.n_rows, sum.begin());
    subtract(group, group.n_lower + group.n_rows, group.n_own, sum.data());
    for (int i = group.n_rows - 1; i >= 0; --i) {
      for (int j = i + 1; j < group.n_rows; ++j)
        sum[i] -= entry(group, j, i) * sum[j];
      sum[i] *= entry(group, i, i);
      z[group.first_row + i] = sum[i];
    }
  }
}

} // namespace dovetail
