// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "lines_into_bodies.h"

#include <dovetail/solve/rows_of_other_ranks.h>

#include <Epetra_Comm.h>
#include <Epetra_Import.h>
#include <Epetra_Map.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace dovetail {

namespace {

/// Rows that follow each other, by their global numbers, from the interface on. Of each of them its diagonal
/// entry, and the coupling with the row before it.
struct LineOfRows
{
  struct Coupling
  {
    unsigned int later, earlier;
    double entry;
  };

  std::vector<int> rows;
  std::vector<double> diagonal, coupling;
  std::vector<Coupling> further; ///< of rows that do not follow each other
  bool is_open = true;

  void append(const int row, const double its_diagonal, const double its_coupling)
  {
    rows.push_back(row);
    diagonal.push_back(its_diagonal);
    coupling.push_back(its_coupling);
  }
  void go_on(const RowOfOtherRank &tip);
  std::vector<double> weights() const;
  double energy(const std::vector<double> &weights) const;
};

/// @param tip the row at the end: of each column the entry, and what the diagonal entry of its row is; 0 if
/// no line may go there
void LineOfRows::go_on(const RowOfOtherRank &tip)
{
  const double strong = 0.3; // 1/2 in cells that are thin, 1/4 in squares of two triangles
  double largest = strong;
  const unsigned int n = rows.size();
  unsigned int next = tip.columns.size();
  for (unsigned int k = 0; k < tip.columns.size(); ++k) {
    const double entry = tip.values[2 * k], its_diagonal = tip.values[2 * k + 1];
    const unsigned int place = std::find(rows.begin(), rows.end(), tip.columns[k]) - rows.begin();
    const double strength = its_diagonal > 0 ? -entry / std::sqrt(diagonal.back() * its_diagonal) : 0;
    if (place + 2 < n && entry != 0)
      further.push_back({n - 1, place, entry});
    else if (place == n && strength > largest) {
      largest = strength;
      next = k;
    }
  }
  is_open = next < tip.columns.size();
  if (is_open)
    append(tip.columns[next], tip.values[2 * next + 1], tip.values[2 * next]);
}

/// One on the interface, and from there on what the line minimises its energy with.
std::vector<double> LineOfRows::weights() const
{
  std::vector<double> ratio(rows.size(), 1.); // to the weight before
  double pivot = 0;
  for (unsigned int l = rows.size(); l-- > 1;) {
    pivot = diagonal[l] + (l + 1 < rows.size() ? coupling[l + 1] * ratio[l + 1] : 0);
    ratio[l] = pivot > -coupling[l] ? -coupling[l] / pivot : 1;
  }
  for (unsigned int l = 1; l < ratio.size(); ++l)
    ratio[l] *= ratio[l - 1];
  return ratio;
}

double LineOfRows::energy(const std::vector<double> &weights) const
{
  double sum = weights[0] * diagonal[0] * weights[0];
  for (unsigned int l = 1; l < rows.size(); ++l)
    sum += weights[l] * (diagonal[l] * weights[l] + 2 * coupling[l] * weights[l - 1]);
  for (const Coupling &c : further)
    sum += 2 * weights[c.later] * c.entry * weights[c.earlier];
  return sum;
}

std::vector<LineOfRows> find_lines(const Epetra_CrsMatrix &A, const Epetra_Vector &diagonal,
                                   const Epetra_Vector &on_interface)
{
  const unsigned int most_rows = 50;
  Epetra_Vector may_follow(diagonal), of_columns(A.ColMap());
  std::vector<LineOfRows> lines;
  for (int row = 0; row < diagonal.MyLength(); ++row)
    if (on_interface[row] > 0) {
      may_follow[row] = 0;
      lines.emplace_back();
      lines.back().append(A.GRID(row), diagonal[row], 0.);
      lines.back().is_open = diagonal[row] > 0;
    } else if (A.NumMyEntries(row) <= 1) // it follows others, or is prescribed
      may_follow[row] = 0;
  of_columns.Import(may_follow, Epetra_Import(A.ColMap(), A.RowMap()), Insert);
  const auto read = [&](const int row, std::vector<int> &columns, std::vector<double> &values) {
    int n = 0, *local = nullptr;
    double *entries = nullptr;
    A.ExtractMyRowView(row, n, entries, local);
    columns.clear();
    values.clear();
    for (int k = 0; k < n; ++k) {
      columns.push_back(A.GCID(local[k]));
      values.insert(values.end(), {entries[k], of_columns[local[k]]});
    }
  };
  int n_open = 1;
  for (unsigned int length = 1; length < most_rows && n_open > 0; ++length) {
    std::vector<int> of_others;
    for (const LineOfRows &line : lines)
      if (line.is_open && !A.MyGRID(line.rows.back()))
        of_others.push_back(line.rows.back());
    const auto rows_of_others = rows_of_other_ranks(A.RowMap(), of_others, read);
    RowOfOtherRank own;
    unsigned int next = 0;
    int mine = 0;
    for (LineOfRows &line : lines)
      if (line.is_open) {
        const int row = A.LRID(line.rows.back());
        if (row >= 0)
          read(row, own.columns, own.values);
        line.go_on(row >= 0 ? own : rows_of_others[next++]);
        mine += line.is_open ? 1 : 0;
      }
    A.Comm().SumAll(&mine, &n_open, 1);
  }
  return lines;
}

} // namespace

LinesIntoBodies find_lines_into_bodies(const Epetra_CrsMatrix &A, const Epetra_Vector &diagonal,
                                       const Epetra_Vector &on_interface)
{
  const double least_share = 1e-6; // rounding leaves more
  LinesIntoBodies lines{std::make_unique<Epetra_CrsMatrix>(Copy, A.RowMap(), 0), diagonal};
  for (const LineOfRows &line : find_lines(A, diagonal, on_interface)) {
    const std::vector<double> weights = line.weights();
    lines.transposed->InsertGlobalValues(line.rows[0], weights.size(), weights.data(), line.rows.data());
    lines.stiffness[A.LRID(line.rows[0])] = std::max(line.energy(weights), least_share * line.diagonal[0]);
  }
  lines.transposed->FillComplete(A.OperatorDomainMap(), A.RowMap());
  Epetra_Vector ones(A.RowMap()), sums(A.OperatorDomainMap());
  ones.PutScalar(1.);
  lines.transposed->Multiply(true, ones, sums);
  for (int row = 0; row < sums.MyLength(); ++row)
    sums[row] = 1 / std::max(sums[row], 1.); // lines that meet
  lines.transposed->RightScale(sums);
  return lines;
}

} // namespace dovetail
