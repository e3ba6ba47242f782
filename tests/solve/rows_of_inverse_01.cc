// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Rows of the inverse of a mass matrix of 60 linear elements on a line, of which each seventh is a tenth as
// long: each row times the matrix is that of the identity, up to the tolerance beside the row's own entry,
// and has the fewer entries the larger the tolerance is. On any number of ranks alike.
//
// ranks: 1, 2, 3

#include "../../source/solve/rows_of_inverse.h"

#include "../system/scene_model.h"

#include <Epetra_Map.h>
#include <Epetra_MpiComm.h>
#include <Epetra_Vector.h>

using namespace test;

namespace {

const int n = 61;

double length(const int element)
{
  return element < 0 || element >= n - 1 ? 0 : element % 7 == 3 ? 0.1 : 1;
}

void check(const Epetra_CrsMatrix &D, const double tolerance)
{
  RowsOfInverse inverse(D, tolerance);
  std::vector<int> columns;
  std::vector<double> values;
  double error = 0, most = 0;
  for (int row = 0; row < D.NumMyRows(); ++row) {
    inverse.read(row, columns, values);
    most = std::max<double>(most, columns.size());
    std::vector<double> product(n, 0.);
    const auto mass = [](const int i) { return (length(i - 1) + length(i)) / 3; };
    for (unsigned int k = 0; k < columns.size(); ++k) {
      const int i = columns[k];
      product[i] += values[k] * mass(i);
      if (i > 0)
        product[i - 1] += values[k] * length(i - 1) / 6;
      if (i + 1 < n)
        product[i + 1] += values[k] * length(i) / 6;
    }
    product[D.GRID(row)] -= 1;
    for (int i = 0; i < n; ++i) // as if the diagonal were one
      error = std::max(error, std::abs(product[i]) * std::sqrt(mass(D.GRID(row)) / mass(i)));
  }
  report("tolerance " + std::to_string(tolerance), error, 4 * tolerance);
  most = dealii::Utilities::MPI::max(most, MPI_COMM_WORLD);
  if (is_rank_0())
    std::cout << "entries of a row, at most: " << most << std::endl;
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const Epetra_Map rows(n, 0, Epetra_MpiComm(MPI_COMM_WORLD));
  Epetra_CrsMatrix D(Copy, rows, 0);
  for (int i = 0; i < rows.NumMyElements(); ++i) {
    const int row = rows.GID(i);
    const auto insert = [&](const int column, const double value) {
      if (column >= 0 && column < n)
        D.InsertGlobalValues(row, 1, &value, &column);
    };
    insert(row, (length(row - 1) + length(row)) / 3);
    insert(row - 1, length(row - 1) / 6);
    insert(row + 1, length(row) / 6);
  }
  D.FillComplete();
  check(D, 1e-2);
  check(D, 1e-4);
  check(D, 1e-8);
}
