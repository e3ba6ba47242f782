// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a person sees on the screen while the program runs.

#pragma once

#include <dovetail/output/plan.h>
#include <dovetail/output/table.h>

#include <nlohmann/json.hpp>

#include <deal.II/base/timer.h>

#include <string>
#include <vector>

namespace dovetail {

/// How much the log says: results and notes only; one line per step in runs of many steps; all iterations.
enum class Detail { quiet, usual, verbose };

/// Writes to the standard output of rank 0; on a terminal with a progress bar over the steps below the last
/// line. A run of more than `most_steps_in_full` steps prints one line per step, with what the iterations of
/// a step that fails have said.
class Log
{
public:
  explicit Log(const MPI_Comm &communicator, Detail detail = Detail::usual);
  ~Log();

  void title(const std::string &scene);

  /// Tables of domains and interfaces; collective. @pre The model is paired.
  template <int dim>
  void summary(const Model<dim> &model);

  /// Time and memory of the pairing by point and by segment; collective. Nothing without interfaces.
  template <int dim>
  void cost_of_pairing(const Model<dim> &model);

  /// What will be done, and what not and why.
  void plan(const Plan &plan);

  /// @p step may be beyond @p n_steps when steps were halved; @p n_steps is 0 if nobody knows; @p time is
  /// that of its end.
  void step_begins(unsigned int step, unsigned int n_steps, double time, double end_time);
  void newton_iteration(unsigned int iteration, double residual, unsigned int linear_iterations,
                        double damping);
  /// @p remark: why the step ended otherwise than by convergence, e.g. "did not converge, half of the step is
  /// tried".
  /// Collective.
  void step_ends(const std::string &remark = "");
  /// What one line per step has kept back of this step.
  void show_details();

  /// The meshes after so many adaptive cycles.
  void cycle(unsigned int n_done, unsigned int n_cycles, unsigned long n_unknowns, double estimated_error);
  /// Likewise, with the parts "probes", "probe errors" and "probe estimates" of a report.
  void cycle(unsigned int n_done, unsigned int n_cycles, unsigned long n_unknowns,
             const nlohmann::ordered_json &report);

  /// Probes, errors, jumps and seconds of the report, and where the files are.
  void finish(const nlohmann::ordered_json &report, const std::string &directory);

  void line(const std::string &text = "");                ///< not if quiet
  void table(const Table &rows);                          ///< after an empty line, not if quiet
  void tell(const std::string &text = "");                ///< in any case
  void detail(const std::string &text);                   ///< of an iteration
  unsigned int n_lines() const { return count_of_lines; } ///< so far

private:
  void draw_bar() const;
  void erase_bar() const;
  std::string time_left() const; ///< "about 12 s left", or nothing where nobody knows
  std::string summary_of_step() const;

  static constexpr unsigned int most_steps_in_full = 10;

  const MPI_Comm communicator;
  const Detail level;
  unsigned int count_of_lines = 0;
  const bool is_speaking; ///< this is rank 0
  const bool has_terminal;
  bool has_bar = false;
  bool is_brief = false; ///< one line per step
  double time_of_step = 0, time_done = 0, end_time = 1;
  std::string name_of_step; ///< "Step 2 of 30, t = 0.5"
  unsigned int n_iterations = 0;
  double last_residual = 0;
  std::vector<std::string> kept_back;
  dealii::Timer since_steps_began;
};

} // namespace dovetail
