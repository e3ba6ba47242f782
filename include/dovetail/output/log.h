// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a person sees on the screen while the program runs.

#pragma once

#include <dovetail/output/plan.h>

#include <nlohmann/json.hpp>

#include <string>

namespace dovetail {

/// Writes to the standard output of rank 0; on a terminal with a progress bar over the steps below the last
/// line.
class Log
{
public:
  explicit Log(const MPI_Comm &communicator);
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

  /// @p step may be beyond @p n_steps when steps were halved; @p time is that of its end.
  void step_begins(unsigned int step, unsigned int n_steps, double time, double end_time);
  void newton_iteration(unsigned int iteration, double residual, unsigned int linear_iterations,
                        double damping);
  /// @p remark: why the step ended otherwise than by convergence, e.g. "did not converge, half of the step is
  /// tried".
  void step_ends(const std::string &remark = "");

  /// The meshes after so many adaptive cycles.
  void cycle(unsigned int n_done, unsigned int n_cycles, unsigned long n_unknowns, double estimated_error);

  /// Probes, errors, jumps and seconds of the report, and where the files are.
  void finish(const nlohmann::ordered_json &report, const std::string &directory);

  void line(const std::string &text = "");
  unsigned int n_lines() const { return count_of_lines; } ///< so far

private:
  void draw_bar() const;
  void erase_bar() const;

  unsigned int count_of_lines = 0;
  const bool is_speaking; ///< this is rank 0
  const bool has_terminal;
  bool has_bar = false;
  double time_of_step = 0, time_done = 0, end_time = 1;
};

} // namespace dovetail
