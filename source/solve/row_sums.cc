// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/row_sums.h>

#include <utility>

namespace dovetail {

void RowSums::append(RowSums &&other)
{
  if (rows.empty()) {
    *this = std::move(other);
    return;
  }
  const unsigned int n_columns = columns.size(), n_weights = weights.size();
  rows.reserve(rows.size() + other.rows.size());
  for (const Begin &begin : other.rows)
    rows.push_back({begin.first_column + n_columns, begin.first_weight + n_weights});
  columns.insert(columns.end(), other.columns.begin(), other.columns.end());
  weights.insert(weights.end(), other.weights.begin(), other.weights.end());
  other = RowSums();
}

} // namespace dovetail
