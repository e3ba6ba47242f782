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

/// From here on a body counts as much stiffer than another one.
constexpr double least_contrast = 30;

/// On tied faces, let unknowns of the stiff side follow those of the soft one and others of their own body,
/// u_d = P u_s + R u_r. The matrix of u_s contains the stiffness of the other body, P^T K_d P. Where the
/// stiff side is coarser, some functions have P u_s = 0: only the soft body resists them, and a smoother that
/// divides by the stiff diagonal entries leaves them as they are. Where soft bodies hold several stiff ones,
/// each of these may move by itself: u_s near an edge then serves two of them. Therefore two spaces, whose
/// sum contains all functions, correct the solution in turn:
///
/// - u_s and the rigid motions of each stiff body. Their matrix is factorised.
/// - functions in which u_s follows, u_s = Q y, with one y for each unknown u_d, and all that is not on the
///   face. Q is P^T without its small weights and those below zero, with rows that sum to one. The stiff body
///   leads there, as if it were the source, and multigrid serves as usual. In the near-null space, y solves
///   P Q y = u_d - R u_r. If there are more y than u_s, the usual functions serve in place of these.
///
/// J. Xu: Iterative methods by space decomposition and subspace correction, 1992.
class SoftLeaders
{
public:
  struct Found
  {
    std::unique_ptr<SoftLeaders> leaders; ///< or nullptr
    bool are_means = false;               ///< much stiffer rows follow fewer rows that lead
  };
  /// Collective. Nothing if no body follows one that is much softer, if too many unknowns lead, or if two
  /// bodies meet of which the stiff one is as fine or finer.
  /// @param linear_part that of the facts, if it is there already
  static Found find(const GroupFacts &facts, const Epetra_Map &rows, const RowSums *linear_part = nullptr);

  /// Levels for A in which the leaders follow. @param other the smoother of A beside the factors; nullptr:
  /// the rows that are alone are solved.
  std::unique_ptr<DegreeCoarsening> coarsen(const LevelOperator &A, const GroupFacts &facts,
                                            const DegreeCoarsening::MakeModes &make_modes,
                                            std::unique_ptr<Smoother> other,
                                            const DegreeCoarsening::MakeCoarse &make_coarse) const;

private:
  int reverse(const Epetra_Map &rows, const RowSums &given);
  void find_following_bodies(const GroupFacts &facts, const Epetra_Map &rows);
  /// With y in place of u_d.
  std::unique_ptr<Epetra_MultiVector> reversed_modes(const Epetra_MultiVector &modes) const;
  std::unique_ptr<Smoother> exact_first(const LevelOperator &A, const Epetra_MultiVector &modes,
                                        std::unique_ptr<Smoother> other) const;

  bool is_reversed = true;                   ///< the leaders follow in the second space
  RowSums sums;                              ///< of that space
  std::unique_ptr<Epetra_CrsMatrix> P, R, Q; ///< of the unknowns that lead and follow; other rows are empty
  std::vector<int> leaders;                  ///< own rows
  std::vector<unsigned int> body;            ///< by own row
  std::vector<int> follows;                  ///< by body: whether some rows follow a much softer one
};

/// What solves with A_1: levels, those without any aggregate of two bodies, or its factors.
enum class CoarseSolve { by_levels, within_bodies, by_factors };

/// DegreeCoarsening of A with @p smoother, by SoftLeaders where there are some. Collective.
/// @param coarse becomes within_bodies where SoftLeaders meet more than two bodies, or where stiff and soft
/// ones meet whose cells are not stretched, unless it is by_factors
std::unique_ptr<DegreeCoarsening> coarsen_degree(const LevelOperator &A, const GroupFacts &facts,
                                                 const DegreeCoarsening::MakeModes &make_modes,
                                                 std::unique_ptr<Smoother> smoother, CoarseSolve &coarse);

} // namespace dovetail
