// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "compact_matrix.h"

#include "row_products.h"

#include <dovetail/solve/free_memory.h>

#include <deal.II/base/exceptions.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace dovetail {

namespace {

/// The rows of a matrix without columns that are zero but for the diagonal.
class RowReader
{
public:
  RowReader(const Epetra_CrsMatrix &A, bool has_diagonals);
  /// The numbers of an own row's columns in ascending order, and where their values are; -1: zero.
  void read(int row, std::vector<std::pair<int, int>> &entries) const;
  /// Whether an own row has the columns of the one before, as far as that is seen without reading them.
  bool is_like_the_one_before(int row) const;

private:
  const Epetra_CrsMatrix &A;
  const std::vector<int> numbers;
  const bool has_diagonals;
  std::vector<char> has_row, has_column; ///< other entries than that of the diagonal, by number
};

RowReader::RowReader(const Epetra_CrsMatrix &A, const bool has_diagonals)
    : A(A), numbers(numbers_of_columns(A)), has_diagonals(has_diagonals),
      has_row(A.NumMyRows(), !has_diagonals),
      has_column(A.DomainMap().NumMyElements() + numbers.size(), false)
{
  for (int row = 0; row < A.NumMyRows(); ++row) {
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    A.ExtractMyRowView(row, n, values, columns);
    for (int k = 0; k < n; ++k)
      if (const int column = numbers[columns[k]]; values[k] != 0 && !(has_diagonals && column == row))
        has_row[row] = has_column[column] = true;
  }
}

void RowReader::read(const int row, std::vector<std::pair<int, int>> &entries) const
{
  int n = 0, *columns = nullptr;
  double *values = nullptr;
  A.ExtractMyRowView(row, n, values, columns);
  entries.clear();
  bool is_sorted = true, has_diagonal = false;
  for (int k = 0; k < n; ++k) {
    const int column = numbers[columns[k]];
    const bool is_diagonal = has_diagonals && column == row;
    if (!is_diagonal && !(has_row[row] && has_column[column]))
      continue;
    is_sorted = is_sorted && (entries.empty() || entries.back().first < column);
    has_diagonal = has_diagonal || is_diagonal;
    entries.emplace_back(column, k);
  }
  if (has_diagonals && !has_diagonal)
    entries.emplace_back(row, -1);
  if (!is_sorted || (has_diagonals && !has_diagonal))
    std::sort(entries.begin(), entries.end());
}

bool RowReader::is_like_the_one_before(const int row) const
{
  int n = 0, n_before = 0, *columns = nullptr, *columns_before = nullptr, n_diagonals = has_diagonals ? 0 : 2;
  double *values = nullptr;
  A.ExtractMyRowView(row, n, values, columns);
  A.ExtractMyRowView(row - 1, n_before, values, columns_before);
  if (n != n_before || !std::equal(columns, columns + n, columns_before))
    return false;
  for (int k = 0; k < n && has_diagonals; ++k)
    if (const int column = numbers[columns[k]]; column == row - 1 || column == row)
      n_diagonals += has_row[column] && has_column[column] ? 1 : 0;
  return n_diagonals == 2;
}

/// The largest usual number of columns that follow each other wherever some do. None goes across the rows of
/// the group, where they are columns, or from own columns to others.
int block_length(const std::vector<int> &columns, const int first_row, const int n_rows, const int n_own,
                 const bool has_diagonals)
{
  int divisor = 0, begin = 0, size = columns.size();
  for (int k = 1; k <= size; ++k)
    if (k == size || columns[k] != columns[k - 1] + 1 || columns[k] == n_own ||
        (has_diagonals && (columns[k] == first_row || columns[k] == first_row + n_rows))) {
      divisor = std::gcd(divisor, k - begin);
      begin = k;
    }
  for (const int length : {6, 3, 2})
    if (divisor % length == 0)
      return length;
  return 1;
}

DOVETAIL_WIDEST_VECTORS void multiply(const RowPattern &pattern, const float *const values, const double unit,
                                      const double *const x, double *const y, double *const buffer)
{
  for (unsigned int g = 0; g < pattern.n_groups(); ++g) {
    const RowPattern::Group group = pattern.group(g);
    with_constant(
        group.n_rows, [&](const auto n) __attribute__((always_inline)) {
          double sums[n];
          multiply_rows<n>(group.columns, values + group.first_entry, x, sums, buffer);
          for (int i = 0; i < n; ++i)
            y[group.first_row + i] = unit * sums[i];
        });
  }
}

/// Of a symmetric matrix.
DOVETAIL_WIDEST_VECTORS void multiply_symmetric(const RowPattern &pattern, const float *const values,
                                                const double unit, const double *const x, double *const y,
                                                double *const buffer, double *const sums)
{
  const std::ptrdiff_t ahead = 1024;
  std::fill_n(y, pattern.n_rows(), 0.);
  for (unsigned int g = 0; g < pattern.n_groups(); ++g) {
    const RowPattern::Group group = pattern.group(g);
    const float *const entries = values + group.first_entry;
    prefetch(entries, std::size_t(group.columns.size) * group.n_rows, ahead);
    with_constant(
        group.n_rows, [&](const auto n) __attribute__((always_inline)) {
          add_symmetric_rows<n>(group, entries, x, y, buffer, sums);
          for (int i = 0; i < n; ++i) // to which no other group adds any more
            y[group.first_row + i] *= unit;
        });
  }
}

/// Adds A^T x.
DOVETAIL_WIDEST_VECTORS void add_transposed(const RowPattern &pattern, const float *const values,
                                            const double unit, const double *const x, double *const y,
                                            double *const buffer)
{
  for (unsigned int g = 0; g < pattern.n_groups(); ++g) {
    const RowPattern::Group group = pattern.group(g);
    with_constant(
        group.n_rows, [&](const auto n) __attribute__((always_inline)) {
          double factors[n];
          for (int i = 0; i < n; ++i)
            factors[i] = unit * x[group.first_row + i];
          add_rows<n>(group.columns, values + group.first_entry, factors, y, buffer);
        });
  }
}

} // namespace

std::vector<int> numbers_of_columns(const Epetra_CrsMatrix &A)
{
  std::vector<int> numbers(A.NumMyCols());
  if (A.Importer() == nullptr) { // looking for them takes longer
    std::iota(numbers.begin(), numbers.end(), 0);
    return numbers;
  }
  int next = A.DomainMap().NumMyElements();
  for (unsigned int k = 0; k < numbers.size(); ++k) {
    const int own = A.DomainMap().LID(A.GCID(k));
    numbers[k] = own >= 0 ? own : next++;
  }
  return numbers;
}

namespace {

double largest_entry(const Epetra_CrsMatrix &A)
{
  int n = 0;
  double *values = nullptr, largest = 0;
  for (int row = 0; row < A.NumMyRows(); ++row) {
    A.ExtractMyRowView(row, n, values);
    for (int k = 0; k < n; ++k)
      largest = std::max(largest, std::abs(values[k]));
  }
  return largest > 0 ? largest : 1;
}

} // namespace

void round_to_single_precision(Epetra_CrsMatrix &P)
{
  const double unit = largest_entry(P);
  int n = 0;
  double *values = nullptr;
  for (int row = 0; row < P.NumMyRows(); ++row) {
    P.ExtractMyRowView(row, n, values);
    for (int k = 0; k < n; ++k)
      values[k] = unit * static_cast<float>(values[k] / unit);
  }
}

RowPattern::RowPattern(const Epetra_CrsMatrix &A, const bool is_symmetric) : symmetric(is_symmetric)
{
  const RowReader reader(A, is_symmetric);
  std::vector<std::pair<int, int>> entries;
  std::vector<int> columns;
  const int n_rows = A.NumMyRows();
  const auto for_groups = [&](const auto &add) { // two passes, as memory is precious
    number_of_rows = 0;
    for (int row = 0; row <= n_rows; ++row) {
      const bool may_be_same = row < n_rows && row > 0 && row - number_of_rows < most_rows;
      if (may_be_same && reader.is_like_the_one_before(row))
        continue;
      if (row < n_rows)
        reader.read(row, entries);
      const bool is_same = may_be_same && std::equal(entries.begin(), entries.end(), columns.begin(),
                                                     columns.end(), [](const auto &entry, const int column) {
                                                       return entry.first == column;
                                                     });
      if (is_same)
        continue;
      if (row > 0)
        add(row - number_of_rows);
      number_of_rows = row;
      columns.clear();
      for (const auto &[column, place] : entries)
        columns.push_back(column);
    }
  };
  std::size_t n_groups = 0, n_blocks = 0;
  const int n_own = A.DomainMap().NumMyElements();
  const auto leave_out_lower = [&]() {
    if (symmetric)
      columns.erase(columns.begin(), std::lower_bound(columns.begin(), columns.end(), number_of_rows));
  };
  for_groups([&](const int n) {
    leave_out_lower();
    ++n_groups;
    n_blocks += columns.size() / block_length(columns, number_of_rows, n, n_own, symmetric);
  });
  groups.reserve(n_groups);
  blocks.reserve(n_blocks);
  for_groups([&](const int n) {
    leave_out_lower();
    const int length = block_length(columns, number_of_rows, n, n_own, symmetric), size = columns.size();
    const auto end_of_own = std::lower_bound(columns.begin(), columns.end(), n_own);
    groups.push_back({blocks.size(), number_of_entries, number_of_rows, length, size,
                      static_cast<int>(end_of_own - columns.begin())});
    for (int k = 0; k < size; k += length)
      blocks.push_back(columns[k]);
    largest_number_of_columns = std::max(largest_number_of_columns, size);
    number_of_entries += static_cast<std::size_t>(size) * n;
  });
}

std::size_t RowPattern::memory_consumption() const
{
  return groups.capacity() * sizeof(Stored) + blocks.capacity() * sizeof(int);
}

CompactMatrix::CompactMatrix(const Epetra_CrsMatrix &A, const bool is_symmetric)
    : range(A.RowMap()), exchange(A), pattern(std::make_shared<RowPattern>(A, is_symmetric))
{
  set_values(A, [](int) {});
}

CompactMatrix::CompactMatrix(std::unique_ptr<Epetra_CrsMatrix> A, const bool is_symmetric)
    : range(A->RowMap()), exchange(*A), pattern(std::make_shared<RowPattern>(*A, is_symmetric))
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
  const RowReader reader(A, pattern->is_symmetric());
  std::vector<std::pair<int, int>> entries;
  int n = 0;
  double *row_values = nullptr;
  unit = largest_entry(A);
  values.reserve(FourColumns::padded(pattern->n_entries()));
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    const RowPattern::Group group = pattern->group(g);
    values.resize(values.size() + static_cast<std::size_t>(group.columns.size) * group.n_rows);
    for (int i = 0; i < group.n_rows; ++i) {
      const int row = group.first_row + i;
      if (i == 0 || !reader.is_like_the_one_before(row))
        reader.read(row, entries);
      A.ExtractMyRowView(row, n, row_values);
      const auto *const entry =
          entries.data() + entries.size() - group.columns.size; // without the lower ones
      for (int k = 0; k < group.columns.size; ++k)
        values[group.first_entry + FourColumns::place(i, k, group.n_rows, group.columns.size)] =
            entry[k].second < 0 ? 0 : static_cast<float>(row_values[entry[k].second] / unit);
    }
    done(group.first_row + group.n_rows);
  }
  values.resize(FourColumns::padded(pattern->n_entries()), 0);
}

void CompactMatrix::multiply(Epetra_Vector &y, const Epetra_Vector &x) const
{
  std::vector<double> others, buffer(FourColumns::padded(pattern->most_columns()));
  const double *const of_columns = exchange.of_columns(x, others);
  if (pattern->is_symmetric()) {
    std::vector<double> sums(buffer.size());
    multiply_symmetric(*pattern, values.data(), unit, of_columns, y.Values(), buffer.data(), sums.data());
  } else
    dovetail::multiply(*pattern, values.data(), unit, of_columns, y.Values(), buffer.data());
}

void CompactMatrix::multiply_transposed(Epetra_Vector &y, const Epetra_Vector &x) const
{
  if (pattern->is_symmetric()) {
    multiply(y, x);
    return;
  }
  std::vector<double> sums(exchange.n_columns(), 0.), buffer(FourColumns::padded(pattern->most_columns()));
  add_transposed(*pattern, values.data(), unit, x.Values(), sums.data(), buffer.data());
  exchange.add_up(sums, y);
}

void CompactMatrix::diagonal(Epetra_Vector &result) const
{
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    const RowPattern::Group group = pattern->group(g);
    for (int i = 0; i < group.n_rows; ++i)
      result[group.first_row + i] =
          unit * values[group.first_entry + FourColumns::place(i, i, group.n_rows, group.columns.size)];
  }
}

std::size_t CompactMatrix::memory_consumption() const
{
  return pattern->memory_consumption() + values.capacity() * sizeof(float);
}

} // namespace dovetail
