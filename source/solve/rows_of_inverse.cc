// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "rows_of_inverse.h"

#include <Epetra_Comm.h>
#include <Epetra_Map.h>

#include <cmath>
#include <set>
#include <unordered_map>

namespace dovetail {

RowsOfInverse::RowsOfInverse(const Epetra_CrsMatrix &D, const double tolerance) : tolerance(tolerance)
{
  RowOfOtherRank own;
  for (int row = 0; row < D.NumMyRows(); ++row) {
    read_row(D, row, own.columns, own.values);
    append(D.GRID(row), own);
  }
  add_rows_of_others(D);
  std::unordered_map<int, int> place_of;
  for (unsigned int place = 0; place < column.size(); ++place)
    place_of[column[place]] = place;
  root.assign(rows.size(), 1.);
  for (unsigned int place = 0; place < rows.size(); ++place)
    for (const auto &[other, value] : rows[place])
      if (other == column[place] && value > 0)
        root[place] = std::sqrt(value);
  for (unsigned int place = 0; place < rows.size(); ++place) {
    Entries scaled;
    for (const auto &[other, value] : rows[place])
      if (const auto found = place_of.find(other); found != place_of.end())
        scaled.emplace_back(found->second, value / (root[place] * root[found->second]));
    rows[place] = std::move(scaled);
  }
  for (auto *values : {&x, &r, &p, &q})
    values->assign(rows.size(), 0.);
  is_reached.assign(rows.size(), false);
}

void RowsOfInverse::append(const int global_row, const RowOfOtherRank &row)
{
  column.push_back(global_row);
  rows.emplace_back();
  for (unsigned int k = 0; k < row.columns.size(); ++k)
    rows.back().emplace_back(row.columns[k], row.values[k]);
}

/// Those that the steps may reach.
void RowsOfInverse::add_rows_of_others(const Epetra_CrsMatrix &D)
{
  if (D.Comm().NumProc() == 1)
    return;
  const auto read_own = [&D](const int row, std::vector<int> &columns, std::vector<double> &values) {
    read_row(D, row, columns, values);
  };
  std::set<int> known(column.begin(), column.end());
  unsigned int first = 0;
  for (unsigned int step = 0; step < most_steps; ++step) {
    std::vector<int> wanted;
    for (; first < rows.size(); ++first)
      for (const auto &[other, value] : rows[first])
        if (known.insert(other).second)
          wanted.push_back(other);
    int is_here = !wanted.empty(), is_anywhere = 0;
    D.Comm().MaxAll(&is_here, &is_anywhere, 1);
    if (is_anywhere == 0)
      return;
    unsigned int k = 0;
    for (const RowOfOtherRank &row : rows_of_other_ranks(D.RowMap(), wanted, read_own))
      append(wanted[k++], row);
  }
}

void RowsOfInverse::make_first(const int place)
{
  for (const int other : reached) {
    x[other] = r[other] = p[other] = q[other] = 0;
    is_reached[other] = false;
  }
  reached.assign(1, place);
  is_reached[place] = true;
  r[place] = p[place] = 1;
}

/// q = D^T p. @return p.q
double RowsOfInverse::multiply()
{
  for (const int place : reached)
    q[place] = 0;
  const unsigned int n = reached.size();
  for (unsigned int i = 0; i < n; ++i)
    if (const double value = p[reached[i]]; value != 0)
      for (const auto &[other, entry] : rows[reached[i]]) {
        if (!is_reached[other]) {
          is_reached[other] = true;
          reached.push_back(other);
        }
        q[other] += entry * value;
      }
  double product = 0;
  for (const int place : reached)
    product += p[place] * q[place];
  return product;
}

void RowsOfInverse::read(const int row, std::vector<int> &columns, std::vector<double> &values)
{
  make_first(row);
  double square = 1; // of r
  for (unsigned int step = 0; step < most_steps && square > tolerance * tolerance; ++step) {
    const double product = multiply();
    if (!(product > 0))
      break;
    const double length = square / product, last = square;
    square = 0;
    for (const int place : reached) {
      x[place] += length * p[place];
      r[place] -= length * q[place];
      square += r[place] * r[place];
    }
    for (const int place : reached)
      p[place] = r[place] + square / last * p[place];
  }
  if (x[row] == 0) // D is not positive there
    x[row] = 1;
  columns.clear();
  values.clear();
  for (const int place : reached)
    if (std::abs(x[place]) > tolerance * std::abs(x[row])) {
      columns.push_back(column[place]);
      values.push_back(x[place] / (root[row] * root[place]));
    }
}

} // namespace dovetail
