// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The generalised alpha method for inertia. With the states x, rates v and second rates a of Newmark's
// method,
//
//     x = x_n + h v_n + h^2 ((1/2 - beta) a_n + beta a),   v = v_n + h ((1 - gamma) a_n + gamma a),
//
// a body of the mass M on which the forces f(x, t) act satisfies
//
//     M ((1 - alpha_m) a + alpha_m a_n) = (1 - alpha_f) f(x, t) + alpha_f f(x_n, t_n).
//
// The forces are those of the equations before, f(x_n, t_n) = M b_n. So the equations of a step stand at its
// end,
//
//     M b = f(x, t),   b = ((1 - alpha_m) a + alpha_m a_n - alpha_f b_n) / (1 - alpha_f),
//
// and b, which is linear in x, is the second rate that they see. With the spectral radius r at high
// frequencies,
//
//     alpha_m = (2 r - 1) / (r + 1),  alpha_f = r / (r + 1),
//     gamma = 1/2 - alpha_m + alpha_f,  beta = (1 - alpha_m + alpha_f)^2 / 4.
//
// a_n is the acceleration not at t_n, but earlier or later by a share of the step: a_n - b_n is proportional
// to its size. A step of another size therefore goes on from b_n + (h/h_n) (a_n - b_n), which keeps the
// order.
//
// Of order two and stable for any size of the steps; r = 1 is the trapezoidal rule, which keeps the energy of
// linear bodies, and r = 0 removes in one step what is not resolved. At the beginning, after a toggle has
// switched and after prescribed values have jumped, a_n = b_n is the acceleration for which the equations
// hold at that time. Fields without inertia (heat) see the rates of BDF2.
//
// Reference: Chung & Hulbert, Journal of Applied Mechanics 60 (1993), 371.
//
//     subsection Steps
//       set Kind            = transient
//       set Inertia         = true
//       set Scheme          = generalised alpha
//       set Spectral radius = 0.8
//     end

#include "bdf2.h"

#include <cmath>
#include <sstream>
#include <tuple>
#include <utility>

namespace dovetail {

class GeneralisedAlpha : public Bdf2
{
public:
  explicit GeneralisedAlpha(const Section &steps)
      : Bdf2(steps),
        radius(steps.read<double>(
            "Spectral radius", 0.8,
            "What a step leaves of oscillations of high frequency: 1 everything, 0 nothing [-]")),
        alpha_m((2 * radius - 1) / (radius + 1)), alpha_f(radius / (radius + 1)),
        gamma(0.5 - alpha_m + alpha_f), beta(std::pow(1 - alpha_m + alpha_f, 2) / 4)
  {
    steps.check(radius >= 0 && radius <= 1, "Spectral radius", "must lie between 0 and 1.");
  }

  std::string description() const override
  {
    std::ostringstream words;
    words << "generalised alpha with the spectral radius " << radius << ", of order 2";
    return words.str();
  }

  Rates rates(const StepTime &step) const override
  {
    Rates result = first_rates(step);
    if (memory().rates.empty())
      return result;
    std::tie(result.second_by_value, result.second_rest) = newmark(step);
    const double c = (1 - alpha_m) / (1 - alpha_f);
    result.second_by_value *= c;
    result.second_rest *= c;
    result.second_rest.add(alpha_m / (1 - alpha_f), a(step), -alpha_f / (1 - alpha_f), b(step));
    return result;
  }

  bool asks_for_second_rates(const StepTime &step) const override
  {
    return !memory().rates.empty() && is_start(step);
  }
  void start_second_rates(const Vector &second_rates) override { at_start = second_rates; }

protected:
  void find_rates(const StepTime &step, const Vector &x, Vector &rate,
                  std::vector<Vector> &second_rates) const override
  {
    const Rates seen = rates(step);
    const auto value = [&](const double by_value, Vector rest) {
      rest.add(by_value, x);
      return rest;
    };
    const auto [by_value, rest] = newmark(step);
    std::vector<Vector> found = {value(by_value, rest), value(seen.second_by_value, seen.second_rest)};
    rate = memory().rates[0];
    rate.add(step.size * (1 - gamma), a(step), step.size * gamma, found[0]);
    second_rates = std::move(found);
  }

private:
  bool is_start(const StepTime &step) const { return memory().second_rates.empty() || step.starts_anew; }
  const Vector &b(const StepTime &step) const { return is_start(step) ? at_start : memory().second_rates[1]; }
  /// a_n for a step of this size.
  Vector a(const StepTime &step) const
  {
    if (is_start(step))
      return at_start;
    Vector result = memory().second_rates[0];
    const double ratio = step.size / memory().last.size;
    if (ratio != 1)
      result.sadd(ratio, 1 - ratio, b(step));
    return result;
  }

  /// a, linear in x.
  std::pair<double, Vector> newmark(const StepTime &step) const
  {
    const double h = step.size, by_value = 1 / (beta * h * h);
    Vector rest = memory().states[0];
    rest.sadd(-by_value, -by_value * h, memory().rates[0]);
    rest.add(1 - 1 / (2 * beta), a(step));
    return {by_value, rest};
  }

  const double radius, alpha_m, alpha_f, gamma, beta;
  Vector at_start; ///< second rates
};

namespace {
[[maybe_unused]] const bool registered = TimeSchemeCatalogue::add<GeneralisedAlpha>(
    "generalised alpha",
    "Of order two, for inertia: damps oscillations of high frequency as chosen, others hardly.");
}

} // namespace dovetail
