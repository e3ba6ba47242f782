// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The matrix of a coarser level, P^T A P by small dense blocks, against products with P, A and P^T (relative
// difference at most 1e-12), on 60 nodes in a row that are coupled with the next three on either side: of the
// three rows of a node, two have the same columns, and every seventh node has a prescribed row. P has one,
// three or six columns for each aggregate.
//
// ranks: 1, 2, 3

#include "../../source/solve/aggregate_products.h"
#include "../system/scene_model.h"

#include <deal.II/base/mpi.h>

#include <Epetra_MpiComm.h>

#include <cmath>
#include <cstdlib>
#include <string>

using namespace dovetail;

namespace {

const int n_nodes = 60, n_components = 3, reach = 3;

bool is_prescribed(const int row)
{
  return row % (7 * n_components) == 1;
}

/// The last component sees only itself in other nodes.
bool are_coupled(const int row, const int column)
{
  if (row == column)
    return true;
  if (is_prescribed(row) || is_prescribed(column) || std::abs(row / 3 - column / 3) > reach)
    return false;
  return row % 3 == column % 3 || row / 3 == column / 3 || (row % 3 != 2 && column % 3 != 2);
}

Epetra_CrsMatrix make_matrix(const Epetra_Map &rows)
{
  Epetra_CrsMatrix A(Copy, rows, 0);
  for (int i = 0; i < rows.NumMyElements(); ++i)
    for (int row = rows.GID(i), column = 0; column < n_nodes * n_components; ++column)
      if (are_coupled(row, column)) {
        const double value = row == column ? 20 + row % 5 : -0.5 + 0.3 * std::cos(row + column);
        A.InsertGlobalValues(row, 1, &value, &column);
      }
  A.FillComplete(rows, rows);
  return A;
}

double error_of_coarse_matrix(const Epetra_CrsMatrix &A, const int n_modes)
{
  Epetra_MultiVector modes(A.RowMap(), n_modes);
  for (int mode = 0; mode < n_modes; ++mode)
    for (int row = 0; row < modes.MyLength(); ++row)
      modes[mode][row] = std::cos(0.1 * (mode + 1) * A.GRID(row) + mode);
  const Aggregation aggregates = make_aggregation(A, modes, n_components);
  const auto P = smooth_bases(A, SparseRows(A), aggregates, 0.6);
  const auto coarse = sum_coarse_matrix(A, *P, n_modes)();
  Epetra_Vector x(P->DomainMap()), y(x), exact(x), Px(A.RowMap()), APx(A.RowMap());
  for (int row = 0; row < x.MyLength(); ++row)
    x[row] = std::sin(1. + x.Map().GID(row));
  coarse->Multiply(false, x, y);
  P->Multiply(false, x, Px);
  A.Multiply(false, Px, APx);
  P->Multiply(true, APx, exact);
  double norm = 0, error = 0;
  exact.Norm2(&norm);
  y.Update(-1., exact, 1.);
  y.Norm2(&error);
  return error / norm;
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const Epetra_MpiComm communicator(MPI_COMM_WORLD);
  const int p = communicator.NumProc(), rank = communicator.MyPID();
  const Epetra_Map rows(-1, (n_nodes * (rank + 1) / p - n_nodes * rank / p) * n_components, 0, communicator);
  const Epetra_CrsMatrix A = make_matrix(rows);
  for (const int n_modes : {1, 3, 6})
    test::report(std::to_string(n_modes) + " modes", error_of_coarse_matrix(A, n_modes), 1e-12);
}
