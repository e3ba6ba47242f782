// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Products of the rows of a group of a RowPattern, for functions with the widest vectors of the processor.
// The entries of each row follow each other in single precision; sums are in double precision. What a product
// needs of a vector is gathered in a buffer, so that four entries are multiplied at a time, in any row.

#pragma once

#include "compact_matrix.h"

#include <dovetail/widest_vectors.h>

#include <algorithm>
#include <cstddef>
#include <type_traits>

namespace dovetail {

/// The numbers that are multiplied at a time.
struct FourColumns
{
  static constexpr int number = 4;
  typedef double Doubles __attribute__((vector_size(32)));
  typedef double InMemory __attribute__((vector_size(32), aligned(8), may_alias));

  /// How long a buffer is, or an array, of which so many numbers more are read and multiplied by zero.
  static std::size_t padded(const std::size_t n) { return n + number; }
  /// Where the entry of row @p i and column @p k of n_rows * size ones is.
  static std::size_t place(const int i, const int k, const int n_rows, const int size)
  {
    const int first = k / number * number, n_columns = std::min(number, size - first);
    return static_cast<std::size_t>(first) * n_rows + i * n_columns + (k - first);
  }
};

/// Calls @p action(n) with a constant for any number of rows of a group.
template <typename Action>
DOVETAIL_PART_OF_CALLER void with_constant(const int n, const Action &action)
{
  static_assert(RowPattern::most_rows == 8, "one case for each number");
  switch (n) {
  case 1:
    action(std::integral_constant<int, 1>());
    break;
  case 2:
    action(std::integral_constant<int, 2>());
    break;
  case 3:
    action(std::integral_constant<int, 3>());
    break;
  case 4:
    action(std::integral_constant<int, 4>());
    break;
  case 5:
    action(std::integral_constant<int, 5>());
    break;
  case 6:
    action(std::integral_constant<int, 6>());
    break;
  case 7:
    action(std::integral_constant<int, 7>());
    break;
  default:
    action(std::integral_constant<int, 8>());
  }
}

/// Calls @p action(k, column) for the columns of a group in turn, k = 0, 1, ...
template <typename Action>
DOVETAIL_PART_OF_CALLER void for_columns(const RowPattern::Columns &columns, const Action &action)
{
  const auto for_blocks = [&](const auto length) __attribute__((always_inline))
  {
    const int *first = columns.first;
    for (int k = 0; k < columns.size; k += length, ++first)
      for (int i = 0; i < length; ++i)
        action(k + i, *first + i);
  };
  if (columns.block_length == 3)
    for_blocks(std::integral_constant<int, 3>());
  else if (columns.block_length == 6)
    for_blocks(std::integral_constant<int, 6>());
  else if (columns.block_length == 2)
    for_blocks(std::integral_constant<int, 2>());
  else
    for_blocks(std::integral_constant<int, 1>());
}

/// Asks for what is read soon, so many entries before or after the present ones.
DOVETAIL_PART_OF_CALLER void prefetch(const float *const entries, const std::size_t n,
                                      const std::ptrdiff_t ahead)
{
  const std::size_t per_line = 16;
  for (std::size_t k = 0; k < n; k += per_line)
    __builtin_prefetch(entries + k + ahead);
}

/// Calls @p action(k, entries, n) for the columns from k on, n of which are multiplied at a time.
template <int n_rows, typename Action>
DOVETAIL_PART_OF_CALLER void for_lanes(const float *entries, const int size, const Action &action)
{
  int k = 0;
  for (; k + FourColumns::number <= size; k += FourColumns::number, entries += FourColumns::number * n_rows)
    action(k, entries, std::integral_constant<int, FourColumns::number>());
  if (k < size)
    action(k, entries, size - k);
}

/// sum += factor * entries
template <typename Factor>
DOVETAIL_PART_OF_CALLER void add_lanes(FourColumns::Doubles &sum, const Factor &factor,
                                       const float *const entries)
{
  sum += factor * FourColumns::Doubles{entries[0], entries[1], entries[2], entries[3]};
}

/// sums = the products of n rows with x. A single row is not worth the buffer.
template <int n>
DOVETAIL_PART_OF_CALLER void multiply_rows(const RowPattern::Columns &columns, const float *const entries,
                                           const double *const x, double *const sums, double *const buffer)
{
  if constexpr (n == 1) {
    sums[0] = 0;
    for_columns(
        columns, [&](const int k, const int column) __attribute__((always_inline)) {
          sums[0] += x[column] * static_cast<double>(entries[k]);
        });
    return;
  }
  for_columns(
      columns, [&](const int k, const int column) __attribute__((always_inline)) { buffer[k] = x[column]; });
  *reinterpret_cast<FourColumns::InMemory *>(buffer + columns.size) = FourColumns::Doubles{};
  FourColumns::Doubles sum[n] = {};
  for_lanes<n>(
      entries,
      columns.size, [&](const int k, const float *const a, const auto width) __attribute__((always_inline)) {
        const FourColumns::Doubles of_columns = *reinterpret_cast<const FourColumns::InMemory *>(buffer + k);
        for (int i = 0; i < n; ++i)
          add_lanes(sum[i], of_columns, a + i * width);
      });
  for (int i = 0; i < n; ++i)
    sums[i] = (sum[i][0] + sum[i][2]) + (sum[i][1] + sum[i][3]);
}

/// y += the sum of n rows times factors
template <int n>
DOVETAIL_PART_OF_CALLER void add_rows(const RowPattern::Columns &columns, const float *const entries,
                                      const double *const factors, double *const y, double *const buffer)
{
  if constexpr (n == 1) {
    for_columns(
        columns, [&](const int k, const int column) __attribute__((always_inline)) {
          y[column] += factors[0] * static_cast<double>(entries[k]);
        });
    return;
  }
  for_lanes<n>(
      entries,
      columns.size, [&](const int k, const float *const a, const auto width) __attribute__((always_inline)) {
        FourColumns::Doubles sum = {};
        for (int i = 0; i < n; ++i)
          add_lanes(sum, factors[i], a + i * width);
        *reinterpret_cast<FourColumns::InMemory *>(buffer + k) = sum;
      });
  for_columns(
      columns, [&](const int k, const int column) __attribute__((always_inline)) { y[column] += buffer[k]; });
}

/// What the rows of a group of a symmetric matrix, which has nothing below the diagonal blocks, add to its
/// product with x: y = A x as soon as all groups have added.
template <int n>
DOVETAIL_PART_OF_CALLER void add_symmetric_rows(const RowPattern::Group &group, const float *const entries,
                                                const double *const x, double *const y, double *const buffer,
                                                double *const sums)
{
  RowPattern::Columns own = group.columns;
  own.size = group.n_own;
  if constexpr (n == 1) {
    const double factor = x[group.first_row];
    double sum = factor * static_cast<double>(entries[0]);
    for_columns(
        own.from(1), [&](const int k, const int column) __attribute__((always_inline)) {
          const double entry = entries[k + 1];
          sum += entry * x[column];
          y[column] += factor * entry;
        });
    for_columns(
        group.columns.from(group.n_own), [&](const int k, const int column) __attribute__((always_inline)) {
          sum += x[column] * static_cast<double>(entries[group.n_own + k]);
        });
    y[group.first_row] += sum;
    return;
  }
  for_columns(
      group.columns, [&](const int k, const int column)
                         __attribute__((always_inline)) { buffer[k] = x[column]; });
  *reinterpret_cast<FourColumns::InMemory *>(buffer + group.columns.size) = FourColumns::Doubles{};
  FourColumns::Doubles of_rows[n] = {};
  for_lanes<n>(
      entries, group.columns.size,
      [&](const int k, const float *const a, const auto width) __attribute__((always_inline)) {
        const FourColumns::Doubles of_columns = *reinterpret_cast<const FourColumns::InMemory *>(buffer + k);
        FourColumns::Doubles transposed = {};
        for (int i = 0; i < n; ++i) {
          const float *const row = a + i * width;
          const FourColumns::Doubles four{row[0], row[1], row[2], row[3]};
          of_rows[i] += of_columns * four;
          transposed += x[group.first_row + i] * four;
        }
        *reinterpret_cast<FourColumns::InMemory *>(sums + k) = transposed;
      });
  for (int i = 0; i < n; ++i) // the diagonal block comes first
    sums[i] = (of_rows[i][0] + of_rows[i][2]) + (of_rows[i][1] + of_rows[i][3]);
  for_columns(
      own, [&](const int k, const int column) __attribute__((always_inline)) { y[column] += sums[k]; });
}

} // namespace dovetail
