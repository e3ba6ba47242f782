// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The smoother of multigrid's levels.

#pragma once

#include "level_operator.h"
#include "smoother.h"
#include <dovetail/solve/approximation.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Vector.h>

#include <functional>
#include <limits>
#include <memory>
#include <vector>

namespace dovetail {

/// M = diag(A), in single precision
class Diagonal : public Approximation
{
public:
  explicit Diagonal(const LevelProducts &A);
  void vmult(double *z, const double *r) const override;

private:
  std::vector<float> inverse; ///< in the unit
  double unit = 0;            ///< the largest one
};

/// Chebyshev iteration with M^-1 A, whose largest eigenvalue is lambda: symmetric, and positive definite as
/// long as no eigenvalue exceeds lambda (1 + 1 / ratio). M is diag(A), solves in cells
/// (LevelProducts::approximation), or the incomplete factorisation with the smallest of some shifts with
/// which it is definite. The factorisation solves along the strong couplings of stretched cells, which the
/// diagonal hardly smooths.
///
/// Of an error of eigenvalue t, k steps leave p(t). With polynomials of the first kind, |p| is the same at
/// their extrema in [lambda / ratio, lambda]. With those of the fourth kind (Lottes 2023), which know no
/// lower end,
/// @f[ |p(t)| \le \frac{1}{2 k + 1} \sqrt{\lambda / t}, @f]
/// so that least is left near lambda, where most eigenvalues of a factorisation are.
class ChebyshevSmoother : public Smoother
{
public:
  static constexpr double fourth_kind = std::numeric_limits<double>::infinity(); ///< for a ratio
  struct Range
  {
    unsigned int degree;
    double ratio = fourth_kind;
  };
  /// @param known_eigenvalue the largest one of diag(A)^-1 A, from below; 0: to be estimated
  static std::unique_ptr<ChebyshevSmoother> with_diagonal(const LevelProducts &A, Range range,
                                                          double known_eigenvalue = 0);
  /// diag(A) instead, where M is not definite. Collective.
  static std::unique_ptr<ChebyshevSmoother> with_approximation(const LevelProducts &A,
                                                               std::unique_ptr<Approximation> M, Range range);
  static std::unique_ptr<ChebyshevSmoother> with_factorisation(const LevelEntries &A, Range range);

  /// From now on, M is the incomplete factorisation of @p matrix, which is A or what dominates it.
  /// Collective.
  void take_factorisation(const LevelEntries &matrix, Range range);

  void smooth(double *x, const double *b, bool starts_from_zero) const override;
  double eigenvalue() const { return largest_eigenvalue; } ///< lambda

private:
  ChebyshevSmoother(const LevelProducts &A, Range range) : A(A), range(range) {}
  void take_diagonal(double known_eigenvalue);
  void estimate_spectrum();

  const LevelProducts &A;
  Range range;
  std::unique_ptr<Approximation> M;
  static constexpr double margin = 1.2; ///< of the largest eigenvalue over its estimate
  double largest_eigenvalue = 0;        ///< of M^-1 A; 0 if M is not definite
};

/// The largest eigenvalue of diag(A)^-1 A, from below. Collective.
double largest_eigenvalue_with_diagonal(const LevelProducts &A);

} // namespace dovetail
