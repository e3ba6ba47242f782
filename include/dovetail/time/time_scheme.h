// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How rates follow from the states at several times.

#pragma once

#include <dovetail/scene/catalogue.h>
#include <dovetail/time/rates.h>
#include <dovetail/time/step_time.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

namespace dovetail {

/// What a scheme goes on from: all that a checkpoint has to hold. Written by good steps only, so a step that
/// fails or is repeated with another size leaves no trace.
struct TimeMemory
{
  using Vector = Rates::Vector;

  StepTime last;                    ///< good step; of size 0 at the beginning
  std::vector<double> sizes;        ///< of the last good steps, the newest first
  std::vector<Vector> states;       ///< solutions of the last good steps, the newest first
  std::vector<Vector> rates;        ///< of these; empty if no term asks for second rates
  std::vector<Vector> second_rates; ///< what a scheme knows of them after the last good step
};

/// What one step adds to the error of the solution, as far as the states of the steps before tell.
struct StepError
{
  Rates::Vector state_error;
  /// The error shrinks like size^(order + 1). 0: nothing is known but how far the step has led.
  unsigned int order;
};

/// A scheme of one or several steps for the rates of all unknowns. Knows vectors, no finite elements and no
/// equations. A plugin: copy backward_euler.cc.
class TimeScheme
{
public:
  using Vector = Rates::Vector;

  virtual ~TimeScheme() = default;

  virtual std::string description() const = 0; ///< "backward Euler, of order 1"
  virtual unsigned int order() const = 0;
  /// The rates during a step that begins at memory().last.end, linear in the state at its end. Those of order
  /// two only if memory().rates is not empty.
  virtual Rates rates(const StepTime &step) const = 0;

  /// Whether rates() wants to know the second rates at the beginning of a step: those for which the equations
  /// of that time hold, start_second_rates(), before it is asked.
  virtual bool asks_for_second_rates(const StepTime & /*step*/) const { return false; }
  virtual void start_second_rates(const Vector & /*second_rates*/) {}
  void change_rate(const Vector &rate) { remembered.rates[0] = rate; } ///< of the last good step

  void start(const Vector &x);                     ///< at the time 0 with the state @p x
  void start(const Vector &x, const Vector &rate); ///< likewise, if some term asks for second rates
  StepTime step_to(const double end, const bool starts_anew = false) const
  {
    return remembered.last.next(end, starts_anew);
  }
  /// Before start(): remember one more state than rates() asks for, which local_error() does.
  void estimate_errors() { estimates_errors = true; }
  /// The rates tell of which states they are made.
  void show_past() { shows_past = true; }
  /// Of a step that has led to @p x. With the divided difference x[...] of the k + 2 newest states, x among
  /// them, the error of backward differences of order k,
  /// @f[ x[t_{n+1}, \dots, t_{n-k}]\, \prod_{j=1}^{k} (t_{n+1} - t_{n+1-j}) / \mathrm{by\_value}, @f]
  /// which is proportional to the difference of x and its extrapolation from the states before (predictor
  /// and corrector). k is the order, or smaller while fewer states are known; without any other state
  /// than the last one x - x_n, of order 0.
  StepError local_error(const StepTime &step, const Vector &x) const;
  /// A step has led to @p x: the next one begins there.
  void accept_step(const StepTime &step, const Vector &x);

  const TimeMemory &memory() const { return remembered; }
  void restore(TimeMemory memory) { remembered = std::move(memory); } ///< from a checkpoint

protected:
  /// The rate at the end of a step to @p x, which memory().rates keeps, and what memory().second_rates keeps.
  /// Called only if some term asks for second rates.
  virtual void find_rates(const StepTime &step, const Vector &x, Vector &rate,
                          std::vector<Vector> &second_rates) const;
  virtual unsigned int n_states() const = 0; ///< how many good steps rates() looks back on
  /// The rest of first rates, rest = sum_j weights[j] states[j]. A weight of zero: that state may be missing.
  void set_rest(const std::vector<double> &weights, Rates &rates) const;
  /// How many of them belong to the curve of a step.
  unsigned int n_known(const StepTime &step) const
  {
    return step.begins_curve() ? 1 : remembered.states.size();
  }

private:
  void remember(const Vector &newest, std::vector<Vector> &all) const;
  unsigned int n_remembered() const { return std::max(n_states(), estimates_errors ? order() + 1 : 0); }

  TimeMemory remembered;
  bool estimates_errors = false, shows_past = false;
};

using TimeSchemeCatalogue = Catalogue<TimeScheme>;

/// Reads the entry `Scheme` of `subsection Steps`; nullptr while documenting.
std::unique_ptr<TimeScheme> make_time_scheme(const Section &steps);

} // namespace dovetail
