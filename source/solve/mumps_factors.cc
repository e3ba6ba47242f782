// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "mumps_factors.h"

#include <deal.II/base/mpi.h>

#include <utility>

namespace dovetail {

namespace {

/// ICNTL(@p k) and the like are numbered from 1.
int &control(DMUMPS_STRUC_C &mumps, const int k)
{
  return mumps.icntl[k - 1];
}

} // namespace

MumpsFactors::MumpsFactors(const MPI_Comm &communicator, const bool is_symmetric, const bool has_small_pivots)
    : communicator(communicator), is_symmetric(is_symmetric),
      is_first(dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
{
  const int symmetric = 2, with_this_rank = 1, silent = -1, distributed = 3;
  mumps.comm_fortran = MPI_Comm_c2f(communicator);
  mumps.sym = is_symmetric ? symmetric : 0;
  mumps.par = with_this_rank;
  call(-1);
  check();
  for (const int output : {1, 2, 3})
    control(mumps, output) = silent;
  control(mumps, 4) = 0;
  control(mumps, 18) = distributed;
  control(mumps, 14) =
      has_small_pivots ? 100 : 20; // more than estimated, in per cent, for pivots off the diagonal
}

bool MumpsFactors::take(const Epetra_CrsMatrix &A)
{
  std::vector<int> new_rows, new_columns;
  entries.clear();
  for (int row = 0; row < A.NumMyRows(); ++row) {
    int n = 0, *local = nullptr;
    double *values = nullptr;
    A.ExtractMyRowView(row, n, values, local);
    for (int k = 0; k < n; ++k)
      if (const int i = A.GRID(row), j = A.GCID(local[k]); j >= i || !is_symmetric) {
        new_rows.push_back(i + 1);
        new_columns.push_back(j + 1);
        entries.push_back(values[k]);
      }
  }
  const bool is_same = new_rows == rows && new_columns == columns;
  rows = std::move(new_rows);
  columns = std::move(new_columns);
  mumps.n = A.NumGlobalRows();
  mumps.nnz_loc = entries.size();
  mumps.irn_loc = rows.data();
  mumps.jcn_loc = columns.data();
  mumps.a_loc = entries.data();
  n_own = A.NumMyRows();
  return is_same && is_analysed;
}

void MumpsFactors::analyse()
{
  is_analysed = false;
  n_of_rank = dealii::Utilities::MPI::all_gather(communicator, n_own);
  first_of_rank.assign(1, 0);
  for (const int n : n_of_rank)
    first_of_rank.push_back(first_of_rank.back() + n);
  call(1);
  check();
  is_analysed = true;
}

void MumpsFactors::factorise()
{
  const int workspace_is_too_small = -9, integers_are_too_small = -8;
  for (unsigned int attempt = 0; attempt < 3; ++attempt) {
    call(2);
    const int error = mumps.infog[0];
    if (error != workspace_is_too_small && error != integers_are_too_small)
      break;
    control(mumps, 14) *= 10;
  }
  check();
}

void MumpsFactors::solve(double *x, const double *b)
{
  std::vector<double> all(is_first ? mumps.n : 0);
  MPI_Gatherv(b, n_own, MPI_DOUBLE, all.data(), n_of_rank.data(), first_of_rank.data(), MPI_DOUBLE, 0,
              communicator);
  mumps.rhs = all.data();
  call(3);
  check();
  MPI_Scatterv(all.data(), n_of_rank.data(), first_of_rank.data(), MPI_DOUBLE, x, n_own, MPI_DOUBLE, 0,
               communicator);
}

} // namespace dovetail
