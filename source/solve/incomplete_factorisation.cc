// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "incomplete_factorisation.h"

#include "row_products.h"

#include <deal.II/base/exceptions.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace dovetail {

namespace {

/// A row of blocks: D^-1, and the columns and entries of U, row by row.
struct BlockRow
{
  BlockRow(const RowPattern::Group &group, const float *const inverse)
      : first_row(group.first_row), n_rows(group.n_rows), inverse(inverse),
        columns(group.columns.from(group.n_lower + n_rows)), entries(inverse + n_rows * n_rows)
  {
    columns.size -= group.columns.size - group.n_own;
  }

  int first_row, n_rows;
  const float *inverse;
  RowPattern::Columns columns;
  const float *entries;
};

/// The inverse of a symmetric positive definite block of n rows, in place, by Gauss and Jordan.
void invert(float *const block, const int n)
{
  const double smallest = 1e-6; // share of a diagonal entry that must be left, as single precision holds it
  std::array<double, RowPattern::most_rows * RowPattern::most_rows> a{};
  std::copy_n(block, n * n, a.begin());
  for (int k = 0; k < n; ++k) {
    const double pivot = a[k * n + k];
    AssertThrow(std::isfinite(pivot) && pivot > smallest * static_cast<double>(std::abs(block[k * n + k])),
                dealii::ExcMessage("The incomplete factorisation breaks down."));
    a[k * n + k] = 1;
    for (int j = 0; j < n; ++j)
      a[k * n + j] /= pivot;
    for (int i = 0; i < n; ++i)
      if (i != k) {
        const double factor = a[i * n + k];
        a[i * n + k] = 0;
        for (int j = 0; j < n; ++j)
          a[i * n + j] -= factor * a[k * n + j];
      }
  }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) // symmetric to the last digit
      block[i * n + j] = block[j * n + i] = static_cast<float>(a[i * n + j]);
}

/// From another block row, whose diagonal block is @p block, its share of those columns of block row k from
/// @p begin to @p end on: these are its rows.
void subtract(const BlockRow &k, const int begin, const int end, const std::vector<float> &products,
              const std::vector<int> &position, const RowPattern::Group &other, float *const block)
{
  const BlockRow row(other, block);
  const int size = k.columns.size, n = other.n_rows;
  const auto subtract_at = [&](const int here, float *const target, const int stride) {
    for (int p = begin; p < end; ++p) {
      float sum = 0;
      for (int r = 0; r < k.n_rows; ++r)
        sum += k.entries[r * size + p] * products[r * size + here];
      target[(k.columns[p] - other.first_row) * stride] -= sum;
    }
  };
  for (int p = begin; p < end; ++p)
    subtract_at(p, block + (k.columns[p] - other.first_row), n);
  for_columns(
      row.columns, [&](const int q, const int column) __attribute__((always_inline)) {
        if (position[column] >= 0)
          subtract_at(position[column], block + n * n + q, row.columns.size);
      });
}

/// v = D^-1 v
template <int n>
DOVETAIL_PART_OF_CALLER void multiply_block(const float *const inverse, double *const v)
{
  double sum[n] = {};
  for (int c = 0; c < n; ++c)
    for (int i = 0; i < n; ++i)
      sum[i] += v[c] * static_cast<double>(inverse[c * n + i]);
  std::copy_n(sum, n, v);
}

/// (D + U)^T D^-1 v = z, v in the place of z, then z + D^-1 U z = v.
DOVETAIL_WIDEST_VECTORS void sweep(const RowPattern &pattern, const std::size_t *const first,
                                   const float *const entries, double *const z, double *const buffer)
{
  for (unsigned int g = 0; g < pattern.n_groups(); ++g) {
    const BlockRow k(pattern.group(g), entries + first[g]);
    with_constant(
        k.n_rows, [&](const auto n) __attribute__((always_inline)) {
          multiply_block<n>(k.inverse, z + k.first_row);
          combine_rows<n>(k.entries, k.columns.size, z + k.first_row, buffer);
        });
    for_columns(
        k.columns, [&](const int q, const int column)
                       __attribute__((always_inline)) { z[column] -= buffer[q]; });
  }
  for (unsigned int g = pattern.n_groups(); g-- > 0;) {
    const BlockRow k(pattern.group(g), entries + first[g]);
    gather(k.columns, z, buffer);
    with_constant(
        k.n_rows, [&](const auto n) __attribute__((always_inline)) {
          double sums[n];
          multiply_rows<n>(k.entries, k.columns.size, buffer, sums);
          multiply_block<n>(k.inverse, sums);
          for (int i = 0; i < n; ++i)
            z[k.first_row + i] -= sums[i];
        });
  }
}

} // namespace

IncompleteFactorisation::IncompleteFactorisation(const CompactMatrix &A, const double shift)
    : pattern(A.pattern), unit(A.unit)
{
  copy_upper(A, shift);
  factorise();
}

void IncompleteFactorisation::copy_upper(const CompactMatrix &A, const double shift)
{
  std::size_t n_entries = 0;
  first.reserve(pattern->n_groups());
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    const RowPattern::Group group = pattern->group(g);
    first.push_back(n_entries);
    n_entries += static_cast<std::size_t>(group.n_own - group.n_lower) * group.n_rows;
  }
  entries.resize(Lanes::padded(n_entries), 0);
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    const RowPattern::Group group = pattern->group(g);
    const int n = group.n_rows, n_upper = group.n_own - group.n_lower - n;
    float *const block = entries.data() + first[g], *const upper = block + n * n;
    for (int i = 0; i < n; ++i) {
      const float *const row = A.values.data() + group.first_entry +
                               static_cast<std::size_t>(i) * group.columns.size + group.n_lower;
      std::copy_n(row, n, block + i * n);
      std::copy_n(row + n, n_upper, upper + i * n_upper);
      float &diagonal = block[i * n + i];
      diagonal = diagonal == 0 ? 1 : static_cast<float>((1 + shift) * diagonal); // of an empty row
    }
  }
}

/// Block row by block row: D_i and U_ij lose U_ki^T D_k^-1 U_ki and U_ki^T D_k^-1 U_kj, k < i < j.
void IncompleteFactorisation::factorise()
{
  std::vector<unsigned int> group_of_row(pattern->n_rows());
  for (unsigned int g = 0; g < pattern->n_groups(); ++g)
    std::fill_n(group_of_row.begin() + pattern->group(g).first_row, pattern->group(g).n_rows, g);
  std::vector<int> position(pattern->n_rows(), -1); // of a column in block row k
  std::vector<float> products;                      // D_k^-1 U_k, row by row
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    const BlockRow k(pattern->group(g), entries.data() + first[g]);
    const int size = k.columns.size;
    invert(entries.data() + first[g], k.n_rows);
    products.assign(static_cast<std::size_t>(size) * k.n_rows, 0);
    for (int r = 0; r < k.n_rows; ++r)
      for (int c = 0; c < k.n_rows; ++c)
        for (int q = 0; q < size; ++q)
          products[r * size + q] += k.inverse[r * k.n_rows + c] * k.entries[c * size + q];
    for (int q = 0; q < size; ++q)
      position[k.columns[q]] = q;
    for (int begin = 0, end = 0; begin < size; begin = end) { // the columns of one group
      const unsigned int i = group_of_row[k.columns[begin]];
      while (end < size && group_of_row[k.columns[end]] == i)
        ++end;
      subtract(k, begin, end, products, position, pattern->group(i), entries.data() + first[i]);
    }
    for (int q = 0; q < size; ++q)
      position[k.columns[q]] = -1;
  }
}

/// Sums in double precision.
void IncompleteFactorisation::vmult(double *const z, const double *const r) const
{
  for (int row = 0; row < pattern->n_rows(); ++row)
    z[row] = r[row] / unit;
  std::vector<double> buffer(Lanes::padded(pattern->most_columns()));
  sweep(*pattern, first.data(), entries.data(), z, buffer.data());
}

std::size_t IncompleteFactorisation::memory_consumption() const
{
  return first.capacity() * sizeof(std::size_t) + entries.capacity() * sizeof(float);
}

} // namespace dovetail
