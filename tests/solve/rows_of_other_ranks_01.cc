// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rows of other ranks come as their owners give them, in the order in which they are asked for: row i has i %
// 4 columns and two values for each of them.
//
// ranks: 1, 2, 3

#include "../system/scene_model.h"

#include <dovetail/solve/rows_of_other_ranks.h>

#include <Epetra_MpiComm.h>

using namespace test;

namespace {

RowOfOtherRank row_with(const int number)
{
  RowOfOtherRank row;
  for (int k = 0; k < number % 4; ++k) {
    row.columns.push_back(10 * number + k);
    row.values.insert(row.values.end(), {number + 0.25 * k, -1. * k});
  }
  return row;
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const Epetra_MpiComm communicator(MPI_COMM_WORLD);
  const Epetra_Map rows(30, 0, communicator);
  std::vector<int> wanted;
  for (int number = rows.NumGlobalElements() - 1; number >= 0; number -= 3)
    if (!rows.MyGID(number))
      wanted.push_back(number);
  const auto found = rows_of_other_ranks(rows, wanted, [&](const int row, auto &columns, auto &values) {
    RowOfOtherRank own = row_with(rows.GID(row));
    columns = own.columns;
    values = own.values;
  });
  bool are_right = found.size() == wanted.size();
  for (unsigned int i = 0; i < wanted.size() && are_right; ++i) {
    const RowOfOtherRank expected = row_with(wanted[i]);
    are_right = found[i].columns == expected.columns && found[i].values == expected.values;
  }
  report("rows are those of their owners",
         dealii::Utilities::MPI::min(are_right ? 1 : 0, MPI_COMM_WORLD) == 1);
}
