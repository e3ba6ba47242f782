// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How long the edges of quadrilaterals and hexahedra are, and what counts as stretched.

#pragma once

#include <deal.II/base/geometry_info.h>

#include <array>

namespace dovetail {

/// From which ratio of its edges on a cell counts as stretched.
constexpr double smallest_stretch = 2;
/// Solves in cells smooth well what diag(A) smooths in cells that are half as stretched.
constexpr double smallest_stretch_beside_solves = 4;

/// Mean lengths of the edges of a quadrilateral or hexahedron, by direction.
template <int dim, typename Cell>
std::array<double, dim> edge_lengths(const Cell &cell)
{
  std::array<double, dim> lengths{};
  for (unsigned int d = 0; d < dim; ++d)
    for (const unsigned int v : cell->vertex_indices())
      if ((v & (1u << d)) == 0)
        lengths[d] += cell->vertex(v).distance(cell->vertex(v | (1u << d))) / (1u << (dim - 1));
  return lengths;
}

} // namespace dovetail
