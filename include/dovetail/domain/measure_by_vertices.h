// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The size of a cell without its mapping.

#pragma once

#include <deal.II/grid/grid_tools.h>
#include <deal.II/grid/tria.h>

#include <numeric>
#include <vector>

namespace dovetail {

/// The area or volume of a cell whose edges are straight. cell->measure() of a hexahedron cancels far from
/// the origin.
template <int dim>
double measure_by_vertices(const typename dealii::Triangulation<dim>::cell_iterator &cell)
{
  std::vector<dealii::Point<dim>> vertices(cell->n_vertices());
  std::vector<unsigned int> numbers(cell->n_vertices());
  for (unsigned int i = 0; i < cell->n_vertices(); ++i)
    vertices[i] = dealii::Point<dim>(cell->vertex(i) - cell->vertex(0));
  std::iota(numbers.begin(), numbers.end(), 0u);
  return dealii::GridTools::cell_measure<dim>(vertices, dealii::make_array_view(numbers));
}

} // namespace dovetail
