// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Multigrid for elements of a degree above one.

#pragma once

#include "chebyshev_smoother.h"
#include "level_operator.h"
#include "smoothed_aggregation.h"

#include <dovetail/solve/group_solver.h>
#include <dovetail/solve/prolongation.h>
#include <dovetail/solve/row_sums.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_MultiVector.h>
#include <Epetra_Vector.h>

#include <functional>
#include <memory>
#include <vector>

namespace dovetail {

/// A cycle of two levels for a symmetric positive definite operator A of elements of degree p: Chebyshev
/// smoothing on all unknowns, and another cycle for the functions of degree one on the same mesh,
/// @f[ A_1 = P^T A P, @f]
/// where P interpolates them. A_1 has p^dim times fewer unknowns and much shorter rows than A, and its
/// geometry is simple: aggregation has an easy task, at a fraction of the set-up and of the coarse work.
/// Functions may keep their degree along the long edges of stretched cells, where the diagonal smooths
/// nothing: Model::linear_part.
///
/// Each unknown is a weighted sum of others: a node of those at the vertices of its cell, an unknown that a
/// constraint condenses out of those it follows. Followed through, only unknowns of A_1 remain.
class DegreeCoarsening
{
public:
  /// Levels for A_1.
  using MakeCoarse =
      std::function<std::unique_ptr<Cycle>(Cycle::Finest A_1, std::shared_ptr<const Epetra_MultiVector> modes,
                                           std::vector<GroupFacts::Place> places)>;
  static std::unique_ptr<Cycle> make_usual_coarse(Cycle::Finest A_1,
                                                  std::shared_ptr<const Epetra_MultiVector> modes,
                                                  std::vector<GroupFacts::Place> places);

  /// Near-null space of A at some own rows, to which a map belongs.
  using MakeModes =
      std::function<std::unique_ptr<Epetra_MultiVector>(const Epetra_Map &map, const Selection *rows)>;

  /// @param A matrix of the functions of the higher degree
  /// @param sums of each own row: the rows (global) and weights it is a sum of; none: a fixed value; itself
  /// with weight one: an unknown of A_1. Their memory is given back as soon as they have been read.
  /// @param make_modes called after that, for the unknowns of A_1
  /// @param facts places of the rows, if they are known
  /// @param smoother of A
  /// @param levels of coarser meshes, between A_1 and what @p make_coarse makes; nullptr: none
  DegreeCoarsening(const LevelOperator &A, RowSums &&sums, const MakeModes &make_modes,
                   const GroupFacts &facts, std::unique_ptr<Smoother> smoother,
                   const MakeCoarse &make_coarse = make_usual_coarse, const MeshLevels *levels = nullptr);

  /// Around A.approximation() or diag(A), for functions of this degree. @param is_augmented A has B^T W B
  static std::unique_ptr<ChebyshevSmoother> usual_smoother(const LevelOperator &A, unsigned int degree,
                                                           bool is_augmented);

  void vmult(Epetra_Vector &x, const Epetra_Vector &b) const;
  /// Whether A_1 has levels, and its factors would take less work than they spare where so many iterations
  /// are still expected. @param work_above of an iteration, without that of A_1's levels, as ExpectedCost
  bool factors_pay(double n_expected, double work_above) const;
  static constexpr double work_of_level_entry = 22; ///< of a matrix with levels below, in an iteration

private:
  void find_coarse_rows(const RowSums &sums);
  std::unique_ptr<Prolongation> make_prolongation(RowSums &&sums) const;
  void correct(Epetra_Vector &x, const Epetra_Vector &b) const;

  const LevelOperator &A;
  const unsigned int dim;
  const double nodes_across;
  double n_entries = 0;                       ///< of A_1
  Selection coarse_rows;                      ///< own rows of A that are unknowns of A_1
  std::unique_ptr<Prolongation> prolongation; ///< P
  std::unique_ptr<Cycle> coarse;
  std::unique_ptr<Smoother> smoother;
};

} // namespace dovetail
