// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Backward differences of order two with variable steps: with w = h / h_n, the ratio of the sizes of this
// step and the one before,
//
//     dx/dt = ( (1 + 2 w) x - (1 + w)^2 x_n + w^2 x_(n-1) ) / ((1 + w) h)
//
// and the same of the rates for d2x/dt2. L-stable at constant steps, and stable as long as w < 1 + sqrt(2).
// The first step, the first one after a toggle has switched or prescribed values have jumped, and a step that
// is more than twice as long as the one before are steps of backward Euler, w = 0.
//
// Reference: Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), section III.5.
//
//     subsection Steps
//       set Kind   = transient
//       set Scheme = BDF2
//     end

#include "bdf2.h"

namespace dovetail {

namespace {

constexpr double largest_ratio = 2 + 1e-10;

double by_value(const double w, const double h)
{
  return (1 + 2 * w) / ((1 + w) * h);
}

TimeScheme::Vector rest(const std::vector<TimeScheme::Vector> &before, const double w, const double h)
{
  TimeScheme::Vector sum = before[0];
  sum *= -(1 + w) / h;
  if (w > 0)
    sum.add(w * w / ((1 + w) * h), before[1]);
  return sum;
}

} // namespace

Rates Bdf2::first_rates(const StepTime &step) const
{
  const double h = step.size, w = ratio(step, step.begins_curve());
  Rates result;
  result.by_value = by_value(w, h);
  set_rest({-(1 + w) / h, w * w / ((1 + w) * h)}, result);
  return result;
}

Rates Bdf2::rates(const StepTime &step) const
{
  Rates result = first_rates(step);
  if (!memory().rates.empty()) {
    const double h = step.size, w = ratio(step, step.starts_anew), of_motion = by_value(w, h);
    result.second_by_value = of_motion * of_motion;
    result.second_rest = rest(memory().rates, w, h);
    result.second_rest.add(of_motion,
                           step.first_rates_start_anew ? rest(memory().states, w, h) : result.rest);
  }
  return result;
}

/// Of what has second rates.
void Bdf2::find_rates(const StepTime &step, const Vector &x, Vector &rate,
                      std::vector<Vector> & /*second_rates*/) const
{
  const double h = step.size, w = ratio(step, step.starts_anew);
  rate = rest(memory().states, w, h);
  rate.add(by_value(w, h), x);
}

/// 0 in a step of backward Euler.
double Bdf2::ratio(const StepTime &step, const bool starts_anew) const
{
  if (starts_anew || memory().states.size() < 2)
    return 0;
  const double w = step.size / memory().sizes[0];
  return w > largest_ratio ? 0 : w;
}

namespace {
[[maybe_unused]] const bool registered = TimeSchemeCatalogue::add<Bdf2>(
    "BDF2", "Backward differences of order two; for any size of the steps stiff parts decay.");
}

} // namespace dovetail
