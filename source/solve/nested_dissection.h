// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The order of elimination that leaves the factors of vectors in 3D few entries.

#pragma once

#include <Epetra_CrsMatrix.h>

#include <vector>

namespace dovetail {

/// How many of the own rows each node has: rows that follow each other and have the same columns, as the
/// components at a node do. Not collective.
std::vector<int> rows_of_nodes(const Epetra_CrsMatrix &A);

/// Nested dissection of the graph of all nodes.
///
/// @param rows_of_nodes of all nodes, in the order of the rows
/// @param rows, columns of entries, at least of either triangle, from 1
/// @return for each row when it is eliminated, from 1; empty if the graph has no edges or METIS fails
///
/// G. Karypis, V. Kumar: A fast and high quality multilevel scheme for partitioning irregular graphs, 1998.
std::vector<int> nested_dissection(const std::vector<int> &rows_of_nodes, const std::vector<int> &rows,
                                   const std::vector<int> &columns);

} // namespace dovetail
