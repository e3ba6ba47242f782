// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How often a run did what costs most.

#pragma once

#include <dovetail/solve/linear_solver.h>
#include <dovetail/system/block_system.h>

#include <nlohmann/json.hpp>

namespace dovetail {

/// What was counted where the work was done, for the report. Assemblies, solves and locators are those of the
/// run, in which all ranks take part; evaluations, eigenvalue problems and what interfaces sent from rank to
/// rank are sums over the ranks. Collective.
template <int dim>
nlohmann::ordered_json count(const Model<dim> &model, const typename BlockSystem<dim>::Assemblies &assemblies,
                             const LinearSolver &solver, unsigned int n_predicted, unsigned int n_files);

} // namespace dovetail
