// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A scene whose solution is given instead of computed: the interpolant of `Exact`.

#pragma once

#include <dovetail/scene/scene_text.h>
#include <dovetail/system/block_system.h>

#include <iostream>

namespace dovetail {

/// The model of a scene, paired, and the interpolant of its exact solution.
template <int dim>
struct GivenSolution
{
  explicit GivenSolution(const std::string &prm)
      : text(SceneText::from_prm(prm)), scene(SceneText::root(text)), model(scene, MPI_COMM_WORLD)
  {
    model.pair();
    BlockSystem<dim> system(model);
    system.set_up(1);
    Vector owned = system.owned_vector();
    for (const auto &domain : model.domains)
      interpolate(*domain, owned);
    owned.compress(dealii::VectorOperation::insert);
    solution = system.ghosted_vector();
    solution = owned;
    system.begin_step(1, owned);
  }

  std::shared_ptr<SceneText> text;
  Section scene;
  Model<dim> model;
  Vector solution;

private:
  void interpolate(const Domain<dim> &domain, Vector &owned) const
  {
    const unsigned int n = domain.n_nodes();
    dealii::FEValues<dim> at_nodes(domain.mapping(), domain.scalar_element(),
                                   domain.scalar_element().get_unit_support_points(),
                                   dealii::update_quadrature_points);
    std::vector<dealii::types::global_dof_index> dofs;
    for (const auto &cell : domain.dof_handler().active_cell_iterators())
      if (cell->is_locally_owned()) {
        at_nodes.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
        domain.cell_dofs(cell, dofs);
        for (const Field &field : domain.fields())
          for (unsigned int c = 0; c < field.n_components; ++c)
            for (unsigned int a = 0; a < n; ++a)
              if (const auto dof = dofs[(field.first_component + c) * n + a];
                  model.numbering->owned.is_element(dof))
                owned(dof) = domain.exact().find(field.name)->value(at_nodes.quadrature_point(a), 1., c);
      }
  }
};

/// Rank 0 prints.
inline void print(const std::string &name, const std::vector<double> &values)
{
  if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) != 0)
    return;
  std::cout << name;
  for (const double value : values)
    std::cout << ' ' << (std::abs(value) < 1e-11 ? 0. : value);
  std::cout << std::endl;
}

} // namespace dovetail
