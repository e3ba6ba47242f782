// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the linear solver has to know of a model.

#pragma once

#include <dovetail/solve/linear_solver.h>
#include <dovetail/system/block_system.h>

#include <functional>
#include <vector>

namespace dovetail {

/// The groups of fields that are solved one after another (Model::field_groups). @p system gives the present
/// system when it is asked for; both it and the model are kept by reference.
template <int dim>
std::vector<SolveGroup> make_solve_groups(const Model<dim> &model,
                                          const std::function<const BlockSystem<dim> &()> &system);

} // namespace dovetail
