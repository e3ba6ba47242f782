// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Matrices of multigrid's levels in little memory, against Epetra's in double precision, on a line of nodes
// with two components each (relative differences below 1e-6). An incomplete factorisation of a matrix whose
// factors have no further entries is exact on each rank: of a block tridiagonal one. Bytes per entry: 4 and
// half a column's 4 for a matrix, 4 more for its factors, and half of 8 for a prolongation; 12 for Epetra.
//
// ranks: 1, 2, 3

#include "../../source/solve/incomplete_factorisation.h"
#include "../../source/solve/interpolation.h"

#include <deal.II/base/mpi.h>

#include <Epetra_MpiComm.h>

#include <algorithm>
#include <cmath>
#include <iostream>
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

/// Blocks of two rows: full, and positive definite. Without couplings of ranks if @p with_others is false.
Epetra_CrsMatrix make_matrix(const Epetra_Map &rows, const bool with_others)
{
  Epetra_CrsMatrix A(Copy, rows, 6);
  for (int i = 0; i < rows.NumMyElements(); ++i) {
    const int row = rows.GID(i), node = row / n_components;
    for (int other = std::max(node - 1, 0); other <= std::min(node + 1, n_nodes - 1); ++other)
      for (int c = 0; c < n_components; ++c) {
        const int column = other * n_components + c;
        const double value = 1e11 * (row == column ? 5 + std::sin(row) : -0.7 + 0.2 * std::cos(row + column));
        if (with_others || rows.MyGID(column))
          A.InsertGlobalValues(row, 1, &value, &column);
      }
  }
  A.FillComplete(rows, rows);
  return A;
}

/// From every third node, linearly.
Epetra_CrsMatrix make_prolongation(const Epetra_Map &rows, const Epetra_Map &coarse)
{
  Epetra_CrsMatrix P(Copy, rows, 2);
  for (int i = 0; i < rows.NumMyElements(); ++i) {
    const int node = rows.GID(i) / n_components, c = rows.GID(i) % n_components;
    for (int k = 0; k < 2; ++k)
      if (const double weight = k == 0 ? 1 - node % 3 / 3. : node % 3 / 3.; weight > 0) {
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
void compare_products(const std::string &name, const Compact &compact, const Epetra_CrsMatrix &A)
{
  const Epetra_Vector x = make_vector(A.DomainMap()), z = make_vector(A.RangeMap());
  Epetra_Vector y(A.RangeMap()), exact(y), y_transposed(A.DomainMap()), exact_transposed(y_transposed);
  compact.multiply(y, x);
  A.Multiply(false, x, exact);
  compact.multiply_transposed(y_transposed, z);
  A.Multiply(true, z, exact_transposed);
  const double difference = relative_difference(y, exact),
               of_transposed = relative_difference(y_transposed, exact_transposed);
  double bytes = compact.memory_consumption(), all_bytes = 0;
  A.Comm().SumAll(&bytes, &all_bytes, 1);
  if (A.Comm().MyPID() == 0)
    std::cout << name << ": product " << (difference < 1e-6 ? "ok" : std::to_string(difference))
              << ", transposed " << (of_transposed < 1e-6 ? "ok" : std::to_string(of_transposed))
              << ", bytes per entry " << std::round(10 * all_bytes / A.NumGlobalNonzeros()) / 10 << std::endl;
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const Epetra_Map rows = make_map(n_nodes, n_components), coarse = make_map(n_nodes / 3 + 1, n_components);
  const Epetra_CrsMatrix A = make_matrix(rows, true), P = make_prolongation(rows, coarse);
  const CompactMatrix compact(A);
  compare_products("matrix", compact, A);
  compare_products("prolongation", Interpolation(P), P);

  Epetra_Vector diagonal(rows), exact(rows);
  compact.diagonal(diagonal);
  A.ExtractDiagonalCopy(exact);
  const Epetra_CrsMatrix own_part = make_matrix(rows, false);
  const Epetra_Vector x = make_vector(rows);
  Epetra_Vector b(rows), solution(rows);
  own_part.Multiply(false, x, b);
  IncompleteFactorisation(compact, 0).vmult(solution.Values(), b.Values());
  const double of_diagonal = relative_difference(diagonal, exact),
               of_solution = relative_difference(solution, x);
  IncompleteFactorisation(compact, 0).vmult(b.Values(), b.Values()); // in place
  const double of_places = relative_difference(b, solution);
  if (rows.Comm().MyPID() == 0)
    std::cout << "diagonal " << (of_diagonal < 1e-6 ? "ok" : std::to_string(of_diagonal)) << ", factors "
              << (of_solution < 1e-6 ? "ok" : std::to_string(of_solution)) << ", in place "
              << (of_places == 0 ? "ok" : std::to_string(of_places)) << std::endl;
}
