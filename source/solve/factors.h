// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The factors of a matrix of all ranks that is small or belongs to surfaces.

#pragma once

#include <Epetra_CrsMatrix.h>

#include <memory>

class Amesos_BaseSolver;
class Epetra_LinearProblem;

namespace dovetail {

class MumpsFactors;

/// Of a symmetric matrix. Up to 2000 rows KLU factorises on the first rank; more, as those of surfaces, are
/// left to MUMPS.
///
/// T. A. Davis, E. Palamadai Natarajan: Algorithm 907: KLU, a direct sparse solver for circuit simulation
/// problems, 2010.
class Factors
{
public:
  /// @throw std::exception if a pivot is zero. Collective.
  explicit Factors(std::unique_ptr<Epetra_CrsMatrix> A);
  explicit Factors(const Epetra_CrsMatrix &A); ///< by reference
  ~Factors();

  /// x = A^-1 b on the own rows. Collective.
  void solve(double *x, const double *b) const;

private:
  void factorise();

  std::unique_ptr<Epetra_CrsMatrix> owned; ///< nullptr, or A
  const Epetra_CrsMatrix &A;
  std::unique_ptr<Epetra_LinearProblem> problem;
  std::unique_ptr<Amesos_BaseSolver> solver; ///< or
  std::unique_ptr<MumpsFactors> mumps;
};

} // namespace dovetail
