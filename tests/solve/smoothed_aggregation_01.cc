// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Smoothed aggregation as preconditioner of CG for -div(grad u) by finite differences on 26^3 nodes (17 576
// rows, some of them prescribed), with one row for each node and with three, and with modes of which some are
// zero or depend on others: M is symmetric (difference relative to its size below 1e-12), and the residual
// falls by 1e-10 within 12 iterations. The levels of more ranks differ, because aggregates do not cross them.
// The second level of the first matrix has about 2500 rows: three ranks, which would have less than 1000
// each, leave them to the first one, two ranks keep theirs.
//
// ranks: 1, 2, 3

#include "../../source/solve/smoothed_aggregation.h"

#include <deal.II/base/mpi.h>

#include <Epetra_MpiComm.h>

#include <cmath>
#include <iostream>

using namespace dovetail;

namespace {

const int n = 26;

/// -div grad with u = 0 outside; the nodes with k = 0 are prescribed. Each node has some rows of the same
/// kind.
Epetra_CrsMatrix make_matrix(const Epetra_Map &rows, const int rows_per_node)
{
  Epetra_CrsMatrix A(Copy, rows, 7);
  const auto is_prescribed = [](const int node) { return node % n == 0; };
  for (int row = 0; row < rows.NumMyElements(); ++row) {
    const int node = rows.GID(row) / rows_per_node, component = rows.GID(row) % rows_per_node;
    const int place[3] = {node % n, node / n % n, node / n / n}, step[3] = {1, n, n * n};
    std::vector<int> columns = {rows.GID(row)};
    std::vector<double> values = {6. + component};
    for (int d = 0; d < 3; ++d)
      for (const int sign : {-1, 1})
        if (const int other = node + sign * step[d];
            place[d] + sign >= 0 && place[d] + sign < n && !is_prescribed(node) && !is_prescribed(other)) {
          columns.push_back(other * rows_per_node + component);
          values.push_back(-1 - component / 6.);
        }
    A.InsertGlobalValues(rows.GID(row), columns.size(), values.data(), columns.data());
  }
  A.FillComplete(rows, rows);
  return A;
}

double product(const Epetra_Vector &a, const Epetra_Vector &b)
{
  double result = 0;
  a.Dot(b, &result);
  return result;
}

/// For A x = b from zero.
unsigned int iterations(const Epetra_CrsMatrix &A, const Cycle &M, const Epetra_Vector &b)
{
  Epetra_Vector r(b), z(b), p(b), q(b);
  M.vmult(z, r);
  p = z;
  double rz = product(r, z);
  const double goal = 1e-10 * std::sqrt(product(b, b));
  unsigned int count = 0;
  while (std::sqrt(product(r, r)) > goal && count < 100) {
    A.Multiply(false, p, q);
    const double alpha = rz / product(p, q);
    r.Update(-alpha, q, 1.);
    M.vmult(z, r);
    const double next = product(r, z);
    p.Update(1., z, next / rz);
    rz = next;
    ++count;
  }
  return count;
}

struct Inspected : SmoothedAggregation
{
  using SmoothedAggregation::SmoothedAggregation;

  int n_ranks_with_rows() const
  {
    int here = coarsest().NumMyRows() > 0 ? 1 : 0, result = 0;
    coarsest().Comm().SumAll(&here, &result, 1);
    return result;
  }
};

void check(const std::string &name, const int rows_per_node, const int n_modes)
{
  const Epetra_MpiComm communicator(MPI_COMM_WORLD);
  const int n_nodes = n * n * n, n_ranks = communicator.NumProc(), rank = communicator.MyPID();
  const int n_own = (n_nodes * (rank + 1) / n_ranks - n_nodes * rank / n_ranks) * rows_per_node;
  const Epetra_Map rows(-1, n_own, 0, communicator);
  const Epetra_CrsMatrix A = make_matrix(rows, rows_per_node);
  const auto modes =
      std::make_shared<Epetra_MultiVector>(rows, n_modes); // the constants, then their copies, then zeros
  for (int mode = 0; mode < n_modes; ++mode)
    for (int row = 0; row < n_own; ++row)
      (*modes)[mode][row] = mode < 2 * rows_per_node && row % rows_per_node == mode % rows_per_node ? 1 : 0;
  const Inspected M(A, modes, [](const LevelEntries &level, const Cycle::LevelFacts &) {
    return ChebyshevSmoother::with_diagonal(level, {2, 10});
  });

  Epetra_Vector a(rows), b(rows), Ma(rows), Mb(rows);
  for (int row = 0; row < n_own; ++row) {
    a[row] = std::sin(1 + rows.GID(row));
    b[row] = std::cos(3. * rows.GID(row));
  }
  M.vmult(Ma, a);
  M.vmult(Mb, b);
  const double asymmetry =
      std::abs(product(a, Mb) - product(b, Ma)) / std::sqrt(product(a, Ma) * product(b, Mb));
  const unsigned int count = iterations(A, M, b);
  const int n_coarse = M.n_ranks_with_rows(), n_expected = n_ranks == 3 && n_modes == 1 ? 1 : n_ranks;
  if (rank == 0)
    std::cout << name << ": symmetric " << (asymmetry < 1e-12 ? "yes" : "no, " + std::to_string(asymmetry))
              << ", iterations " << (count <= 12 ? "few" : std::to_string(count))
              << ", ranks of the coarsest matrix "
              << (n_coarse == n_expected ? "as expected" : std::to_string(n_coarse)) << std::endl;
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check("one row for each node", 1, 1);
  check("three rows for each node, six modes", 3, 6);
  check("one row for each node, a mode twice and one that is zero", 1, 3);
}
