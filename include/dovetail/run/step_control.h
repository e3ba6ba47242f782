// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The loop over the steps: how large the next one is, and what is tried after a failure.

#pragma once

#include <dovetail/output/results.h>
#include <dovetail/run/arc_length.h>
#include <dovetail/run/end_request.h>
#include <dovetail/run/nonlinear_step.h>

#include <exception>
#include <optional>

namespace dovetail {

/// How the load is divided: `subsection Steps`.
struct Steps
{
  explicit Steps(const Section &section);
  double size() const { return end_time / n_steps; } ///< of a step, if none fails

  enum class Kind { of_statics, transient, eigenmodes, arc_length };
  const Section section; ///< for error messages
  Kind kind;
  bool follows_path() const { return kind == Kind::arc_length; }
  bool finds_modes() const { return kind == Kind::eigenmodes; } ///< of the state at the end time
  double end_time;
  unsigned int n_steps;
  bool is_adaptive;            ///< halve a step that does not converge
  double tolerance;            ///< of the error of one step; 0: sizes do not depend on errors
  double smallest, largest;    ///< sizes
  unsigned int largest_number; ///< of steps along a path
  bool controls_errors() const { return tolerance > 0; }
  unsigned int n_equal() const { return controls_errors() ? 1 : n_steps; } ///< if none fails
};

/// Goes from the time 0 to the end by steps that are halved where they fail and doubled where they do not, or
/// whose sizes follow from the error of each. Rates go on from a time at which a toggle switches. If
/// nothing depends on the time, what is not in balance is divided instead. The time, the size of the next
/// step, the number of good ones and the state after the last of them are all that a run goes on from.
template <int dim>
class StepControl
{
public:
  /// All are kept by reference.
  StepControl(const Steps &steps, NonlinearStep<dim> &step, Results<dim> &results, Notes &notes, Log &log,
              const MPI_Comm &communicator);

  /// Steps from the initial state @p x up to the end, or until one fails or a signal asks for the end after
  /// the first good one; x becomes the last good state.
  /// @return whether the end was reached. Collective.
  bool run(Vector &x);
  /// Likewise, by steps along the path of solutions (ArcLength), until it reaches the end time or has the
  /// largest number of steps.
  bool follow_path(Vector &x);
  /// Before run(): what a checkpoint holds takes the place of the initial state. @throw UserError if the end
  /// lies before it.
  void go_on(const nlohmann::ordered_json &saved);
  void go_on_path(const SavedState &saved); ///< likewise, once its vectors are known

  double time() const { return t; } ///< of the last good step
  unsigned int n_done() const { return n_good; }
  /// Wrong input that a later step has found; the steps before it count.
  const std::exception_ptr &problem() const { return problem_of_step; }

private:
  enum class Outcome { converged, inexact, out_of_range, failed, failed_at_any_size };
  double almost_end() const;
  double without_rounding(double time) const;
  NewtonResult try_arc(const Vector &x, double &next, Vector &trial, unsigned int &n_iterations);
  NewtonResult end_path(const Vector &x, double &next, Vector &trial);
  double end_of_next();
  bool is_exact_enough(double next, const Vector &trial);
  Outcome try_step(double next, const Vector &x, Vector &trial);
  NewtonResult continue_in_load(double next, const Vector &x, Vector &trial);
  void accept_step(double next, const Vector &x);
  void remember_good_step();
  void write_checkpoint(const Vector &x);
  bool ends_for_signal(const Vector &x);
  bool is_asked_to_end();
  bool retry_smaller(Outcome outcome, double next);
  void write_last_good(const Vector &x);
  void end_at_last_good(double failed, const Vector &x);

  const Steps &steps;
  NonlinearStep<dim> &step;
  Results<dim> &results;
  Notes &notes;
  Log &log;
  const MPI_Comm communicator;
  double t = 0, size;
  double size_by_error = 0;  ///< of the step after this one
  double rejected_error = 0; ///< of the attempt before, in the first step after a new start
  double cut_short = 0;      ///< where the step would have ended if no toggle had switched
  unsigned int n_good = 0;
  nlohmann::ordered_json last_good;      ///< all of that after the last good step
  std::optional<EndRequest> end_request; ///< once there is a result to lose
  std::exception_ptr problem_of_step;
  ArcLength<dim> arc; ///< along a path
};

} // namespace dovetail
