// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Algebraic multigrid for elements of degree one.

#pragma once

#include "chebyshev_smoother.h"
#include "factors.h"

#include <dovetail/solve/group_solver.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_MultiVector.h>
#include <Epetra_Vector.h>

#include <functional>
#include <memory>
#include <vector>

namespace dovetail {

/// GroupFacts::near_null_space, which stays the same while the values of the matrix change. Collective.
std::unique_ptr<Epetra_MultiVector> make_modes(const GroupFacts &facts, const Epetra_Map &rows);

/// About the inverse of a symmetric positive definite matrix, by multigrid.
class Cycle
{
public:
  /// Makes the smoother of the matrix of a level.
  using MakeSmoother = std::function<std::unique_ptr<ChebyshevSmoother>(const Epetra_CrsMatrix &)>;

  virtual ~Cycle() = default;
  virtual void vmult(Epetra_MultiVector &x, const Epetra_MultiVector &b) const = 0;
};

/// A V-cycle of smoothed aggregation for a symmetric positive definite matrix A, with a ChebyshevSmoother on
/// each level.
///
/// The prolongation is P = (I - w D^-1 A) T: T is a basis of the near-null space on each of the aggregates,
/// D = diag(A), and w = 4/3 over the largest eigenvalue of D^-1 A. The columns of T and P come in blocks, one
/// for each aggregate, so that P^T A P is made of small dense products. It is summed row by row of A; A P is
/// never stored, which would need more memory than A.
///
/// P. Vanek, J. Mandel, M. Brezina: Algebraic multigrid by smoothed aggregation for second and fourth order
/// elliptic problems, 1996.
class SmoothedAggregation : public Cycle
{
public:
  /// @param modes near-null space of A, which is referred to.
  SmoothedAggregation(const Epetra_CrsMatrix &A, const Epetra_MultiVector &modes,
                      const MakeSmoother &make_smoother);
  ~SmoothedAggregation() override;

  void vmult(Epetra_MultiVector &x, const Epetra_MultiVector &b) const override;

private:
  struct Level
  {
    const Epetra_CrsMatrix *A = nullptr;
    std::unique_ptr<Epetra_CrsMatrix> owned; ///< nullptr on the finest level
    std::unique_ptr<Epetra_CrsMatrix> P;     ///< from the next coarser level
    std::unique_ptr<ChebyshevSmoother> smoother;
  };

  void cycle(unsigned int level, Epetra_Vector &x, const Epetra_Vector &b) const;

  std::vector<Level> levels; ///< all but the coarsest
  std::unique_ptr<Epetra_CrsMatrix> coarsest;
  std::unique_ptr<Factors> factors; ///< of it
};

} // namespace dovetail
