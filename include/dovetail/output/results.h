// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Everything that a run leaves behind: pictures while it goes on, numbers at its end.

#pragma once

#include <dovetail/measure/energy_balance.h>
#include <dovetail/measure/probes.h>
#include <dovetail/measure/used_ranges.h>
#include <dovetail/output/checkpoint.h>
#include <dovetail/output/directory_lock.h>
#include <dovetail/output/notes.h>
#include <dovetail/output/paraview.h>
#include <dovetail/output/phases.h>
#include <dovetail/output/reference.h>
#include <dovetail/output/report.h>
#include <dovetail/output/step_table.h>
#include <dovetail/scene/scene_text.h>
#include <dovetail/solve/linear_solver.h>
#include <dovetail/system/block_system.h>

#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dovetail {

/// A state to look at.
template <int dim>
struct Solution
{
  BlockSystem<dim> &system; ///< whose step has begun at the time
  const Vector &x;          ///< the last good state
  double t;
  bool is_last;                     ///< no step after it has failed
  const Vector *velocity = nullptr; ///< of all unknowns, if something has inertia
  StepOfMotion motion = {};         ///< the step that led there
};

/// The directory of a run and what stands in it. What cannot be written ends no run, since the numbers are
/// still wanted: problem() holds it.
template <int dim>
class Results
{
public:
  /// Reads the section `Output` of @p text; all are kept by reference.
  Results(const SceneText &text, const Section &output, const Model<dim> &model, Probes<dim> &probes,
          Phases &phases, Notes &notes, Log &log);

  void add_to(Plan &plan) const;
  /// A picture of the scene before it is solved, unless `Paraview = false`.
  void preview();
  /// Makes the directory, locks it, and writes used.prm and a report that says that the run has not
  /// converged. Collective. @throw UserError or OutputError
  void begin(const Plan &plan);

  /// What the directory holds of a run that has not come to its end. @throw UserError if nothing can go on.
  Checkpoint<dim> find_checkpoint() const;
  /// Instead of begin(): results are added to those of that run until its checkpoint. Collective.
  void go_on(const Plan &plan, const SavedState &from);
  /// A step is done: what comes later is not of the checkpoint after it.
  void mark_good_step();
  bool is_checkpoint_due(const unsigned int step) const
  {
    return checkpoint_steps > 0 && step % checkpoint_steps == 0;
  }
  bool has_checkpoints() const { return checkpoint_steps > 0; } ///< the scene asks for them
  void write_checkpoint(SavedState &state);

  /// Whether a step, counted from one, shall be written.
  bool is_due(const unsigned int step) const { return step % every_steps == 0; }
  void write_pictures(const Solution<dim> &solution);
  bool has_energy() const { return energy_balance.has_value(); }
  void number_pictures() { paraview.number_steps(); } ///< in place of their times
  /// An eigenmode @p x, counted from one, which is its time in the series.
  void write_mode(const BlockSystem<dim> &system, const Vector &x, unsigned int number);
  void forget_solution() { forces.reset(); } ///< there is another one, or soon another system
  void find_new_meshes();                    ///< after the old ones have been forgotten

  /// The state before the first step, of which the energy is measured.
  void start(const Solution<dim> &solution);
  /// Probes and balance of a good step, for probes.csv, and its largest imbalance for the report.
  void record_step(const Solution<dim> &solution);
  bool has_probes() const { return !probes.is_empty(); }
  /// Numbers about domains, interfaces, balance and probes. @p tolerance: of Newton's method.
  void measure(const Solution<dim> &solution, double tolerance);
  /// With a run that is more exact, or for runs that are less so.
  void compare(const Solution<dim> &solution);
  /// What a user should know about it. @pre It has been measured.
  void explain(const Solution<dim> &solution);
  void record_ranges(const Solution<dim> &solution); ///< of a good step
  /// Of which values tables and film coefficients were asked in the steps so far, also in a run that fails.
  void explain_ranges(const Solution<dim> &solution);
  void measure_spectrum(const Solution<dim> &solution, const std::vector<SolveGroup> &groups);
  void finish(bool is_converged, const Plan &plan, const nlohmann::ordered_json &counters);

  Report &report() { return *content; } ///< @pre begin() was called
  unsigned int n_files() const { return paraview.n_files(); }
  const std::exception_ptr &problem() const { return problem_of_output; }

private:
  template <typename Write>
  void try_to_write(const Write &write);
  void prepare_directory(const Plan &plan);
  std::string checkpoint_file() const { return directory + "/checkpoint.bin"; }
  void write_used() const;
  void write_step_table();
  void bring_files_to_disk();
  const NodalForces<dim> &nodal_forces(const Solution<dim> &solution);
  std::vector<Columns> columns_of_probes(const Vector &ghosted, const Reactions<dim> &reactions);
  double last_residual() const;
  void restore_energy(const nlohmann::ordered_json &sums, const SavedState &from);
  const Vector *find_velocity(const Solution<dim> &solution); ///< nullptr: nothing asks for it

  const SceneText &text;
  const Model<dim> &model;
  Probes<dim> &probes;
  Phases &phases;
  Notes &notes;
  Log &log;
  std::string directory;
  unsigned int every_steps, checkpoint_steps;
  bool with_spectrum;
  Paraview<dim> paraview;
  Reference<dim> reference;
  std::optional<EnergyBalance<dim>> energy_balance;
  std::unique_ptr<DirectoryLock> lock;
  std::unique_ptr<Report> content;
  UsedRanges<dim> used_ranges;
  StepTable step_table;
  std::size_t n_steps_so_far = 0, n_notes_so_far = 0; ///< in the report, at the last good step
  std::optional<Vector> velocity;                     ///< ghosted; probes and pictures refer to it
  std::optional<NodalForces<dim>> forces;             ///< at the solution, once they are asked for
  std::exception_ptr problem_of_output;               ///< why no more pictures are written
};

} // namespace dovetail
