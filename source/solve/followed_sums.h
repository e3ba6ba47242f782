// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rows that are sums of rows that are sums.

#pragma once

#include <dovetail/solve/row_sums.h>

#include <Epetra_IntVector.h>
#include <Epetra_Map.h>

#include <unordered_map>
#include <utility>
#include <vector>

namespace dovetail {

/// RowSums in which rows that are sums themselves are replaced when they are read, until only rows are left
/// that are themselves. Rows may follow each other in a circle: where a tie extends a field over a gap, an
/// unknown of the tie follows one beside it, which may be a mean of unknowns of the tie. What comes around
/// again is left out.
class FollowedSums
{
public:
  /// Collective.
  /// @param rows by reference
  /// @param number of each of the rows that are left; -1: another one
  FollowedSums(RowSums &&sums, const Epetra_Map &rows, const Epetra_IntVector &number);

  /// The numbers of those that an own row is the sum of, and their weights.
  void read(int row, std::vector<int> &columns, std::vector<double> &weights);
  bool has_circles() const { return has_circle; } ///< in what has been read on this rank

private:
  std::vector<int> unknown_columns(unsigned int first_place) const;
  void add_rows_of_others(const std::vector<int> &wanted);
  int place(int global_row) const;
  bool is_itself(int global_row) const { return sums.is_only(place(global_row), global_row); }
  void expand(int global_row);
  template <typename Visit>
  void for_sum(int place, const Visit &visit) const;

  const Epetra_Map &rows;
  RowSums sums;            ///< by place: of own rows, and of those of other ranks that they follow
  std::vector<int> number; ///< by place
  std::unordered_map<int, int> place_of_other;
  std::vector<bool> is_done; ///< by place: it has been expanded, or is being so
  std::unordered_map<int, std::vector<std::pair<int, double>>> replaced; ///< by place
  bool has_circle = false;
};

} // namespace dovetail
