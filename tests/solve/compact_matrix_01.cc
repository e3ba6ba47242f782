// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Matrices of multigrid's levels in little memory, against Epetra's in double precision, on a line of nodes
// with two components each: products and diagonals (relative differences at most 1e-6), and bytes per entry:
// with three nodes in a row, at most 9 of a matrix, and 10 of a prolongation from every third node. Epetra
// takes 12 at least.
//
// ranks: 1, 2, 3

#include "../../source/solve/compact_matrix.h"
#include "../system/scene_model.h"

#include <dovetail/solve/prolongation.h>

#include <deal.II/base/mpi.h>

#include <Epetra_MpiComm.h>

#include <algorithm>
#include <cmath>
#include <string>

using namespace dovetail;

namespace {

const int n_nodes = 3001, n_components = 2;

Epetra_Map make_map(const int n, const int per_node)
{
  const Epetra_MpiComm communicator(MPI_COMM_WORLD);
  const int p = communicator.NumProc(), rank = communicator.MyPID();
  return Epetra_Map(-1, (n * (rank + 1) / p - n * rank / p) * per_node, 0, communicator);
}

/// Full blocks of two rows.
Epetra_CrsMatrix make_matrix(const Epetra_Map &rows)
{
  Epetra_CrsMatrix A(Copy, rows, 6);
  for (int i = 0; i < rows.NumMyElements(); ++i) {
    const int row = rows.GID(i), node = row / n_components;
    for (int other = std::max(node - 1, 0); other <= std::min(node + 1, n_nodes - 1); ++other)
      for (int c = 0; c < n_components; ++c) {
        const int column = other * n_components + c;
        const double value = 1e11 * (row == column ? 5 + std::sin(row) : -0.7 + 0.2 * std::cos(row + column));
        A.InsertGlobalValues(row, 1, &value, &column);
      }
  }
  A.FillComplete(rows, rows);
  return A;
}

/// From every third node, linearly; the first node is prescribed.
Epetra_CrsMatrix make_prolongation(const Epetra_Map &rows, const Epetra_Map &coarse)
{
  Epetra_CrsMatrix P(Copy, rows, 2);
  for (int i = 0; i < rows.NumMyElements(); ++i) {
    const int node = rows.GID(i) / n_components, c = rows.GID(i) % n_components;
    for (int k = 0; k < 2; ++k)
      if (const double weight = k == 0 ? 1 - node % 3 / 3. : node % 3 / 3.; weight > 0 && node > 0) {
        const int column = (node / 3 + k) * n_components + c;
        P.InsertGlobalValues(rows.GID(i), 1, &weight, &column);
      }
  }
  P.FillComplete(coarse, rows);
  return P;
}

double relative_difference(const Epetra_Vector &a, const Epetra_Vector &b)
{
  Epetra_Vector difference(a);
  difference.Update(-1., b, 1.);
  double norm = 0, of_difference = 0;
  b.Norm2(&norm);
  difference.Norm2(&of_difference);
  return of_difference / norm;
}

Epetra_Vector make_vector(const Epetra_Map &map)
{
  Epetra_Vector x(map);
  for (int i = 0; i < x.MyLength(); ++i)
    x[i] = 1 + std::sin(2. * map.GID(i));
  return x;
}

template <typename Compact>
void compare_products(const std::string &name, const Compact &compact, const Epetra_CrsMatrix &A,
                      const double most_bytes)
{
  const Epetra_Vector x = make_vector(A.DomainMap()), z = make_vector(A.RangeMap());
  Epetra_Vector y(A.RangeMap()), exact(y), y_transposed(A.DomainMap()), exact_transposed(y_transposed);
  compact.multiply(y, x);
  A.Multiply(false, x, exact);
  compact.multiply_transposed(y_transposed, z);
  A.Multiply(true, z, exact_transposed);
  test::report(name + ", product", relative_difference(y, exact), 1e-6);
  test::report(name + ", transposed", relative_difference(y_transposed, exact_transposed), 1e-6);
  double bytes = compact.memory_consumption(), all_bytes = 0;
  A.Comm().SumAll(&bytes, &all_bytes, 1);
  test::report(name + ", bytes per entry", all_bytes / A.NumGlobalNonzeros(), most_bytes);
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const Epetra_Map rows = make_map(n_nodes, n_components), coarse = make_map(n_nodes / 3 + 1, n_components);
  const Epetra_CrsMatrix A = make_matrix(rows), P = make_prolongation(rows, coarse),
                         square = make_prolongation(rows, rows); // some columns are empty
  const CompactMatrix compact(A);
  compare_products("matrix", compact, A, 9);
  compare_products("prolongation", Prolongation(P), P, 10);
  compare_products("square prolongation", CompactMatrix(square, false), square, 30);
  Epetra_Vector diagonal(rows), exact(rows);
  compact.diagonal(diagonal);
  A.ExtractDiagonalCopy(exact);
  test::report("diagonal", relative_difference(diagonal, exact), 1e-6);
}
