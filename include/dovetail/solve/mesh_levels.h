// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Which unknowns of degree one are there on coarser meshes, for multigrid.

#pragma once

#include <dovetail/solve/row_sums.h>

#include <vector>

namespace dovetail {

/// Rows that belong to the vertices of meshes which refinement has made. Each step towards coarser meshes
/// replaces cells by their parents; in them, a vertex that the parents do not have is the mean of vertices of
/// its parent.
struct MeshLevels
{
  /// Of each own row: the first step after which it is no vertex any more; 0: it remains.
  std::vector<unsigned char> step;
  RowSums means; ///< of rows that do not remain; others have none
  bool has_parts =
      false; ///< in the first step: hexahedra that were divided into tetrahedra. On all ranks alike
};

} // namespace dovetail
