// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Cells that are translations of each other, for what depends on their shape alone.

#pragma once

#include <deal.II/fe/mapping_q.h>
#include <deal.II/grid/tria.h>

namespace dovetail {

/// Compares each cell with the last one that was no translation of the one before it. In a mesh of equal
/// cells all are compared with the first one, so that roundings do not add up.
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
    if (is_by_vertices && last.state() == dealii::IteratorState::valid && cell->is_translation_of(last))
      return true;
    last = cell;
    return false;
  }

private:
  bool is_by_vertices;
  cell_iterator last;
};

} // namespace dovetail
