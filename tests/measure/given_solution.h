// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A scene whose solution is given instead of computed: the interpolant of `Exact`.

#pragma once

#include "../system/scene_model.h"

#include <dovetail/measure/reactions.h>

#include <memory>

namespace test {

/// The model of a scene, paired, and the interpolant of its exact solution at t = 1.
template <int dim>
struct GivenSolution : SceneModel<dim>
{
  explicit GivenSolution(const std::string &prm) : SceneModel<dim>(prm)
  {
    system = std::make_unique<BlockSystem<dim>>(this->model);
    system->set_up(1);
    Vector owned = system->owned_vector();
    const auto exact = [this](const unsigned int d, const unsigned int c, const dealii::Point<dim> &X) {
      const Domain<dim> &domain = *this->model.domains[d];
      for (const Field &field : domain.fields())
        if (c >= field.first_component && c < field.first_component + field.n_components)
          return domain.exact().find(field.name)->value(X, 1., c - field.first_component);
      return 0.;
    };
    interpolate<dim>(this->model, exact, owned);
    solution = system->ghosted_vector();
    solution = owned;
    system->begin_step(1, owned);
    forces = std::make_unique<NodalForces<dim>>(system->nodal_forces(owned));
    system->find_multipliers(owned, *forces);
    reactions = std::make_unique<Reactions<dim>>(this->model, *forces, solution);
  }

  Vector solution;
  std::unique_ptr<BlockSystem<dim>> system;
  std::unique_ptr<NodalForces<dim>> forces;
  std::unique_ptr<Reactions<dim>> reactions;
};

} // namespace test
