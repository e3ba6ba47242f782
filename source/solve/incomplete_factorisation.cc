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

/// A row of blocks: D^-1, and the columns and entries of W.
struct BlockRow
{
  BlockRow(const RowPattern::Group &group, const float *const inverse)
      : first_row(group.first_row), n_rows(group.n_rows), inverse(inverse),
        columns(group.columns.from(n_rows)), entries(inverse + n_rows * n_rows)
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

/// (I + W)^T v = z, D^-1 v in the place of z, then (I + W) z = D^-1 v. No row waits for a product with D^-1.
DOVETAIL_WIDEST_VECTORS void sweep(const RowPattern &pattern, const std::size_t *const first,
                                   const float *const entries, double *const z, double *const buffer)
{
  const std::ptrdiff_t ahead = 1024;
  for (unsigned int g = 0; g < pattern.n_groups(); ++g) {
    const BlockRow k(pattern.group(g), entries + first[g]);
    prefetch(k.entries, std::size_t(k.columns.size) * k.n_rows, ahead);
    with_constant(
        k.n_rows, [&](const auto n) __attribute__((always_inline)) {
          double factors[n];
          for (int i = 0; i < n; ++i)
            factors[i] = -z[k.first_row + i];
          add_rows<n>(k.columns, k.entries, factors, z, buffer);
          multiply_block<n>(k.inverse, z + k.first_row);
        });
  }
  for (unsigned int g = pattern.n_groups(); g-- > 0;) {
    const BlockRow k(pattern.group(g), entries + first[g]);
    prefetch(k.entries, std::size_t(k.columns.size) * k.n_rows, -ahead);
    with_constant(
        k.n_rows, [&](const auto n) __attribute__((always_inline)) {
          double sums[n];
          multiply_rows<n>(k.columns, k.entries, z, sums, buffer);
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
    n_entries += static_cast<std::size_t>(group.n_own) * group.n_rows;
  }
  entries.resize(FourColumns::padded(n_entries), 0);
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    const RowPattern::Group group = pattern->group(g);
    const int n = group.n_rows;
    float *const block = entries.data() + first[g];
    const float *const values = A.values.data() + group.first_entry;
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < group.n_own; ++k)
        block[k * n + i] = values[FourColumns::place(i, k, n, group.columns.size)];
      float &diagonal = block[i * n + i];
      diagonal = diagonal == 0 ? 1 : static_cast<float>((1 + shift) * diagonal); // of an empty row
    }
  }
}

/// Block row by block row: D_i and U_ij lose U_ki^T D_k^-1 U_ki and U_ki^T D_k^-1 U_kj, k < i < j. U_k is
/// held column by column until W_k takes its place.
void IncompleteFactorisation::factorise()
{
  std::vector<unsigned int> group_of_row(pattern->n_rows());
  for (unsigned int g = 0; g < pattern->n_groups(); ++g)
    std::fill_n(group_of_row.begin() + pattern->group(g).first_row, pattern->group(g).n_rows, g);
  std::vector<int> position(pattern->n_rows(), -1), columns; // of a column in block row k
  std::vector<float> upper, products;                        // U_k and W_k = D_k^-1 U_k
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    float *const block = entries.data() + first[g];
    const BlockRow k(pattern->group(g), block);
    const int size = k.columns.size;
    invert(block, k.n_rows);
    upper.assign(k.entries, k.entries + static_cast<std::size_t>(size) * k.n_rows);
    products.assign(upper.size(), 0);
    columns.clear();
    for_columns(k.columns, [&](int, const int column) { columns.push_back(column); });
    with_known_number(k.n_rows, [&](const auto n) {
      for (int q = 0; q < size; ++q) {
        position[columns[q]] = q;
        for (int c = 0; c < n; ++c)
          for (int r = 0; r < n; ++r)
            products[q * n + r] += k.inverse[c * n + r] * upper[q * n + c];
      }
      for (int begin = 0, end = 0; begin < size; begin = end) { // the columns of one group
        const unsigned int i = group_of_row[columns[begin]];
        while (end < size && group_of_row[columns[end]] == i)
          ++end;
        const RowPattern::Group other = pattern->group(i);
        RowPattern::Columns of_other = other.columns;
        of_other.size -= other.columns.size - other.n_own;
        float *const target = entries.data() + first[i] - other.first_row;
        for_columns(of_other, [&](const int q, const int column) {
          if (const int here = position[column]; here >= 0)
            for (int p = begin; p < end; ++p) {
              float sum = 0;
              for (int r = 0; r < n; ++r)
                sum += upper[p * n + r] * products[here * n + r];
              target[q * other.n_rows + columns[p]] -= sum;
            }
        });
      }
      for (int q = 0; q < size; ++q) {
        position[columns[q]] = -1;
        for (int r = 0; r < n; ++r)
          block[n * n + FourColumns::place(r, q, n, size)] = products[q * n + r];
      }
    });
  }
}

/// Sums in double precision.
void IncompleteFactorisation::vmult(double *const z, const double *const r) const
{
  for (int row = 0; row < pattern->n_rows(); ++row)
    z[row] = r[row] / unit;
  std::vector<double> buffer(FourColumns::padded(pattern->most_columns()));
  sweep(*pattern, first.data(), entries.data(), z, buffer.data());
}

std::size_t IncompleteFactorisation::memory_consumption() const
{
  return first.capacity() * sizeof(std::size_t) + entries.capacity() * sizeof(float);
}

} // namespace dovetail
