// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The order of elimination that leaves the factors of vectors in 3D few entries.

#pragma once

#include <Epetra_CrsMatrix.h>

#include <vector>

namespace dovetail {

/// The nodes of a matrix: rows of one rank that follow each other and have about the same columns, as the
/// components at a node do.
struct MatrixNodes
{
  std::vector<int> n_rows;    ///< of each node
  std::vector<int> n_columns; ///< that its rows have
  std::vector<int> columns;   ///< global numbers, node after node

  MatrixNodes() = default;
  /// Of the own rows; not collective.
  /// @param first_row of each node, and the number of rows at the end; if it is not known, rows that have
  /// exactly the same columns belong to a node
  MatrixNodes(const Epetra_CrsMatrix &A, std::vector<int> first_row);
};

/// Nested dissection of the graph of all nodes, whose rows have the numbers 0, 1, 2 and so on.
///
/// @return for each row when it is eliminated, from 1; empty if the graph has no edges or METIS fails
///
/// G. Karypis, V. Kumar: A fast and high quality multilevel scheme for partitioning irregular graphs, 1998.
std::vector<int> nested_dissection(const MatrixNodes &all);

} // namespace dovetail
