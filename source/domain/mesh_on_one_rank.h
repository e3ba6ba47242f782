// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A mesh that one rank holds wholly, without p4est.

#pragma once

#include <deal.II/base/utilities.h>
#include <deal.II/distributed/tria_base.h>
#include <deal.II/grid/grid_tools.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/sparsity_tools.h>

#include <vector>

namespace dovetail {

// Without `override`, since versions of deal.II differ in what the base class declares.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsuggest-override"

/// Cells are divided all at once, or not at all: p4est, which divides some of them and moves cells between
/// ranks, needs three times as long to take a coarse mesh as deal.II needs to make it. Cells have the CellId
/// that they have on several ranks: checkpoints know them by it.
template <int dim>
class MeshOnOneRank : public dealii::parallel::DistributedTriangulationBase<dim>
{
public:
  explicit MeshOnOneRank(const MPI_Comm &communicator)
      : dealii::parallel::DistributedTriangulationBase<dim>(communicator)
  {
  }

  void copy_triangulation(const dealii::Triangulation<dim> &other)
  {
    dealii::Triangulation<dim>::copy_triangulation(other);
    dealii::DynamicSparsityPattern neighbours;
    dealii::GridTools::get_vertex_connectivity_of_cells(*this, neighbours);
    id_of_coarse_cell.resize(this->n_cells(0));
    dealii::SparsityTools::reorder_hierarchical(neighbours, id_of_coarse_cell); // as deal.II does for p4est
    coarse_cell_of_id = dealii::Utilities::invert_permutation(id_of_coarse_cell);
    this->update_number_cache();
  }

  void execute_coarsening_and_refinement()
  {
    dealii::Triangulation<dim>::execute_coarsening_and_refinement();
    this->update_number_cache();
  }

  bool is_multilevel_hierarchy_constructed() const { return false; }

  unsigned int coarse_cell_id_to_coarse_cell_index(const dealii::types::coarse_cell_id id) const
  {
    return coarse_cell_of_id[id];
  }
  dealii::types::coarse_cell_id coarse_cell_index_to_coarse_cell_id(const unsigned int index) const
  {
    return id_of_coarse_cell[index];
  }

  // What is not asked of such a mesh.
  void save(const std::string &) const { AssertThrow(false, dealii::ExcNotImplemented()); }
  void load(const std::string &) { AssertThrow(false, dealii::ExcNotImplemented()); }
  void load(const std::string &, bool) { AssertThrow(false, dealii::ExcNotImplemented()); }
  void update_cell_relations() { AssertThrow(false, dealii::ExcNotImplemented()); }

private:
  std::vector<dealii::types::global_dof_index> id_of_coarse_cell, coarse_cell_of_id;
};

#pragma GCC diagnostic pop

} // namespace dovetail
