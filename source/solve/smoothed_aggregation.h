// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Algebraic multigrid for elements of degree one.

#pragma once

#include "chebyshev_smoother.h"

#include <dovetail/solve/group_solver.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_MultiVector.h>
#include <Epetra_Vector.h>

#include <functional>
#include <memory>
#include <vector>

namespace ML_Epetra {
class MultiLevelPreconditioner;
}

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

/// A V-cycle of ML's smoothed aggregation for a symmetric positive definite matrix, with a ChebyshevSmoother
/// on each level.
///
/// P. Vanek, J. Mandel, M. Brezina: Algebraic multigrid by smoothed aggregation for second and fourth order
/// elliptic problems, 1996.
class SmoothedAggregation : public Cycle
{
public:
  /// @param modes near-null space of A. A and they are referred to.
  SmoothedAggregation(const Epetra_CrsMatrix &A, const Epetra_MultiVector &modes,
                      const MakeSmoother &make_smoother);
  ~SmoothedAggregation() override;

  void vmult(Epetra_MultiVector &x, const Epetra_MultiVector &b) const override;

private:
  void set_smoothers(const Epetra_CrsMatrix &A, const MakeSmoother &make_smoother);

  std::unique_ptr<ML_Epetra::MultiLevelPreconditioner> levels;
  std::vector<std::unique_ptr<Epetra_CrsMatrix>> coarse_matrices;
  std::vector<std::unique_ptr<ChebyshevSmoother>> smoothers; ///< of all levels but the coarsest
};

} // namespace dovetail
