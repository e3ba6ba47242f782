// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Algebraic multigrid for elements of degree one.

#pragma once

#include "cycle.h"

#include <dovetail/solve/group_solver.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Map.h>
#include <Epetra_MultiVector.h>

#include <memory>

namespace dovetail {

/// GroupFacts::near_null_space at some own rows, to which @p map belongs. Collective.
std::unique_ptr<Epetra_MultiVector> make_modes(const GroupFacts &facts, const Epetra_Map &map,
                                               const Selection *rows = nullptr);

/// A V-cycle of smoothed aggregation for a symmetric positive definite matrix A, with a ChebyshevSmoother on
/// each level.
///
/// The prolongation is P = (I - w D^-1 A) T: T is a basis of the near-null space on each of the aggregates,
/// D = diag(A), and w = 4/3 over the largest eigenvalue of D^-1 A. The columns of T and P come in blocks, one
/// for each aggregate, so that P^T A P is made of small dense products (aggregate_products.h).
///
/// P. Vanek, J. Mandel, M. Brezina: Algebraic multigrid by smoothed aggregation for second and fourth order
/// elliptic problems, 1996.
class SmoothedAggregation : public Cycle
{
public:
  /// @param modes near-null space of A, which is let go of as soon as it has been used
  SmoothedAggregation(Finest A, std::shared_ptr<const Epetra_MultiVector> modes,
                      const MakeSmoother &make_smoother);
};

} // namespace dovetail
