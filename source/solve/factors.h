// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The factors of a matrix of all ranks that is small, or belongs to surfaces or to functions of degree one.

#pragma once

#include <Epetra_CrsMatrix.h>

#include <memory>
#include <vector>

class Amesos_BaseSolver;
class Epetra_LinearProblem;

namespace dovetail {

class MumpsFactors;

/// How thin bodies are: nodes across them beside those across a cube of @p n_rows vectors; 1 in 2D or if
/// they are not known.
double thin_share(double n_rows, unsigned int dim, double nodes_across);
/// What the factors of a symmetric matrix take, in units of ExpectedCost: with nested dissection n^2
/// operations for a cube in 3D, and (m n)^(3/2) where there are fewer nodes m across.
///
/// J. A. George: Nested dissection of a regular finite element mesh, 1973.
/// @param nodes_across 0: not known
double work_of_factors(double n_rows, unsigned int dim, double nodes_across);

/// Up to 2000 rows KLU factorises on the first rank; more are left to MUMPS.
///
/// T. A. Davis, E. Palamadai Natarajan: Algorithm 907: KLU, a direct sparse solver for circuit simulation
/// problems, 2010.
class Factors
{
public:
  /// @throw std::exception if a pivot is zero or memory is missing, on all ranks. Collective.
  explicit Factors(std::unique_ptr<Epetra_CrsMatrix> A, bool is_symmetric = true);
  explicit Factors(const Epetra_CrsMatrix &A, bool is_symmetric = true); ///< by reference
  /// The same, where @p first_row of each node is known, and the number of rows at the end; empty: they are
  /// not.
  Factors(const Epetra_CrsMatrix &A, const std::vector<int> &first_row);
  ~Factors();

  /// x = A^-1 b on the own rows. Collective.
  void solve(double *x, const double *b) const { solve(x, b, false); }
  void solve_transposed(double *x, const double *b) const { solve(x, b, !is_symmetric); } ///< x = A^-T b

private:
  void factorise(const std::vector<int> &first_row = {});
  void solve(double *x, const double *b, bool by_transposed) const;

  std::unique_ptr<Epetra_CrsMatrix> owned; ///< nullptr, or A
  const Epetra_CrsMatrix &A;
  const bool is_symmetric;
  std::unique_ptr<Epetra_LinearProblem> problem;
  std::unique_ptr<Amesos_BaseSolver> solver; ///< or
  std::unique_ptr<MumpsFactors> mumps;
};

} // namespace dovetail
