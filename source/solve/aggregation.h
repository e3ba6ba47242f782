// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The sets of unknowns that become those of the next coarser level.

#pragma once

#include <Epetra_CrsMatrix.h>
#include <Epetra_MultiVector.h>

#include <memory>
#include <vector>

namespace dovetail {

/// Disjoint sets of nodes of this rank, and on each an orthonormal basis of what the modes are there. The
/// basis has as many vectors as there are modes; where some depend on others, vectors are zero.
struct Aggregation
{
  std::vector<int> of_row;                   ///< by own row; negative: none, as of a prescribed unknown
  std::vector<double> basis;                 ///< by own row its values in the vectors of its set
  std::unique_ptr<Epetra_MultiVector> modes; ///< in these bases: those of the coarser level
};

/// The bases of the modes on given sets. Collective.
/// @param set_of_row as Aggregation::of_row
Aggregation make_bases(std::vector<int> set_of_row, int n_sets, const Epetra_MultiVector &modes);

/// A set is a node with all nodes that A couples with it, as long as all of them are free, then with those
/// that are free, as long as they are a third of them; then the others join the set of which they see most.
/// @param A symmetric, with @p rows_per_node unknowns of each node, one after another. Collective.
Aggregation make_aggregation(const Epetra_CrsMatrix &A, const Epetra_MultiVector &modes, int rows_per_node);

} // namespace dovetail
