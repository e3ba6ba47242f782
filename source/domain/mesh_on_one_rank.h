// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A mesh that one rank holds wholly, without p4est.

#pragma once

#include <deal.II/distributed/tria_base.h>

namespace dovetail {

/// Cells are divided all at once, or not at all: p4est, which divides some of them and moves cells between
/// ranks, needs three times as long to take a coarse mesh as deal.II needs to make it.
template <int dim>
class MeshOnOneRank : public dealii::parallel::DistributedTriangulationBase<dim>
{
public:
  explicit MeshOnOneRank(const MPI_Comm &communicator)
      : dealii::parallel::DistributedTriangulationBase<dim>(communicator)
  {
  }

  // No `override`: versions of deal.II differ in what the base class declares.

  void copy_triangulation(const dealii::Triangulation<dim> &other)
  {
    dealii::Triangulation<dim>::copy_triangulation(other);
    this->update_number_cache();
  }

  void execute_coarsening_and_refinement()
  {
    dealii::Triangulation<dim>::execute_coarsening_and_refinement();
    this->update_number_cache();
  }

  bool is_multilevel_hierarchy_constructed() const { return false; }

  // What is not asked of such a mesh.
  void save(const std::string &) const { AssertThrow(false, dealii::ExcNotImplemented()); }
  void load(const std::string &) { AssertThrow(false, dealii::ExcNotImplemented()); }
  void load(const std::string &, bool) { AssertThrow(false, dealii::ExcNotImplemented()); }
  void update_cell_relations() { AssertThrow(false, dealii::ExcNotImplemented()); }
};

} // namespace dovetail
