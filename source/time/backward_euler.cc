// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The backward Euler scheme: with the state x_n and the rate v_n at the beginning of a step of size h,
//
//     dx/dt = (x - x_n) / h,    d2x/dt2 = (dx/dt - v_n) / h
//
// Of order one. It is L-stable: whatever the size of the step, what decays fast is gone after it. It damps
// oscillations, too: those of the frequency w lose the factor 1 / sqrt(1 + (w h)^2) in each step.
//
// Reference: Hairer & Wanner, Solving Ordinary Differential Equations II (1996), section IV.3.
//
//     subsection Steps
//       set Kind   = transient
//       set Scheme = backward Euler
//     end

#include <dovetail/time/time_scheme.h>

namespace dovetail {

class BackwardEuler : public TimeScheme
{
public:
  explicit BackwardEuler(const Section & /*steps*/) {}

  std::string description() const override { return "backward Euler, of order 1"; }
  unsigned int order() const override { return 1; }

  Rates rates(const StepTime &step) const override
  {
    const double h = step.size;
    Rates result;
    result.by_value = 1 / h;
    set_rest({-1 / h}, result);
    if (!memory().rates.empty()) {
      result.second_by_value = 1 / (h * h);
      result.second_rest = result.rest;
      result.second_rest -= memory().rates[0];
      result.second_rest *= 1 / h;
    }
    return result;
  }

protected:
  unsigned int n_states() const override { return 1; }
};

namespace {
[[maybe_unused]] const bool registered = TimeSchemeCatalogue::add<BackwardEuler>(
    "backward Euler", "Of order one, for any size of the steps without oscillations.");
}

} // namespace dovetail
