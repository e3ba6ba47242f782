// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A mesh of which deal.II shares nothing out.

#pragma once

#include <deal.II/distributed/tria_base.h>
#include <deal.II/grid/tria.h>

#include <string>

namespace dovetail {

// Without `override`, since versions of deal.II differ in what the base class declares.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsuggest-override"

/// A copy of a mesh on each rank, without p4est. All cells are the rank's own unless a derived class gives
/// them to others.
template <int dim>
class WholeMesh : public dealii::parallel::DistributedTriangulationBase<dim>
{
public:
  explicit WholeMesh(const MPI_Comm &communicator)
      : dealii::parallel::DistributedTriangulationBase<dim>(communicator)
  {
  }

  void copy_triangulation(const dealii::Triangulation<dim> &other)
  {
    dealii::Triangulation<dim>::copy_triangulation(other);
    this->update_number_cache();
  }

  bool is_multilevel_hierarchy_constructed() const { return false; }

  // What is not asked of such a mesh.
  void save(const std::string &) const { AssertThrow(false, dealii::ExcNotImplemented()); }
  void load(const std::string &) { AssertThrow(false, dealii::ExcNotImplemented()); }
  void load(const std::string &, bool) { AssertThrow(false, dealii::ExcNotImplemented()); }
  void update_cell_relations() { AssertThrow(false, dealii::ExcNotImplemented()); }
};

#pragma GCC diagnostic pop

} // namespace dovetail
