// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The factors of a matrix of all ranks by MUMPS, those of a small one on the first rank alone.

#pragma once

#include <Epetra_CrsMatrix.h>
#include <dmumps_c.h>
#include <mpi.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace dovetail {

/// The factors of one matrix after the other of the same structure. Functions are collective.
class MumpsFactors
{
public:
  MumpsFactors(const MPI_Comm &communicator, int n_rows, bool is_symmetric, bool has_small_pivots);
  ~MumpsFactors() { call(-2); }
  MumpsFactors(const MumpsFactors &) = delete;
  MumpsFactors &operator=(const MumpsFactors &) = delete;

  /// Take the entries of the own rows. @return whether their pattern is that of the last analysis; not
  /// collective
  bool take(const Epetra_CrsMatrix &A);
  /// @param rows_of_nodes of the own rows, which nested_dissection() may order; empty: MUMPS orders them
  void analyse(const std::vector<int> &rows_of_nodes);
  bool are_symmetric() const { return is_symmetric; } ///< L D L^T
  bool suit(int n_rows, bool symmetric) const;        ///< and are not to be made anew
  /// What factorise() will need on this rank, in MiB, estimated from above. @pre analyse()
  double memory() const { return takes_part ? (mumps.info[14] + 1) * 1e6 / (1024 * 1024) : 0; }
  double memory_on_machine() const; ///< and on the ranks that share a machine with this one
  void factorise();
  void solve(double *x, const double *b, bool by_transposed = false);
  /// Of D, as many as eigenvalues of the matrix are negative (Sylvester). @pre are_symmetric()
  unsigned long n_negative_pivots() const { return n_negative; }
  bool has_negative_determinant() const { return is_negative; } ///< @pre not are_symmetric()

private:
  void call(const int job)
  {
    mumps.job = job;
    if (takes_part)
      dmumps_c(&mumps);
  }
  int global_result(int k) const; ///< INFOG(k)
  void check() const
  {
    if (const int error = global_result(1); error < 0)
      throw std::runtime_error("MUMPS gives error " + std::to_string(error));
  }
  std::vector<int> order_of_elimination(const std::vector<int> &rows_of_nodes) const;
  template <typename Number>
  std::vector<Number> gather(const std::vector<Number> &own, MPI_Datatype type) const;

  MPI_Comm communicator;
  bool is_symmetric, is_first, is_small, takes_part, is_analysed = false;
  DMUMPS_STRUC_C mumps = {};
  std::vector<int> rows, columns; ///< from 1, of the entries; of a symmetric matrix the upper triangle
  std::vector<double> entries;
  std::vector<int> all_rows, all_columns; ///< of a small matrix, on the first rank
  std::vector<double> all_entries;
  unsigned long n_negative = 0;
  bool is_negative = false; ///< the determinant
  int n_own = 0;            ///< rows
  std::vector<int> n_of_rank, first_of_rank;
};

} // namespace dovetail
