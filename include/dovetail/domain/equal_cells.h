// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Cells that are translations of each other, for what depends on their shape alone.

#pragma once

#include <deal.II/fe/mapping_q.h>
#include <deal.II/grid/tria.h>

namespace dovetail {

/// Compares each cell with the last one that was no translation of the one before it. Edges differ by less
/// than 1e-12 of their length, so a sum over cells has at most a relative error of that size.
template <int dim>
class EqualCells
{
public:
  using cell_iterator = typename dealii::Triangulation<dim>::active_cell_iterator;

  /// With any other mapping than the multilinear one of the vertices no cells count as equal.
  explicit EqualCells(const dealii::Mapping<dim> &mapping)
  {
    const auto *const of_degree = dynamic_cast<const dealii::MappingQ<dim> *>(&mapping);
    is_by_vertices = of_degree != nullptr && of_degree->get_degree() == 1;
  }

  /// If not, the next cells are compared with this one.
  bool is_equal(const cell_iterator &cell)
  {
    if (is_by_vertices && last.state() == dealii::IteratorState::valid && is_translation(cell))
      return true;
    last = cell;
    return false;
  }

private:
  /// TriaAccessor::is_translation_of() allows for the distance of the cells in place of their size.
  bool is_translation(const cell_iterator &cell) const
  {
    if (cell->reference_cell() != last->reference_cell())
      return false;
    for (unsigned int i = 1; i < cell->n_vertices(); ++i) {
      const dealii::Tensor<1, dim> edge = last->vertex(i) - last->vertex(0),
                                   difference = (cell->vertex(i) - cell->vertex(0)) - edge;
      if (difference.norm_square() > 1e-24 * edge.norm_square())
        return false;
    }
    return true;
  }

  bool is_by_vertices;
  cell_iterator last;
};

} // namespace dovetail
