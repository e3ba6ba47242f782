// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Meshes that are refined where the estimated error is largest.

#pragma once

#include <dovetail/measure/error_estimate.h>
#include <dovetail/output/results.h>
#include <dovetail/run/nonlinear_step.h>

#include <exception>
#include <optional>

namespace dovetail {

/// After the last step: estimate the error, refine, solve the end time again, `Adaptive cycles` times.
template <int dim>
class AdaptiveCycles
{
public:
  /// Reads `Adaptive cycles` and `Adaptive share`; all others are kept by reference.
  /// @throw UserError if no mesh can be refined
  AdaptiveCycles(const Section &scene, Model<dim> &model, NonlinearStep<dim> &step, Results<dim> &results,
                 Phases &phases, Log &log);

  void add_to(Plan &plan) const;
  /// From the solution @p x of time @p t, which becomes that on the last meshes. What is measured and written
  /// last stays if a cycle does not converge. @return whether all did. Collective.
  bool run(double t, Vector &x);

  std::exception_ptr problem() const { return problem_of_cycle; } ///< wrong input that a cycle has found

private:
  std::optional<NewtonResult> try_cycle(const ErrorEstimate &estimate, double t, Vector &x);
  NewtonResult solve_on_refined_meshes(const ErrorEstimate &estimate, double t, Vector &x);

  Model<dim> &model;
  NonlinearStep<dim> &step;
  Results<dim> &results;
  Phases &phases;
  Log &log;
  unsigned int n_cycles;
  double share; ///< of the estimated error squared, in the cells that are refined
  std::exception_ptr problem_of_cycle;
};

} // namespace dovetail
