// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Meshes that are refined where the estimated error is largest.

#pragma once

#include <dovetail/measure/probe_estimate.h>
#include <dovetail/output/results.h>
#include <dovetail/run/nonlinear_step.h>

#include <exception>
#include <optional>

namespace dovetail {

/// After the last step: estimate the error, refine, solve the end time again, `Adaptive cycles` times. With
/// probes that have a Tolerance the error is theirs, and the cycles end when all are reached, or at a limit,
/// which is noted.
template <int dim>
class AdaptiveCycles
{
public:
  /// Reads `Adaptive cycles` and the entries beside it; all others are kept by reference.
  /// @throw UserError if no mesh can be refined
  AdaptiveCycles(const Section &scene, Model<dim> &model, const Probes<dim> &probes, NonlinearStep<dim> &step,
                 Results<dim> &results, Phases &phases, Notes &notes, Log &log);

  void add_to(Plan &plan) const;
  /// From the solution @p x of time @p t, which becomes that on the last meshes. What is measured and written
  /// last stays if a cycle does not converge. @return whether all did. Collective.
  bool run(double t, Vector &x);

  std::exception_ptr problem() const { return problem_of_cycle; } ///< wrong input that a cycle has found

private:
  bool can_refine() const;
  std::string end_of_cycles(unsigned int cycle, const ErrorEstimate &estimate) const;
  std::optional<ErrorEstimate> estimate(unsigned int cycle, double t, const Vector &x,
                                        nlohmann::ordered_json &entry);
  std::optional<ErrorEstimate> estimate_probes(unsigned int cycle, double t, const Vector &x,
                                               nlohmann::ordered_json &entry);
  std::optional<NewtonResult> try_cycle(const ErrorEstimate &estimate, double t, Vector &x);
  NewtonResult solve_on_refined_meshes(const ErrorEstimate &estimate, double t, Vector &x);

  Model<dim> &model;
  const Probes<dim> &probes;
  const Section linear_solver;
  NonlinearStep<dim> &step;
  Results<dim> &results;
  Phases &phases;
  Notes &notes;
  Log &log;
  unsigned int n_cycles;
  unsigned long largest_number_of_unknowns;
  CorrectedValues corrected_before; ///< on the mesh before
  double share;                     ///< of the estimated error squared, in the cells that are refined
  std::exception_ptr problem_of_cycle;
};

} // namespace dovetail
