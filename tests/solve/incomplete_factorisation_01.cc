// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The incomplete factorisation of A, for 60 nodes in a row with one to three rows each and entries of the
// size of 1e30: it is exact where nothing fills in (relative error at most 1e-5, single precision), also in a
// matrix whose rows are all alike, and on each rank for its own rows and columns. In a grid of 12 x 12 nodes,
// the eigenvalues of M^-1 A lie between 0.1 and 1.5, M is symmetric to rounding (1e-12), and M holds about
// half of the entries. A diagonal block that is not positive definite is an error.
//
// ranks: 1, 2, 3

#include "../../source/solve/incomplete_factorisation.h"
#include "../system/scene_model.h"

#include <deal.II/base/mpi.h>

#include <Epetra_MpiComm.h>

#include <cmath>
#include <functional>
#include <iostream>
#include <string>

using namespace dovetail;

namespace {

/// Node i has 1 + i % 3 rows, or as many as given.
struct Nodes
{
  Nodes(const int n, const int n_rows) : communicator(MPI_COMM_WORLD)
  {
    for (int i = 0, row = 0; i < n; ++i) {
      first_row.push_back(row);
      size.push_back(n_rows > 0 ? n_rows : 1 + i % 3);
      row += size.back();
    }
    const int begin = n * communicator.MyPID() / communicator.NumProc(),
              end = n * (communicator.MyPID() + 1) / communicator.NumProc();
    for (int i = begin; i < end; ++i)
      own.push_back(i);
  }
  Epetra_Map rows() const
  {
    return {-1, first_row[own.back()] + size[own.back()] - first_row[own.front()], 0, communicator};
  }

  Epetra_MpiComm communicator;
  std::vector<int> first_row, size, own;
};

/// Symmetric and positive definite: -unit (1 + something small) between the components of neighbours.
Epetra_CrsMatrix make_matrix(const Nodes &nodes, const std::function<std::vector<int>(int)> &neighbours,
                             const double unit, const double diagonal)
{
  const Epetra_Map rows = nodes.rows();
  Epetra_CrsMatrix A(Copy, rows, 0);
  for (const int i : nodes.own)
    for (int r = 0; r < nodes.size[i]; ++r) {
      const int row = nodes.first_row[i] + r;
      std::vector<int> columns;
      std::vector<double> values;
      const auto add = [&](const int column, const double value) {
        columns.push_back(column);
        values.push_back(value * unit);
      };
      for (int c = 0; c < nodes.size[i]; ++c)
        add(nodes.first_row[i] + c, c == r ? diagonal : 0.3);
      for (const int j : neighbours(i))
        for (int c = 0; c < nodes.size[j]; ++c)
          add(nodes.first_row[j] + c, -0.5 + 0.1 * std::cos(row + nodes.first_row[j] + c));
      A.InsertGlobalValues(row, columns.size(), values.data(), columns.data());
    }
  A.FillComplete(rows, rows);
  return A;
}

std::vector<int> in_a_row(const int n, const int i)
{
  std::vector<int> result;
  for (const int j : {i - 1, i + 1})
    if (j >= 0 && j < n)
      result.push_back(j);
  return result;
}

/// The largest | M^-1 A x - x | over | x |, with the own rows and columns of A.
double error_of_inverse(const Epetra_CrsMatrix &A, const Approximation &M)
{
  Epetra_Vector x(A.DomainMap()), b(A.RangeMap()), z(b);
  for (int row = 0; row < x.MyLength(); ++row) {
    x[row] = std::sin(1 + x.Map().GID(row));
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    A.ExtractMyRowView(row, n, values, columns);
    for (int k = 0; k < n; ++k)
      if (const int own = A.DomainMap().LID(A.GCID(columns[k])); own >= 0)
        b[row] += values[k] * std::sin(1 + A.GCID(columns[k]));
  }
  M.vmult(z.Values(), b.Values());
  z.Update(-1., x, 1.);
  double error = 0, size = 0;
  z.NormInf(&error);
  x.NormInf(&size);
  return error / size;
}

void check_grid()
{
  const int n = 12;
  const Nodes nodes(n * n, 3);
  const auto neighbours = [](const int i) {
    std::vector<int> result;
    for (const int dx : {-1, 0, 1})
      for (const int dy : {-1, 0, 1})
        if (const int x = i % n + dx, y = i / n + dy;
            (dx != 0 || dy != 0) && x >= 0 && x < n && y >= 0 && y < n)
          result.push_back(y * n + x);
    return result;
  };
  const CompactMatrix A(make_matrix(nodes, neighbours, 1, 13));
  const IncompleteFactorisation M(A, 0.05);
  Epetra_Vector a(A.rows()), b(a), Ma(a), Mb(a), x(a), y(a);
  for (int row = 0; row < a.MyLength(); ++row) {
    a[row] = std::sin(1 + a.Map().GID(row));
    b[row] = std::cos(3. * a.Map().GID(row));
    x[row] = std::sin(1e4 * (1 + a.Map().GID(row)));
  }
  M.vmult(Ma.Values(), a.Values());
  M.vmult(Mb.Values(), b.Values());
  double ab = 0, ba = 0, aa = 0;
  a.Dot(Mb, &ab);
  b.Dot(Ma, &ba);
  a.Dot(Ma, &aa);
  test::report("M is symmetric", std::abs(ab - ba) / aa, 1e-12);

  double largest = 0; // by the power method
  for (unsigned int step = 0; step < 50; ++step) {
    A.multiply(y, x);
    M.vmult(x.Values(), y.Values());
    x.Norm2(&largest);
    x.Scale(1 / largest);
  }
  test::report("largest eigenvalue", std::abs(largest - 0.8), 0.7);
  // both hold half of the own entries; A has those of other ranks, too
  const double share = static_cast<double>(M.memory_consumption()) / A.memory_consumption();
  test::report("share of the memory", std::abs(share - 0.7), 0.15);
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const int n = 60;
  const auto row_of_nodes = [](const int i) { return in_a_row(n, i); };
  for (const int n_rows : {0, 1, 3}) {
    const Epetra_CrsMatrix A = make_matrix(Nodes(n, n_rows), row_of_nodes, 1e30, 8);
    test::report("row of nodes with " + std::to_string(n_rows) + " rows",
                 error_of_inverse(A, IncompleteFactorisation(CompactMatrix(A), 0)), 1e-5);
  }
  const auto everyone = [](const int i) {
    std::vector<int> result;
    for (int j = 0; j < 12; ++j)
      if (j != i)
        result.push_back(j);
    return result;
  };
  const Epetra_CrsMatrix full = make_matrix(Nodes(12, 2), everyone, 1, 30);
  test::report("full matrix", error_of_inverse(full, IncompleteFactorisation(CompactMatrix(full), 0)), 1e-5);
  check_grid();

  bool is_found = false;
  try {
    IncompleteFactorisation(CompactMatrix(make_matrix(Nodes(n, 3), row_of_nodes, 1, 0.2)), 0);
  } catch (const std::exception &) {
    is_found = true;
  }
  test::report("breakdown", is_found ? 0. : 1., 0.5);
}
