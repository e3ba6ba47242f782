// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A mesh of quadrilaterals or hexahedra on one level, without p4est.

#pragma once

#include "whole_mesh.h"

#include <deal.II/base/utilities.h>
#include <deal.II/grid/grid_tools.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/sparsity_tools.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace dovetail {

// Without `override`, since versions of deal.II differ in what the base class declares.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsuggest-override"

/// Cells are divided all at once, or not at all: p4est, which divides some of them and moves cells between
/// ranks, needs three times as long to take a coarse mesh as deal.II needs to make it. As with p4est, each
/// rank has the coarse mesh and divides what it needs for its own share and the cells around it, which is a
/// part of p4est's curve; cells that were one cell before the last refinement stay together. Cells have the
/// CellId that they have with p4est, on any number of ranks: checkpoints know them by it.
template <int dim>
class UniformMesh : public WholeMesh<dim>
{
public:
  using WholeMesh<dim>::WholeMesh;

  void copy_triangulation(const dealii::Triangulation<dim> &other)
  {
    dealii::Triangulation<dim>::copy_triangulation(other);
    dealii::DynamicSparsityPattern neighbours;
    dealii::GridTools::get_vertex_connectivity_of_cells(*this, neighbours);
    id_of_coarse_cell.resize(this->n_cells(0));
    dealii::SparsityTools::reorder_hierarchical(neighbours, id_of_coarse_cell); // as deal.II does for p4est
    coarse_cell_of_id = dealii::Utilities::invert_permutation(id_of_coarse_cell);
  }

  /// After copy_triangulation(), and once.
  void refine_global(const unsigned int n_refinements)
  {
    finest_level = n_refinements;
    places.assign(id_of_coarse_cell.begin(), id_of_coarse_cell.end());
    for (unsigned int level = 0; level < finest_level && level < this->n_levels(); ++level) {
      for_near_cells(level, [](const auto &cell) { cell->set_refine_flag(); });
      dealii::Triangulation<dim>::execute_coarsening_and_refinement();
      place_children(level);
    }
    for (const auto &cell : this->active_cell_iterators())
      cell->set_subdomain_id(dealii::numbers::artificial_subdomain_id);
    if (finest_level < this->n_levels())
      for_near_cells(finest_level, [this](const auto &cell) { cell->set_subdomain_id(ranks_of(cell)[0]); });
    places = std::vector<std::uint64_t>(); // = {} would keep the memory
    this->update_number_cache();
  }

  unsigned int coarse_cell_id_to_coarse_cell_index(const dealii::types::coarse_cell_id id) const
  {
    return coarse_cell_of_id[id];
  }
  dealii::types::coarse_cell_id coarse_cell_index_to_coarse_cell_id(const unsigned int index) const
  {
    return id_of_coarse_cell[index];
  }

private:
  using Cell = typename dealii::Triangulation<dim>::cell_iterator;

  /// The first and the last rank that have parts of a cell.
  std::array<std::uint64_t, 2> ranks_of(const Cell &cell) const
  {
    const unsigned int shared_level = std::max(finest_level, 1u) - 1, level = cell->level(),
                       n_further = level < shared_level ? shared_level - level : 0;
    const std::uint64_t n_shared = std::uint64_t(id_of_coarse_cell.size()) << dim * shared_level,
                        place = places[cell->index()],
                        first = level > shared_level ? place >> dim : place << dim * n_further,
                        last = first + (std::uint64_t(1) << dim * n_further) - 1;
    return {{((first + 1) * this->n_subdomains - 1) / n_shared,
             ((last + 1) * this->n_subdomains - 1) / n_shared}};
  }

  /// Those of a level of which this rank has parts, and those at their vertices.
  template <typename Action>
  void for_near_cells(const unsigned int level, const Action &action)
  {
    std::vector<bool> is_own(this->n_vertices(), false);
    for (const Cell &cell : this->cell_iterators_on_level(level))
      if (const auto [first, last] = ranks_of(cell);
          first <= this->my_subdomain && this->my_subdomain <= last)
        for (const unsigned int v : cell->vertex_indices())
          is_own[cell->vertex_index(v)] = true;
    for (const Cell &cell : this->cell_iterators_on_level(level))
      for (const unsigned int v : cell->vertex_indices())
        if (is_own[cell->vertex_index(v)]) {
          action(cell);
          break;
        }
  }

  void place_children(const unsigned int level)
  {
    const std::vector<std::uint64_t> of_parents = std::move(places);
    places.assign(level + 1 < this->n_levels() ? this->n_raw_cells(level + 1) : 0, 0);
    for (const Cell &cell : this->cell_iterators_on_level(level))
      for (unsigned int c = 0; c < cell->n_children(); ++c)
        places[cell->child_index(c)] = (of_parents[cell->index()] << dim) + c;
  }

  std::vector<dealii::types::global_dof_index> id_of_coarse_cell, coarse_cell_of_id;
  unsigned int finest_level = 0;
  std::vector<std::uint64_t> places; ///< of the cells of a level on the curve, by index
};

#pragma GCC diagnostic pop

} // namespace dovetail
