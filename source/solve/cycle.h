// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The V-cycle of algebraic multigrid, however its levels are made.

#pragma once

#include "chebyshev_smoother.h"
#include "factors.h"

#include <Epetra_CrsMatrix.h>
#include <Epetra_MultiVector.h>
#include <Epetra_Vector.h>

#include <functional>
#include <memory>
#include <vector>

namespace dovetail {

/// About the inverse of a symmetric positive definite matrix, by a V-cycle with a ChebyshevSmoother on each
/// level and the factors of the coarsest matrix. Who derives from it adds the levels.
class Cycle
{
public:
  /// Makes the smoother of the matrix of a level.
  using MakeSmoother = std::function<std::unique_ptr<ChebyshevSmoother>(const Epetra_CrsMatrix &)>;

  virtual ~Cycle() = default;
  void vmult(Epetra_MultiVector &x, const Epetra_MultiVector &b) const;

protected:
  static constexpr int largest_coarse = 2000;   ///< rows of a matrix that is not coarsened
  static constexpr double largest_growth = 0.9; ///< rows of a level beside those of the finer one

  /// @param A the finest matrix, which is referred to
  explicit Cycle(const Epetra_CrsMatrix &A) : A(A) {}

  /// Of the last level so far.
  const Epetra_CrsMatrix &coarsest() const { return levels.empty() ? A : *levels.back().coarse; }
  unsigned int n_levels() const { return levels.size(); }

  /// Below the last one: with @p P from its unknowns, and its matrix P^T A P.
  void add_level(std::unique_ptr<ChebyshevSmoother> smoother, std::unique_ptr<Epetra_CrsMatrix> P,
                 std::unique_ptr<Epetra_CrsMatrix> coarse);
  void factorise_coarsest() { factors = std::make_unique<Factors>(coarsest()); }

private:
  struct Level
  {
    std::unique_ptr<ChebyshevSmoother> smoother;
    std::unique_ptr<Epetra_CrsMatrix> P, coarse; ///< from and of the next level
  };

  void cycle(unsigned int level, Epetra_Vector &x, const Epetra_Vector &b) const;

  const Epetra_CrsMatrix &A;
  std::vector<Level> levels; ///< all but the coarsest
  std::unique_ptr<Factors> factors;
};

} // namespace dovetail
