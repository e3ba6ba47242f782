// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/time/time_scheme.h>

#include <algorithm>

namespace dovetail {

void TimeScheme::start(const Vector &x)
{
  remembered = {StepTime(), {}, {x}, {}, {}};
}

void TimeScheme::start(const Vector &x, const Vector &rate)
{
  remembered = {StepTime(), {}, {x}, {rate}, {}};
}

void TimeScheme::accept_step(const StepTime &step, const Vector &x)
{
  const unsigned int n = n_known(step);
  if (!remembered.rates.empty()) {
    Vector rate;
    find_rates(step, x, rate, remembered.second_rates);
    remembered.rates.resize(n);
    remember(rate, remembered.rates);
  }
  remembered.states.resize(n);
  remembered.sizes.resize(n - 1);
  remember(x, remembered.states);
  remembered.sizes.insert(remembered.sizes.begin(), step.size);
  remembered.sizes.resize(remembered.states.size() - 1);
  remembered.last = step;
}

void TimeScheme::set_rest(const std::vector<double> &weights, Rates &rates) const
{
  rates.rest = remembered.states[0];
  rates.rest *= weights[0];
  for (unsigned int j = 0; j < weights.size(); ++j)
    if (weights[j] != 0) {
      if (j > 0)
        rates.rest.add(weights[j], remembered.states[j]);
      if (shows_past) {
        rates.weights.push_back(weights[j]);
        rates.past.push_back(remembered.states[j]);
      }
    }
}

void TimeScheme::find_rates(const StepTime &step, const Vector &x, Vector &rate,
                            std::vector<Vector> & /*second_rates*/) const
{
  const Rates at_end = rates(step);
  rate = at_end.rest;
  rate.add(at_end.by_value, x);
}

StepError TimeScheme::local_error(const StepTime &step, const Vector &x) const
{
  const std::vector<Vector> &states = remembered.states;
  const unsigned int k = std::min(n_known(step) - 1, order());
  StepError error = {x, k};
  if (k == 0) {
    error.state_error -= states[0];
    return error;
  }
  std::vector<double> before = {0, step.size}; // t_(n+1) - t_(n+1-j)
  for (unsigned int j = 0; j < k; ++j)
    before.push_back(before.back() + remembered.sizes[j]);
  double product = 1 / rates(step).by_value;
  for (unsigned int j = 1; j <= k; ++j)
    product *= before[j];
  const auto weight = [&](const unsigned int i) { // of x_(n+1-i) in the divided difference
    double divisor = 1;
    for (unsigned int j = 0; j < before.size(); ++j)
      divisor *= j == i ? 1 : before[j] - before[i];
    return product / divisor;
  };
  error.state_error *= weight(0);
  for (unsigned int i = 1; i < before.size(); ++i)
    error.state_error.add(weight(i), states[i - 1]);
  return error;
}

/// The oldest one makes room.
void TimeScheme::remember(const Vector &newest, std::vector<Vector> &all) const
{
  if (all.size() < n_remembered())
    all.insert(all.begin(), newest);
  else {
    std::rotate(all.begin(), all.end() - 1, all.end());
    all.front() = newest;
  }
}

std::unique_ptr<TimeScheme> make_time_scheme(const Section &steps)
{
  return TimeSchemeCatalogue::create_by(
      "Scheme", steps, "BDF2", "How rates follow from the states of the steps in transient scenes [-]");
}

} // namespace dovetail
