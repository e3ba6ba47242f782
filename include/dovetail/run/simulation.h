// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// From a scene to a report: the order in which things are made.

#pragma once

#include <dovetail/run/adaptive_cycles.h>
#include <dovetail/run/eigenmodes.h>
#include <dovetail/run/nonlinear_step.h>
#include <dovetail/run/step_control.h>

#include <memory>

namespace dovetail {

/// A whole run of one scene.
template <int dim>
class Simulation
{
public:
  /// Reads every entry of the scene and makes the meshes and pairings. Collective. @throw UserError
  Simulation(const std::shared_ptr<SceneText> &text, const MPI_Comm &communicator,
             Detail detail = Detail::usual);

  /// Print the plan and the coverage, solve nothing.
  void check();
  /// @return whether all steps converged; otherwise the last good step is kept and written.
  bool run();
  /// Go on from the checkpoint in the scene's Directory, then as run().
  bool resume();

private:
  void check_formulas() const;
  void check_path() const;
  Plan plan() const;
  bool run_steps(Vector &x);
  bool find_modes(Vector &x);
  void measure(const Vector &x, bool is_converged);
  /// Heading and plan in the log.
  Plan introduce();
  Vector begin();
  Vector go_on();
  bool run_from(Vector x);

  std::shared_ptr<SceneText> text;
  Section scene;
  Phases phases;
  Log log;
  Notes notes;
  Steps steps; ///< read first: materials ask for its Kind
  Model<dim> model;
  Probes<dim> probes;
  NonlinearStep<dim> step;
  Results<dim> results;
  StepControl<dim> step_control;
  AdaptiveCycles<dim> adaptive_cycles;
  Eigenmodes<dim> eigenmodes;
};

/// Read every entry that a scene can have, for the reference (@p text from SceneText::for_documentation).
void read_all_entries(const std::shared_ptr<SceneText> &text);

/// Read the entries at the top of a scene and load the plugins that it names, because later entries may name
/// their laws.
/// @return the dimension
unsigned int begin_scene(const Section &scene);

} // namespace dovetail
