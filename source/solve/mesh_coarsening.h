// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Multigrid's levels of degree one on coarser meshes.

#pragma once

#include "cycle.h"

#include <dovetail/solve/group_solver.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Map.h>
#include <Epetra_MultiVector.h>

#include <functional>
#include <memory>
#include <vector>

namespace dovetail {

/// From a mesh to one whose cells are the parents.
struct MeshStep
{
  std::unique_ptr<Epetra_CrsMatrix> P; ///< interpolates the unknowns of the finer level
  Selection rows;                      ///< own ones of the finer level that the coarser one has
  bool has_circles = false;            ///< of rows that follow each other: P lacks something
  bool may_be_stretched = false;       ///< the cells
};

/// Steps towards coarser meshes, as long as these have fewer unknowns by a fair share, and not few. A vertex
/// that a coarser mesh does not have is a mean of others, and what a constraint condenses out is the sum of
/// those it follows. Followed through, only free unknowns of the coarser mesh remain: its functions satisfy
/// all constraints. There are no steps where rows follow each other in a circle. Collective.
/// @param sums of each own row, as GroupFacts::linear_part has them
/// @param finest own rows that are unknowns of the first level
/// @param needs_parts the hexahedra of MeshLevels::has_parts serve, however many unknowns others have
std::vector<MeshStep> make_mesh_steps(const MeshLevels &levels, const RowSums &sums, const Epetra_Map &rows,
                                      Selection finest, bool needs_parts = false);

/// The cycle that @p make_coarse makes for the coarsest mesh, and above it a level for each step, with
/// @f[ A_{l-1} = P^T A_l P. @f]
std::unique_ptr<Cycle>
coarsen_mesh(Cycle::Finest A, std::vector<MeshStep> steps, std::shared_ptr<const Epetra_MultiVector> modes,
             std::vector<GroupFacts::Place> places,
             const std::function<std::unique_ptr<Cycle>(Cycle::Finest A,
                                                        std::shared_ptr<const Epetra_MultiVector> modes,
                                                        std::vector<GroupFacts::Place> places)> &make_coarse);

/// What some own rows have of @p modes, to which @p map belongs.
std::unique_ptr<Epetra_MultiVector> select_rows(const Epetra_MultiVector &modes, const Epetra_Map &map,
                                                const Selection &rows);

} // namespace dovetail
