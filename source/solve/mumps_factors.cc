// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "mumps_factors.h"
#include "nested_dissection.h"

#include <dovetail/solve/free_memory.h>

#include <deal.II/base/mpi.h>

#include <cstddef>
#include <limits>
#include <new>
#include <numeric>
#include <utility>

namespace dovetail {

namespace {

/// More ranks send each other messages for longer than one of them computes.
bool are_few(const int n_rows, const MPI_Comm &communicator)
{
  const int few = 2000;
  return n_rows <= few && dealii::Utilities::MPI::n_mpi_processes(communicator) > 1;
}

/// ICNTL(@p k) and the like are numbered from 1.
int &control(DMUMPS_STRUC_C &mumps, const int k)
{
  return mumps.icntl[k - 1];
}

} // namespace

MumpsFactors::MumpsFactors(const MPI_Comm &communicator, const int n_rows, const bool is_symmetric,
                           const bool has_small_pivots)
    : communicator(communicator), is_symmetric(is_symmetric),
      is_first(dealii::Utilities::MPI::this_mpi_process(communicator) == 0),
      is_small(are_few(n_rows, communicator)), takes_part(is_first || !is_small)
{
  const int symmetric = 2, with_this_rank = 1, silent = -1, distributed = 3;
  mumps.comm_fortran = MPI_Comm_c2f(is_small ? MPI_COMM_SELF : communicator);
  mumps.sym = is_symmetric ? symmetric : 0;
  mumps.par = with_this_rank;
  call(-1);
  check();
  for (const int output : {1, 2, 3})
    control(mumps, output) = silent;
  control(mumps, 4) = 0;
  control(mumps, 18) = distributed;
  control(mumps, 33) = is_symmetric ? 0 : 1; // the determinant
  control(mumps, 14) =
      has_small_pivots ? 100 : 20; // more than estimated, in per cent, for pivots off the diagonal
}

bool MumpsFactors::suit(const int n_rows, const bool symmetric) const
{
  return symmetric == is_symmetric && are_few(n_rows, communicator) == is_small;
}

int MumpsFactors::global_result(const int k) const
{
  return is_small ? dealii::Utilities::MPI::broadcast(communicator, mumps.infog[k - 1]) : mumps.infog[k - 1];
}

/// Those of all ranks, on the first one.
template <typename Number>
std::vector<Number> MumpsFactors::gather(const std::vector<Number> &own, const MPI_Datatype type) const
{
  const int n = own.size();
  std::vector<int> n_of(n_of_rank.size()), first(1, 0);
  MPI_Gather(&n, 1, MPI_INT, n_of.data(), 1, MPI_INT, 0, communicator);
  for (const int n_there : n_of)
    first.push_back(first.back() + n_there);
  std::vector<Number> all;
  bool has_memory = true;
  try {
    all.resize(is_first ? first.back() : 0);
  } catch (const std::bad_alloc &) {
    has_memory = false;
  }
  if (!dealii::Utilities::MPI::broadcast(communicator, has_memory))
    throw std::bad_alloc();
  MPI_Gatherv(own.data(), n, type, all.data(), n_of.data(), first.data(), type, 0, communicator);
  return all;
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

/// On the first rank, elsewhere empty. Nodes of two rows gain nothing.
std::vector<int> MumpsFactors::order_of_elimination(const std::vector<int> &rows_of_nodes) const
{
  const double fewest_rows = 2.5; // of a node, on average
  const auto sum_up = [this](const std::size_t n) {
    return dealii::Utilities::MPI::sum(static_cast<double>(n), communicator);
  };
  const double n_nodes = sum_up(rows_of_nodes.size()),
               n_rows = sum_up(std::accumulate(rows_of_nodes.begin(), rows_of_nodes.end(), 0));
  if (n_rows != mumps.n || n_nodes * fewest_rows > mumps.n ||
      sum_up(rows.size()) > std::numeric_limits<int>::max())
    return {};
  try { // what lacks memory lacks it on all ranks, or on the first one after the others are done
    const std::vector<int> nodes = gather(rows_of_nodes, MPI_INT), of_entries = gather(rows, MPI_INT),
                           their_columns = gather(columns, MPI_INT);
    return is_first ? nested_dissection(nodes, of_entries, their_columns) : std::vector<int>();
  } catch (const std::bad_alloc &) {
    return {};
  }
}

void MumpsFactors::analyse(const std::vector<int> &rows_of_nodes)
{
  is_analysed = false;
  n_of_rank = dealii::Utilities::MPI::all_gather(communicator, n_own);
  first_of_rank.assign(1, 0);
  for (const int n : n_of_rank)
    first_of_rank.push_back(first_of_rank.back() + n);
  if (is_small) {
    all_rows = gather(rows, MPI_INT);
    all_columns = gather(columns, MPI_INT);
    mumps.nnz_loc = all_rows.size();
    mumps.irn_loc = all_rows.data();
    mumps.jcn_loc = all_columns.data();
  }
  std::vector<int> order = order_of_elimination(rows_of_nodes);
  const int given = 1, automatic = 7;
  control(mumps, 7) = order.empty() ? automatic : given;
  mumps.perm_in = order.data();
  if (!order.empty())
    give_back_freed_memory(); // before somebody looks how much is free
  call(1);
  mumps.perm_in = nullptr;
  check();
  is_analysed = true;
}

double MumpsFactors::memory_on_machine() const
{
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(communicator, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  const double sum = dealii::Utilities::MPI::sum(memory(), machine);
  MPI_Comm_free(&machine);
  return sum;
}

void MumpsFactors::factorise()
{
  const int workspace_is_too_small = -9, integers_are_too_small = -8;
  if (is_small) {
    all_entries = gather(entries, MPI_DOUBLE);
    mumps.nnz_loc = all_entries.size();
    mumps.irn_loc = all_rows.data();
    mumps.jcn_loc = all_columns.data();
    mumps.a_loc = all_entries.data();
  }
  for (unsigned int attempt = 0; attempt < 3; ++attempt) {
    call(2);
    const int error = global_result(1);
    if (error != workspace_is_too_small && error != integers_are_too_small)
      break;
    control(mumps, 14) *= 10;
  }
  check();
  n_negative = is_symmetric ? global_result(12) : 0;
  is_negative = !is_symmetric && dealii::Utilities::MPI::broadcast(communicator, mumps.rinfog[11] < 0);
}

void MumpsFactors::solve(double *x, const double *b, const bool by_transposed)
{
  control(mumps, 9) = by_transposed ? 0 : 1;
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
