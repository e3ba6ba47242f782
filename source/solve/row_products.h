// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Products of the rows of a group of a RowPattern, for functions with the widest vectors of the processor.
// The entries of each row follow each other in single precision; sums are in double precision. What a product
// needs of a vector is gathered in a buffer, so that eight entries are multiplied at a time, in any row.

#pragma once

#include "compact_matrix.h"

#include <dovetail/widest_vectors.h>

#include <cstddef>

namespace dovetail {

/// The numbers that are multiplied at a time.
struct Lanes
{
  static constexpr int number = 8;
  typedef double Doubles __attribute__((vector_size(64), aligned(8), may_alias));
  typedef float Floats __attribute__((vector_size(32), aligned(4), may_alias));

  /// How long a buffer, or what is read of an array, may be.
  static std::size_t padded(const std::size_t n) { return n + number; }
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

/// buffer = x at the columns, and zeros after them
DOVETAIL_PART_OF_CALLER void gather(const RowPattern::Columns &columns, const double *const x,
                                    double *const buffer)
{
  for_columns(
      columns, [&](const int k, const int column) __attribute__((always_inline)) { buffer[k] = x[column]; });
  *reinterpret_cast<Lanes::Doubles *>(buffer + columns.size) = Lanes::Doubles{};
}

/// sums = the products of n rows of @p size entries with the buffer. Entries after them are multiplied by
/// zero.
template <int n>
DOVETAIL_PART_OF_CALLER void multiply_rows(const float *const entries, const int size,
                                           const double *const buffer, double *const sums)
{
  Lanes::Doubles sum[n] = {};
  for (int k = 0; k < size; k += Lanes::number) {
    const Lanes::Doubles x = *reinterpret_cast<const Lanes::Doubles *>(buffer + k);
    for (int i = 0; i < n; ++i)
      sum[i] += x * __builtin_convertvector(*reinterpret_cast<const Lanes::Floats *>(entries + i * size + k),
                                            Lanes::Doubles);
  }
  for (int i = 0; i < n; ++i) {
    const auto four = __builtin_shufflevector(sum[i], sum[i], 0, 1, 2, 3) +
                      __builtin_shufflevector(sum[i], sum[i], 4, 5, 6, 7);
    sums[i] = (four[0] + four[2]) + (four[1] + four[3]);
  }
}

/// buffer = the sum of n rows of @p size entries times factors
template <int n>
DOVETAIL_PART_OF_CALLER void combine_rows(const float *const entries, const int size,
                                          const double *const factors, double *const buffer)
{
  for (int k = 0; k < size; k += Lanes::number) {
    Lanes::Doubles sum = {};
    for (int i = 0; i < n; ++i)
      sum += factors[i] *
             __builtin_convertvector(*reinterpret_cast<const Lanes::Floats *>(entries + i * size + k),
                                     Lanes::Doubles);
    *reinterpret_cast<Lanes::Doubles *>(buffer + k) = sum;
  }
}

} // namespace dovetail
