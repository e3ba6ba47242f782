// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Nested dissection of vectors on a grid of 9 x 9 x 9 nodes, each of which is coupled with those beside it,
// and one of whose components is prescribed at every hundredth node. Every row has a place for itself, the
// rows of a node follow each other, and the factors have less than 0.75 times the entries that they have in
// the order of the grid, which are counted by eliminating one row after the other. Nodes are found by their
// columns; where an entry lacks, they must be known. MUMPS solves with this order to rounding, on several
// ranks, too, and where the matrix is small and one rank has the factors for all.
//
// ranks: 1, 2, 3

#include "../../source/solve/mumps_factors.h"
#include "../../source/solve/nested_dissection.h"

#include "../system/scene_model.h"

#include <Epetra_Map.h>
#include <Epetra_MpiComm.h>
#include <Epetra_Vector.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <set>
#include <string>
#include <vector>

using namespace test;

namespace {

const int n_components = 3;

/// Of n^3 nodes. @param lacks the entry of two components at a node
Epetra_CrsMatrix make_matrix(const int n, const Epetra_Comm &ranks, const bool lacks)
{
  const int n_nodes = n * n * n, p = ranks.NumProc(), rank = ranks.MyPID();
  const Epetra_Map rows(-1, (n_nodes * (rank + 1) / p - n_nodes * rank / p) * n_components, 0, ranks);
  const auto is_prescribed = [](const int row) { return row % 300 == 151; };
  Epetra_CrsMatrix A(Copy, rows, 0);
  for (int i = 0; i < rows.NumMyElements(); ++i) {
    const int row = rows.GID(i), node = row / n_components;
    const int x = node % n, y = node / n % n, z = node / n / n;
    for (int column = 0; column < n_nodes * n_components; ++column) {
      const int other = column / n_components;
      const bool is_near =
          std::abs(other % n - x) < 2 && std::abs(other / n % n - y) < 2 && std::abs(other / n / n - z) < 2;
      if (row != column && (!is_near || is_prescribed(row) || is_prescribed(column) ||
                            (lacks && node == other && (row + column) % n_components == 0)))
        continue;
      const double value = row == column ? 100 : std::cos(row + column);
      A.InsertGlobalValues(row, 1, &value, &column);
    }
  }
  A.FillComplete(rows, rows);
  return A;
}

/// Of the factors, below the diagonal. @param place of each row
double count_entries(const Epetra_CrsMatrix &A, const std::vector<int> &place)
{
  std::vector<std::set<int>> later(A.NumMyRows()); // by place
  for (int row = 0; row < A.NumMyRows(); ++row) {
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    A.ExtractMyRowView(row, n, values, columns);
    for (int k = 0; k < n; ++k)
      if (place[columns[k]] > place[row])
        later[place[row] - 1].insert(place[columns[k]] - 1);
  }
  double n_entries = 0;
  for (const std::set<int> &here : later) {
    n_entries += here.size();
    if (!here.empty()) // the first one sees the others from then on
      later[*here.begin()].insert(std::next(here.begin()), here.end());
  }
  return n_entries;
}

void check_order(const Epetra_CrsMatrix &A)
{
  const std::vector<int> nodes = rows_of_nodes(A);
  std::vector<int> rows, columns; // the upper triangle, from 1
  for (int row = 0; row < A.NumMyRows(); ++row) {
    int n = 0, *others = nullptr;
    double *values = nullptr;
    A.ExtractMyRowView(row, n, values, others);
    for (int k = 0; k < n; ++k)
      if (others[k] >= row) {
        rows.push_back(row + 1);
        columns.push_back(others[k] + 1);
      }
  }
  const std::vector<int> order = nested_dissection(nodes, rows, columns);
  std::vector<int> sorted = order, natural(A.NumMyRows());
  std::sort(sorted.begin(), sorted.end());
  std::iota(natural.begin(), natural.end(), 1);
  report("each row has a place", sorted == natural);
  int first = 0, n_apart = 0;
  for (const int n_rows : nodes) {
    for (int row = first + 1; row < first + n_rows; ++row)
      n_apart += order[row] == order[row - 1] + 1 ? 0 : 1;
    first += n_rows;
  }
  report("rows of a node follow each other", n_apart == 0 && first == A.NumMyRows());
  report("entries of the factors", count_entries(A, order) / count_entries(A, natural), 0.75);
}

double residual_of_mumps(const Epetra_CrsMatrix &A, const bool is_symmetric)
{
  const bool has_small_pivots = false;
  MumpsFactors factors(MPI_COMM_WORLD, A.NumGlobalRows(), is_symmetric, has_small_pivots);
  factors.take(A);
  factors.analyse(std::vector<int>(A.NumMyRows() / n_components, n_components));
  factors.factorise();
  Epetra_Vector x(A.RowMap()), b(A.RowMap()), r(A.RowMap());
  b.PutScalar(1.);
  factors.solve(x.Values(), b.Values());
  A.Multiply(false, x, r);
  r.Update(1., b, -1.);
  double norm = 0;
  r.NormInf(&norm);
  return norm;
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const Epetra_MpiComm all(MPI_COMM_WORLD), self(MPI_COMM_SELF);
  const Epetra_CrsMatrix A = make_matrix(9, self, false), B = make_matrix(9, self, true);
  check_order(A);
  report("an entry that lacks divides its node", rows_of_nodes(B).size() > 2 * 729);
  for (const int n : {8, 9}) {
    const Epetra_CrsMatrix distributed = make_matrix(n, all, true);
    for (const bool is_symmetric : {true, false})
      report(std::to_string(n) + (is_symmetric ? ", L D L^T" : ", L U"),
             residual_of_mumps(distributed, is_symmetric), 1e-12);
  }
}
