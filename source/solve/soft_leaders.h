// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Multigrid where unknowns of a stiff body follow those of a soft one (dual mortar, pointwise).

#pragma once

#include "degree_coarsening.h"

#include <Epetra_CrsMatrix.h>
#include <Epetra_MultiVector.h>

#include <memory>
#include <vector>

namespace dovetail {

/// On a tied face, let the unknowns of the stiff side follow those of the soft one, u_d = P u_s. The matrix
/// of u_s contains the stiffness of the other body, P^T K_d P. Where the stiff side is coarser, some
/// functions have P u_s = 0: only the soft body resists them, and a smoother that divides by the stiff
/// diagonal entries leaves them as they are. Therefore two spaces, whose sum contains all functions, correct
/// the solution in turn:
///
/// - u_s alone. The block of these rows is factorised.
/// - functions in which u_s follows, u_s = Q y, with one y for each unknown u_d, and all that is not on the
///   face. Q is P^T without its small weights, with rows whose absolute values sum to one. The stiff body
///   leads there, as if it were the source, and multigrid serves as usual. In the near-null space, y solves P
///   Q y = u_d.
///
/// J. Xu: Iterative methods by space decomposition and subspace correction, 1992.
class SoftLeaders
{
public:
  /// Collective. nullptr if no body follows one that is much softer, or if too many unknowns lead.
  /// @param linear_part that of the facts, if it is there already
  static std::unique_ptr<SoftLeaders> find(const GroupFacts &facts, const Epetra_Map &rows,
                                           const RowSums *linear_part = nullptr);

  /// Levels for A in which the leaders follow. @param other the smoother of A beside the factors; nullptr:
  /// the rows that are alone are solved.
  std::unique_ptr<DegreeCoarsening> coarsen(const LevelOperator &A, const GroupFacts &facts,
                                            const DegreeCoarsening::MakeModes &make_modes,
                                            std::unique_ptr<Smoother> other,
                                            const DegreeCoarsening::MakeCoarse &make_coarse) const;

private:
  /// With y in place of u_d.
  std::unique_ptr<Epetra_MultiVector> reversed_modes(const Epetra_MultiVector &modes) const;

  RowSums reversed;                       ///< the leaders follow
  std::unique_ptr<Epetra_CrsMatrix> P, Q; ///< of the unknowns that lead and follow; other rows are empty
  std::vector<int> leaders;               ///< own rows
};

/// DegreeCoarsening of A with @p smoother, by SoftLeaders where there are some. Collective.
std::unique_ptr<DegreeCoarsening>
coarsen_degree(const LevelOperator &A, const GroupFacts &facts, const DegreeCoarsening::MakeModes &make_modes,
               std::unique_ptr<Smoother> smoother,
               const DegreeCoarsening::MakeCoarse &make_coarse = DegreeCoarsening::make_usual_coarse);

} // namespace dovetail
