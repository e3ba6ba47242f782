// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a run will take, before it begins.

#pragma once

#include <dovetail/run/step_control.h>

#include <string>

namespace dovetail {

/// Seconds and memory of all ranks together, by phase: roughly, within a factor of two on scenes like those
/// of the benchmarks.
struct CostEstimate
{
  double setup = 0, assembly = 0, solve = 0, output = 0; ///< [s], of the whole run
  double memory = 0;                                     ///< at most, with what is there already [MiB]
  double n_entries = 0;                                  ///< of the bodies' matrices, all of them
  unsigned int n_steps = 0, n_iterations = 0;            ///< of Newton's method in each
  bool knows_solver = true;                              ///< else solve and memory lack it

  double total() const { return setup + assembly + solve + output; } ///< without meshes and pairings
  std::string in_words() const;
};

/// From a small calibration: the tangents of some cells of each body and the product of a matrix are timed
/// on each rank, the lengths of rows are counted at some cells, and the solvers tell how they grow
/// (GroupSolver::expected_cost). A linear scene takes one Newton iteration in each step, others are taken to
/// need four. What refines the meshes or shortens steps is not known. Collective. @pre The model is paired.
template <int dim>
CostEstimate estimate_cost(const Model<dim> &model, const LinearSolver &solver, const Steps &steps);

} // namespace dovetail
