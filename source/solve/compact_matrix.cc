// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "compact_matrix.h"

#include <dovetail/solve/free_memory.h>

#include <deal.II/base/exceptions.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace dovetail {

namespace {

/// By number of a column its value in an own row, in ascending order.
void read_row(const Epetra_CrsMatrix &A, const int row, const std::vector<int> &numbers,
              const bool needs_diagonal, std::vector<std::pair<int, double>> &entries)
{
  int n = 0, *columns = nullptr;
  double *values = nullptr;
  A.ExtractMyRowView(row, n, values, columns);
  entries.clear();
  bool is_sorted = true, has_diagonal = false;
  for (int k = 0; k < n; ++k) {
    const int column = numbers[columns[k]];
    is_sorted = is_sorted && (k == 0 || entries.back().first < column);
    has_diagonal = has_diagonal || column == row;
    entries.emplace_back(column, values[k]);
  }
  if (needs_diagonal && !has_diagonal)
    entries.emplace_back(row, 0.);
  if (!is_sorted || (needs_diagonal && !has_diagonal))
    std::sort(entries.begin(), entries.end());
}

bool is_square(const Epetra_CrsMatrix &A)
{
  return A.RowMap().SameAs(A.DomainMap());
}

} // namespace

std::vector<int> numbers_of_columns(const Epetra_CrsMatrix &A)
{
  std::vector<int> numbers(A.NumMyCols());
  int next = A.DomainMap().NumMyElements();
  for (unsigned int k = 0; k < numbers.size(); ++k) {
    const int own = A.DomainMap().LID(A.GCID(k));
    numbers[k] = own >= 0 ? own : next++;
  }
  return numbers;
}

RowPattern::RowPattern(const Epetra_CrsMatrix &A) : number_of_rows(A.NumMyRows())
{
  const std::vector<int> numbers = numbers_of_columns(A);
  const bool needs_diagonal = is_square(A);
  const int n_own = A.DomainMap().NumMyElements();
  std::vector<std::pair<int, double>> entries;
  const auto for_groups = [&](const auto &begin) { // two passes, as memory is precious
    std::vector<int> last;
    int first_row = 0;
    for (int row = 0; row < number_of_rows; ++row) {
      read_row(A, row, numbers, needs_diagonal, entries);
      const bool is_same =
          row > 0 && row - first_row < most_rows &&
          std::equal(entries.begin(), entries.end(), last.begin(), last.end(),
                     [](const auto &entry, const int column) { return entry.first == column; });
      if (!is_same) {
        first_row = row;
        last.clear();
        for (const auto &[column, value] : entries)
          last.push_back(column);
      }
      begin(row, is_same);
    }
  };
  std::size_t n_groups = 0, n_columns = 0;
  for_groups([&](int, const bool is_same) {
    n_groups += is_same ? 0 : 1;
    n_columns += is_same ? 0 : entries.size();
  });
  groups.reserve(n_groups);
  columns.reserve(n_columns);
  for_groups([&](const int row, const bool is_same) {
    if (!is_same) {
      const auto less_than = [&](const int limit) {
        return static_cast<int>(std::count_if(entries.begin(), entries.end(),
                                              [limit](const auto &entry) { return entry.first < limit; }));
      };
      groups.push_back({columns.size(), number_of_entries, row, less_than(row), less_than(n_own)});
      for (const auto &[column, value] : entries)
        columns.push_back(column);
    }
    number_of_entries += entries.size();
  });
}

std::size_t RowPattern::memory_consumption() const
{
  return groups.capacity() * sizeof(Stored) + columns.capacity() * sizeof(int);
}

CompactMatrix::CompactMatrix(const Epetra_CrsMatrix &A)
    : range(A.RowMap()), exchange(A), pattern(std::make_shared<RowPattern>(A))
{
  set_values(A, [](int) {});
}

CompactMatrix::CompactMatrix(std::unique_ptr<Epetra_CrsMatrix> A)
    : range(A->RowMap()), exchange(*A), pattern(std::make_shared<RowPattern>(*A))
{
  const int many = 1 << 16; // entries
  int *begin = nullptr, *columns = nullptr, end = 0;
  double *entries = nullptr;
  const bool is_at_hand = A->ExtractCrsDataPointers(begin, columns, entries) == 0,
             owns_columns = A->Graph().ReferenceCount() == 1;
  set_values(*A, [&](const int n_rows) {
    if (!is_at_hand || begin[n_rows] < end + many)
      return;
    give_back_pages(entries + end, entries + begin[n_rows]);
    if (owns_columns)
      give_back_pages(columns + end, columns + begin[n_rows]);
    end = begin[n_rows];
  });
}

/// Calls @p done(n): the first n rows are not read any more.
template <typename Done>
void CompactMatrix::set_values(const Epetra_CrsMatrix &A, const Done &done)
{
  const std::vector<int> numbers = numbers_of_columns(A);
  const bool needs_diagonal = is_square(A);
  std::vector<std::pair<int, double>> entries;
  for (int row = 0; row < A.NumMyRows(); ++row) {
    int n = 0;
    double *row_values = nullptr;
    A.ExtractMyRowView(row, n, row_values);
    for (int k = 0; k < n; ++k)
      unit = std::max(unit, std::abs(row_values[k]));
  }
  unit = unit > 0 ? unit : 1;
  values.reserve(pattern->n_entries());
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    const RowPattern::Group group = pattern->group(g);
    values.resize(values.size() + static_cast<std::size_t>(group.n_columns) * group.n_rows);
    for (int i = 0; i < group.n_rows; ++i) {
      read_row(A, group.first_row + i, numbers, needs_diagonal, entries);
      for (int k = 0; k < group.n_columns; ++k)
        values[group.first_entry + static_cast<std::size_t>(k) * group.n_rows + i] =
            static_cast<float>(entries[k].second / unit);
    }
    done(group.first_row + group.n_rows);
  }
}

void CompactMatrix::multiply(Epetra_Vector &y, const Epetra_Vector &x) const
{
  std::vector<double> buffer;
  const double *const of_columns = exchange.of_columns(x, buffer);
  double *const result = y.Values();
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    const RowPattern::Group group = pattern->group(g);
    with_known_number(group.n_rows, [&](const auto n) {
      std::array<double, RowPattern::most_rows> sum{};
      const float *entries = values.data() + group.first_entry;
      for (int k = 0; k < group.n_columns; ++k, entries += n) {
        const double factor = of_columns[group.columns[k]];
        for (int i = 0; i < n; ++i)
          sum[i] += factor * static_cast<double>(entries[i]);
      }
      for (int i = 0; i < n; ++i)
        result[group.first_row + i] = unit * sum[i];
    });
  }
}

void CompactMatrix::multiply_transposed(Epetra_Vector &y, const Epetra_Vector &x) const
{
  std::vector<double> sums(exchange.n_columns(), 0.);
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    const RowPattern::Group group = pattern->group(g);
    with_known_number(group.n_rows, [&](const auto n) {
      const float *entries = values.data() + group.first_entry;
      std::array<double, RowPattern::most_rows> factor{};
      for (int i = 0; i < n; ++i)
        factor[i] = unit * x[group.first_row + i];
      for (int k = 0; k < group.n_columns; ++k, entries += n) {
        double sum = 0;
        for (int i = 0; i < n; ++i)
          sum += factor[i] * static_cast<double>(entries[i]);
        sums[group.columns[k]] += sum;
      }
    });
  }
  exchange.add_up(sums, y);
}

void CompactMatrix::diagonal(Epetra_Vector &result) const
{
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    const RowPattern::Group group = pattern->group(g);
    for (int i = 0; i < group.n_rows; ++i)
      result[group.first_row + i] =
          unit * values[group.first_entry + static_cast<std::size_t>(group.n_lower + i) * group.n_rows + i];
  }
}

std::size_t CompactMatrix::memory_consumption() const
{
  return pattern->memory_consumption() + values.capacity() * sizeof(float);
}

} // namespace dovetail
