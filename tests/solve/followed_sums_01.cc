// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rows that follow each other, on any number of ranks alike. 60 rows: each third one is left. Row 0 is
// prescribed (the sum of nothing), and the others form chains that change the rank with each row: row i is
// half of row i + 3, which is such a sum itself, and half of the row i - i % 3, which is left. So row 3 m + 1
// is sum_{k=m}^{18} 2^{m-k-1} x_k + 2^{m-19} x_19, x_k being row 3 k. Prints the largest error of weights and
// the sum of the weights of row 4. Then two rows follow each other in a circle.
//
// ranks: 1, 2, 3

#include "../../source/solve/followed_sums.h"

#include <deal.II/base/mpi.h>

#include <Epetra_MpiComm.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <vector>

using namespace dovetail;

namespace {

const int n = 60;

/// What row is the sum of: (row, weight).
std::vector<std::pair<int, double>> sum_of(const int row, const bool has_circle)
{
  if (row == 0)
    return {};
  if (row % 3 == 0)
    return {{row, 1.}};
  if (has_circle && (row == 1 || row == n - 1))
    return {{row == 1 ? n - 1 : 1, 0.5}, {30, 0.5}};
  const int left = row - row % 3;
  return row + 3 < n ? std::vector<std::pair<int, double>>{{row + 3, 0.5}, {left, 0.5}}
                     : std::vector<std::pair<int, double>>{{left, 1.}};
}

/// Weights of rows that are left, by their number.
double weight(const int row, const int of)
{
  if (row % 3 == 0)
    return row == of ? 1 : 0;
  const int first = row / 3, k = of / 3, last = n / 3 - 1;
  if (of == 0 || k < first)
    return 0;
  return k < last ? std::pow(0.5, k - first + 1) : std::pow(0.5, last - first);
}

void follow(const Epetra_Map &rows, const bool has_circle)
{
  RowSums sums;
  Epetra_IntVector number(rows);
  for (int i = 0; i < rows.NumMyElements(); ++i) {
    const int row = rows.GID(i);
    sums.add_row(sum_of(row, has_circle));
    number[i] = row % 3 == 0 && row != 0 ? row : -1;
  }
  FollowedSums followed(std::move(sums), rows, number);
  double error = 0, of_row_4 = 0;
  std::vector<int> columns;
  std::vector<double> weights;
  for (int i = 0; i < rows.NumMyElements(); ++i) {
    followed.read(i, columns, weights);
    const int row = rows.GID(i);
    for (int of = 0; of < n && row > 0; of += 3) {
      const auto found = std::find(columns.begin(), columns.end(), of);
      const double here = found == columns.end() ? 0 : weights[found - columns.begin()];
      error = std::max(error, std::abs(here - weight(row, of)));
    }
    for (unsigned int k = 0; k < weights.size() && row == 4; ++k)
      of_row_4 += weights[k];
  }
  error = dealii::Utilities::MPI::max(error, MPI_COMM_WORLD);
  of_row_4 = dealii::Utilities::MPI::sum(of_row_4, MPI_COMM_WORLD);
  const bool circles = dealii::Utilities::MPI::max(int(followed.has_circles()), MPI_COMM_WORLD) > 0;
  if (rows.Comm().MyPID() == 0) {
    std::cout << "circles: " << (circles ? "yes" : "no") << "\n";
    if (!has_circle)
      std::cout << "errors below 1e-15: " << (error < 1e-15 ? "yes" : "no")
                << ", weights of row 4: " << of_row_4 << "\n";
  }
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const Epetra_MpiComm communicator(MPI_COMM_WORLD);
  std::vector<int> own; // a chain changes its rank with each row
  for (int row = 0; row < n; ++row)
    if (row / 3 % communicator.NumProc() == communicator.MyPID())
      own.push_back(row);
  const Epetra_Map rows(n, own.size(), own.data(), 0, communicator);
  follow(rows, false);
  follow(rows, true);
}
