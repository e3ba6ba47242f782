// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "incomplete_factorisation.h"

#include <deal.II/base/exceptions.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace dovetail {

namespace {

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

} // namespace

IncompleteFactorisation::IncompleteFactorisation(const CompactMatrix &A, const double shift)
    : pattern(A.pattern), unit(A.unit)
{
  copy_upper(A, shift);
  factorise();
}

IncompleteFactorisation::BlockRow IncompleteFactorisation::block_row(const unsigned int g) const
{
  const RowPattern::Group group = pattern->group(g);
  const int n = group.n_rows;
  const float *const inverse = entries.data() + first[g];
  return {group.first_row, n, inverse, group.n_own - group.n_lower - n, group.columns + group.n_lower + n,
          inverse + n * n};
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
  entries.resize(n_entries);
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    const RowPattern::Group group = pattern->group(g);
    const std::size_t n = group.n_rows, begin = group.first_entry + group.n_lower * n;
    std::copy_n(A.values.data() + begin, (group.n_own - group.n_lower) * n, entries.data() + first[g]);
    for (std::size_t i = 0; i < n; ++i) {
      float &diagonal = entries[first[g] + i * n + i];
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
  std::vector<float> products;                      // D_k^-1 U_k
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) {
    const BlockRow k = block_row(g);
    invert(entries.data() + first[g], k.n_rows);
    products.assign(static_cast<std::size_t>(k.n_columns) * k.n_rows, 0);
    with_known_number(k.n_rows, [&](const auto n) {
      for (int q = 0; q < k.n_columns; ++q) {
        position[k.columns[q]] = q;
        for (int c = 0; c < n; ++c)
          for (int r = 0; r < n; ++r)
            products[q * n + r] += k.inverse[c * n + r] * k.entries[q * n + c];
      }
      for (int begin = 0, end = 0; begin < k.n_columns; begin = end) { // the columns of one group
        const unsigned int i = group_of_row[k.columns[begin]];
        while (end < k.n_columns && group_of_row[k.columns[end]] == i)
          ++end;
        const RowPattern::Group other = pattern->group(i);
        float *target = entries.data() + first[i];
        for (int q = other.n_lower; q < other.n_own; ++q, target += other.n_rows)
          if (const int here = position[other.columns[q]]; here >= 0)
            for (int p = begin; p < end; ++p) {
              float sum = 0;
              for (int r = 0; r < n; ++r)
                sum += k.entries[p * n + r] * products[here * n + r];
              target[k.columns[p] - other.first_row] -= sum;
            }
      }
    });
    for (int q = 0; q < k.n_columns; ++q)
      position[k.columns[q]] = -1;
  }
}

/// Sums in double precision.
void IncompleteFactorisation::vmult(double *const z, const double *const r) const
{
  for (int row = 0; row < pattern->n_rows(); ++row)
    z[row] = r[row] / unit;
  std::array<double, RowPattern::most_rows> sum{};
  for (unsigned int g = 0; g < pattern->n_groups(); ++g) { // (D + U)^T D^-1 v = r, v in the place of z
    const BlockRow k = block_row(g);
    with_known_number(k.n_rows, [&](const auto n) {
      double *const v = z + k.first_row;
      sum.fill(0);
      for (int c = 0; c < n; ++c)
        for (int i = 0; i < n; ++i)
          sum[i] += v[c] * static_cast<double>(k.inverse[c * n + i]);
      std::copy_n(sum.begin(), static_cast<int>(n), v);
      const float *entry = k.entries;
      for (int q = 0; q < k.n_columns; ++q, entry += n) {
        double product = 0;
        for (int i = 0; i < n; ++i)
          product += sum[i] * static_cast<double>(entry[i]);
        z[k.columns[q]] -= product;
      }
    });
  }
  for (unsigned int g = pattern->n_groups(); g-- > 0;) { // z + D^-1 U z = v
    const BlockRow k = block_row(g);
    with_known_number(k.n_rows, [&](const auto n) {
      sum.fill(0);
      const float *entry = k.entries;
      for (int q = 0; q < k.n_columns; ++q, entry += n) {
        const double factor = z[k.columns[q]];
        for (int i = 0; i < n; ++i)
          sum[i] += factor * static_cast<double>(entry[i]);
      }
      for (int c = 0; c < n; ++c)
        for (int i = 0; i < n; ++i)
          z[k.first_row + i] -= sum[c] * static_cast<double>(k.inverse[c * n + i]);
    });
  }
}

std::size_t IncompleteFactorisation::memory_consumption() const
{
  return first.capacity() * sizeof(std::size_t) + entries.capacity() * sizeof(float);
}

} // namespace dovetail
