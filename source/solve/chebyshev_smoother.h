// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The smoother of multigrid's levels.

#pragma once

#include "level_operator.h"
#include "smoother.h"

#include <Epetra_CrsMatrix.h>
#include <Epetra_Vector.h>

#include <functional>
#include <memory>
#include <vector>

namespace dovetail {

/// z = M^-1 r, where M approximates a symmetric positive definite matrix A.
class Approximation
{
public:
  virtual ~Approximation() = default;
  /// On the own rows. z may be r.
  virtual void vmult(double *z, const double *r) const = 0;
};

/// M = diag(A)
class Diagonal : public Approximation
{
public:
  explicit Diagonal(const LevelOperator &A);
  void vmult(double *z, const double *r) const override;

private:
  std::vector<double> inverse;
};

/// M = LU, the incomplete factorisation without fill-in of the own rows and columns of A + shift diag(A), in
/// single precision. Without a shift it may be indefinite although A is not.
///
/// T. A. Manteuffel: An incomplete factorization technique for positive definite linear systems, 1980.
std::unique_ptr<Approximation> make_incomplete_factorisation(const Epetra_CrsMatrix &A, double shift);

/// Chebyshev iteration with M^-1 A on the upper part of its spectrum, [lambda / ratio, lambda]: symmetric,
/// and positive definite as long as no eigenvalue exceeds lambda (1 + 1 / ratio). M is diag(A), or the
/// incomplete factorisation with the smallest of some shifts with which it is definite. The factorisation
/// solves along the strong couplings of stretched cells, which the diagonal hardly smooths.
class ChebyshevSmoother : public Smoother
{
public:
  struct Range
  {
    unsigned int degree;
    double ratio;
  };
  static std::unique_ptr<ChebyshevSmoother> with_diagonal(const LevelOperator &A, Range range);
  static std::unique_ptr<ChebyshevSmoother> with_diagonal(const Epetra_CrsMatrix &A, Range range);
  static std::unique_ptr<ChebyshevSmoother> with_factorisation(const Epetra_CrsMatrix &A, Range range);

  void smooth(double *x, const double *b, bool starts_from_zero) const override;

  /// About the largest eigenvalue of diag(A)^-1 A. Collective.
  double largest_eigenvalue_with_diagonal() const;

private:
  ChebyshevSmoother(const LevelOperator &A, Range range) : A(A), range(range) {}
  ChebyshevSmoother(std::unique_ptr<MatrixLevel> matrix, Range range)
      : level(std::move(matrix)), A(*level), range(range)
  {
  }
  void take_diagonal();
  void estimate_spectrum();

  const std::unique_ptr<MatrixLevel> level; ///< nullptr, or A
  const LevelOperator &A;
  const Range range;
  std::unique_ptr<Approximation> M;
  bool has_diagonal = false;            ///< M = diag(A)
  static constexpr double margin = 1.2; ///< of the largest eigenvalue over its estimate
  double largest_eigenvalue = 0;        ///< of M^-1 A; 0 if M is not definite
};

} // namespace dovetail
