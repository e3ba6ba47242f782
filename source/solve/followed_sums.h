// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rows that are sums of rows that are sums.

#pragma once

#include <dovetail/solve/row_sums.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_IntVector.h>
#include <Epetra_Map.h>

#include <memory>
#include <vector>

namespace dovetail {

/// RowSums in which rows that are sums themselves are replaced, until only rows are left that are themselves.
/// Rows may follow each other in a circle: where a tie extends a field over a gap, an unknown of the tie
/// follows one beside it, which may be a mean of unknowns of the tie. What comes around again is left out.
class FollowedSums
{
public:
  /// Collective.
  /// @param rows by reference
  /// @param number of each of the rows that are left; -1: another one
  FollowedSums(RowSums &&sums, const Epetra_Map &rows, const Epetra_IntVector &number);
  ~FollowedSums();

  /// The numbers of those that an own row is the sum of, and their weights.
  void read(int row, std::vector<int> &columns, std::vector<double> &weights);
  bool has_circles() const { return has_circle; } ///< in what has been read on this rank

private:
  class OnOneRank;

  const Epetra_IntVector number;
  std::unique_ptr<OnOneRank> on_one_rank;
  std::unique_ptr<Epetra_CrsMatrix> all;              ///< on several ranks: the sums
  std::unique_ptr<Epetra_IntVector> number_of_column; ///< or its kind
  bool has_circle = false;
};

} // namespace dovetail
