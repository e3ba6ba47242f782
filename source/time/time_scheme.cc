// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/time/time_scheme.h>

#include <algorithm>

namespace dovetail {

void TimeScheme::start(const Vector &x)
{
  remembered = {StepTime(), {x}, {}};
}

void TimeScheme::start(const Vector &x, const Vector &rate)
{
  remembered = {StepTime(), {x}, {rate}};
}

void TimeScheme::accept_step(const StepTime &step, const Vector &x)
{
  if (!remembered.rates.empty()) {
    const Rates step_rates = rates(step);
    Vector rate = step_rates.rest;
    rate.add(step_rates.by_value, x);
    remember(rate, remembered.rates);
  }
  remember(x, remembered.states);
  remembered.last = step;
}

/// The oldest one makes room.
void TimeScheme::remember(const Vector &newest, std::vector<Vector> &all) const
{
  if (all.size() < n_states())
    all.insert(all.begin(), newest);
  else {
    std::rotate(all.begin(), all.end() - 1, all.end());
    all.front() = newest;
  }
}

std::unique_ptr<TimeScheme> make_time_scheme(const Section &steps)
{
  return TimeSchemeCatalogue::create_by(
      "Scheme", steps, "backward Euler",
      "How rates follow from the states of the steps in transient scenes [-]");
}

} // namespace dovetail
