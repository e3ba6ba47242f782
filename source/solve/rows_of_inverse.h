// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The inverse of a mass matrix, which decays within a few cells.

#pragma once

#include <dovetail/solve/rows_of_other_ranks.h>

#include <Epetra_CrsMatrix.h>

#include <utility>
#include <vector>

namespace dovetail {

/// Single rows of about D^-1, by conjugate gradients that begin in one row and reach one neighbour further in
/// each step. Entries of mass matrices decay from node to node, at a rate that depends on the element only.
///
/// S. Demko, W. F. Moss, P. W. Smith: Decay rates for inverses of band matrices, 1984.
class RowsOfInverse
{
public:
  /// @param D symmetric positive definite, or about so. @param tolerance of the residual; entries that are
  /// smaller, beside the diagonal one, are left out. Collective.
  RowsOfInverse(const Epetra_CrsMatrix &D, double tolerance);

  /// The global columns and values of an own row.
  void read(int row, std::vector<int> &columns, std::vector<double> &values);

private:
  using Entries = std::vector<std::pair<int, double>>; ///< place or global column, and value

  void append(int global_row, const RowOfOtherRank &row);
  void add_rows_of_others(const Epetra_CrsMatrix &D);
  double multiply();
  void make_first(int place);

  static constexpr unsigned int most_steps = 24;
  const double tolerance;
  std::vector<int> column;   ///< by place: its global number; own rows come first
  std::vector<Entries> rows; ///< by place, by the places of columns, scaled to a diagonal of one
  std::vector<double> root;  ///< by place: of the diagonal
  /// By place; zero where it is not reached.
  std::vector<double> x, r, p, q;
  std::vector<int> reached;
  std::vector<bool> is_reached;
};

} // namespace dovetail
