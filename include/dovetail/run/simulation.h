// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// From a scene to a report: the order in which things are made, and the loop over the steps.

#pragma once

#include <dovetail/output/log.h>
#include <dovetail/output/paraview.h>
#include <dovetail/output/plan.h>
#include <dovetail/output/probes.h>
#include <dovetail/output/reference.h>
#include <dovetail/output/report.h>
#include <dovetail/run/newton_step.h>
#include <dovetail/run/phases.h>
#include <dovetail/solve/linear_solver.h>
#include <dovetail/solve/newton.h>
#include <dovetail/system/block_system.h>
#include <dovetail/system/error_estimate.h>

#include <exception>
#include <memory>
#include <optional>
#include <string>

namespace dovetail {

/// How the load is divided: `subsection Steps`.
struct Steps
{
  explicit Steps(const Section &section);
  double end_time;
  unsigned int n_steps;
  bool is_adaptive; ///< halve a step that does not converge, down to 1/1024
};

/// How often the meshes are refined at the end time: top-level entries.
struct Adaptivity
{
  explicit Adaptivity(const Section &scene);
  unsigned int n_cycles;
  double share; ///< of the estimated error squared, in the cells that are refined
};

/// A whole run of one scene.
template <int dim>
class Simulation
{
public:
  /// Reads every entry of the scene and makes the meshes and pairings. Collective. @throw UserError
  Simulation(const std::shared_ptr<SceneText> &text, const MPI_Comm &communicator);

  /// Print the plan and the coverage, solve nothing.
  void check();
  /// @return whether all steps converged; otherwise the last good step is kept and written.
  bool run();

private:
  std::vector<SolveGroup> solve_groups() const;
  Plan plan() const;
  /// Model::linear_part, where constrained unknowns are the sum of those they follow.
  std::vector<SolveGroup::Sum> linear_part(unsigned int block_number) const;
  void check_formulas() const;
  /// @p without_initial: a field that starts from given values although it has an `Initial`.
  void set_initial_values(double t, const std::string &without_initial = "");
  bool guess_again(double t);
  void make_system(double t);
  void set_up(double t);
  void begin_step(double t);
  void tell_notes();
  void tell(const std::string &note);
  bool advance(double t, double from);
  void check_range(double t);
  bool nothing_changes(double t, double from);
  bool loads_depend_on_time(double t, double from);
  NewtonResult continue_in_load(double t);
  void go_back(double t);
  void take_account();
  NewtonResult solve_step();
  NewtonResult solve_until_penalties_fit(double t);
  void check_is_held() const;
  void explain_failure(double t);
  bool run_steps(double nominal, double &t, unsigned int &n_done);
  bool run_cycles(double t);
  NewtonResult solve_on_refined_meshes(const ErrorEstimate &estimate, double t);
  void find_forces();
  void write_used() const;
  template <typename Write>
  void try_to_write(const Write &write);
  void write_output(double t, unsigned int step, bool is_last);
  double last_residual() const;
  void measure(double t, bool is_converged);
  void compare(double t, bool is_converged);
  void explain_solution(double t);
  void measure_spectrum_of_groups();
  void write_report(bool is_converged);

  MPI_Comm communicator;
  Phases phases;
  std::shared_ptr<SceneText> text;
  Section scene;
  Log log;
  Model<dim> model;
  Probes<dim> probes;
  Steps steps;
  Newton newton;
  Adaptivity adaptivity;
  std::string directory;
  unsigned int every_steps;
  bool with_spectrum;
  std::unique_ptr<Paraview<dim>> paraview;
  std::unique_ptr<Reference<dim>> reference;
  std::unique_ptr<BlockSystem<dim>> system;
  LinearSolver linear_solver; ///< refers to the system's matrix, so it is destroyed first
  std::unique_ptr<Report> report;
  std::unique_ptr<NewtonStep<dim>> newton_step;
  Vector solution;
  bool can_be_halved = true;                        ///< the step that has failed
  std::optional<NodalForces<dim>> forces;           ///< at the solution, once they are asked for
  bool lacks_multipliers = false;                   ///< those of the solution have not been looked for
  std::string problem_of_step;                      ///< wrong input that a later step has found
  std::exception_ptr problem_of_output;             ///< why no more pictures are written
  typename BlockSystem<dim>::Assemblies assemblies; ///< of systems that are no more
};

/// Read every entry that a scene can have, for the reference (@p text from SceneText::for_documentation).
void read_all_entries(const std::shared_ptr<SceneText> &text);

/// The dimension of a scene, and a check of its geometry.
unsigned int read_dimension(const Section &scene);

} // namespace dovetail
