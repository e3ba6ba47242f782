// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "prolongation.h"

#include <algorithm>

namespace dovetail {

Prolongation::Prolongation(const Epetra_CrsMatrix &P) : exchange(P)
{
  const std::vector<int> numbers = numbers_of_columns(P);
  const auto for_groups = [&](const auto &begin) { // two passes, as memory is precious
    std::vector<Entry> first, row_entries;
    int first_row = 0;
    for (int row = 0; row < P.NumMyRows(); ++row) {
      int n = 0, *columns = nullptr;
      double *weights = nullptr;
      P.ExtractMyRowView(row, n, weights, columns);
      row_entries.clear();
      for (int k = 0; k < n; ++k)
        row_entries.push_back({numbers[columns[k]], static_cast<float>(weights[k])});
      const int shift = row - first_row;
      const bool is_alike =
          row > 0 && std::equal(row_entries.begin(), row_entries.end(), first.begin(), first.end(),
                                [shift](const Entry &a, const Entry &b) {
                                  return a.column == b.column + shift && a.weight == b.weight;
                                });
      if (is_alike)
        continue;
      first_row = row;
      first = row_entries;
      begin(row, first);
    }
  };
  std::size_t n_groups = 1, n_entries = 0;
  for_groups([&](int, const std::vector<Entry> &of_group) {
    ++n_groups;
    n_entries += of_group.size();
  });
  groups.reserve(n_groups);
  entries.reserve(n_entries);
  for_groups([&](const int row, const std::vector<Entry> &of_group) {
    groups.push_back({static_cast<unsigned int>(entries.size()), row});
    entries.insert(entries.end(), of_group.begin(), of_group.end());
  });
  groups.push_back({static_cast<unsigned int>(entries.size()), P.NumMyRows()});
}

template <typename Visit>
void Prolongation::for_rows(const Visit &visit) const
{
  for (unsigned int g = 0; g + 1 < groups.size(); ++g)
    for (int row = groups[g].first_row; row < groups[g + 1].first_row; ++row)
      visit(row, row - groups[g].first_row, entries.data() + groups[g].first_entry,
            entries.data() + groups[g + 1].first_entry);
}

void Prolongation::multiply(Epetra_Vector &y, const Epetra_Vector &x) const
{
  std::vector<double> buffer;
  const double *const of_columns = exchange.of_columns(x, buffer);
  for_rows([&](const int row, const int shift, const Entry *begin, const Entry *const end) {
    double sum = 0;
    for (; begin != end; ++begin)
      sum += static_cast<double>(begin->weight) * of_columns[begin->column + shift];
    y[row] = sum;
  });
}

void Prolongation::multiply_transposed(Epetra_Vector &y, const Epetra_Vector &x) const
{
  std::vector<double> sums(exchange.n_columns(), 0.);
  for_rows([&](const int row, const int shift, const Entry *begin, const Entry *const end) {
    for (; begin != end; ++begin)
      sums[begin->column + shift] += static_cast<double>(begin->weight) * x[row];
  });
  exchange.add_up(sums, y);
}

std::size_t Prolongation::memory_consumption() const
{
  return groups.capacity() * sizeof(Group) + entries.capacity() * sizeof(Entry);
}

} // namespace dovetail
