// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Single rows of a matrix, or of what is no matrix yet, that other ranks have.

#pragma once

#include <Epetra_CrsMatrix.h>
#include <Epetra_Map.h>

#include <functional>
#include <vector>

namespace dovetail {

/// Numbers and values of a row, in the order in which its owner gives them, perhaps several values per
/// number.
struct RowOfOtherRank
{
  std::vector<int> columns;
  std::vector<double> values;
};

/// An own row of a matrix, by global columns.
void read_row(const Epetra_CrsMatrix &A, int row, std::vector<int> &columns, std::vector<double> &values);

/// The rows with the global numbers @p wanted, which other ranks own. Collective.
/// @param read gives an own row, by its local number
std::vector<RowOfOtherRank> rows_of_other_ranks(
    const Epetra_Map &rows, const std::vector<int> &wanted,
    const std::function<void(int row, std::vector<int> &columns, std::vector<double> &values)> &read);

} // namespace dovetail
