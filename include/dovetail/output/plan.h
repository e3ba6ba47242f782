// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a scene needs, and what is left out because it does not.

#pragma once

#include <dovetail/system/model.h>

#include <string>
#include <vector>

namespace dovetail {

/// Sentences of the form "what: how" and "what: why not". Laws, ties and solvers describe themselves
/// (Material::description, Tie::description and left_out, LinearSolver::description).
struct Plan
{
  std::vector<std::string> needed, left_out;
};

/// The plan of a model for so many steps, with the sentences of the linear solver. Collective. @pre The model
/// is paired.
template <int dim>
Plan make_plan(const Model<dim> &model, unsigned int n_steps, const std::vector<std::string> &solvers);

} // namespace dovetail
