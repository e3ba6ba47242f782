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

#include <dovetail/time/time_scheme.h>

namespace dovetail {

class Bdf2 : public TimeScheme
{
public:
  explicit Bdf2(const Section & /*steps*/) {}

  std::string description() const override { return "BDF2, of order 2"; }
  unsigned int order() const override { return 2; }

  Rates rates(const StepTime &step) const override
  {
    const double h = step.size, w = ratio(step);
    Rates result;
    result.by_value = (1 + 2 * w) / ((1 + w) * h);
    result.rest = rest(memory().states, w, h);
    if (!memory().rates.empty()) {
      result.second_by_value = result.by_value * result.by_value;
      result.second_rest = rest(memory().rates, w, h);
      result.second_rest.add(result.by_value, result.rest);
    }
    return result;
  }

protected:
  unsigned int n_states() const override { return 2; }

private:
  static constexpr double largest_ratio = 2 + 1e-10;

  /// 0 in a step of backward Euler.
  double ratio(const StepTime &step) const
  {
    if (n_known(step) < 2)
      return 0;
    const double w = step.size / memory().sizes[0];
    return w > largest_ratio ? 0 : w;
  }

  static Vector rest(const std::vector<Vector> &before, const double w, const double h)
  {
    Vector sum = before[0];
    sum *= -(1 + w) / h;
    if (w > 0)
      sum.add(w * w / ((1 + w) * h), before[1]);
    return sum;
  }
};

namespace {
[[maybe_unused]] const bool registered = TimeSchemeCatalogue::add<Bdf2>(
    "BDF2", "Backward differences of order two; for any size of the steps stiff parts decay.");
}

} // namespace dovetail
