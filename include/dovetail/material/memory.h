// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What laws remember at a point from the last good step.

#pragma once

#include <deal.II/base/array_view.h>

#include <string>
#include <vector>

namespace dovetail {

/// An internal variable of a law, such as the plastic strain: 1 number, dim of a vector, 9 of a tensor.
struct InternalVariable
{
  std::string name; ///< for pictures and probes, with its unit in the documentation of the law
  unsigned int n_components = 1;
  double initial = 0; ///< of each component
};

/// The internal variables at one point: those of the last good step, and those at the state at hand, which
/// each evaluation writes. At the state to which the accepted ones belong a law gives the flux of that step
/// and the same variables again.
struct Memory
{
  dealii::ArrayView<const double> accepted;
  dealii::ArrayView<double> trial;

  Memory slice(const unsigned int first, const unsigned int n) const
  {
    return {{accepted.data() + first, n}, {trial.data() + first, n}};
  }
};

/// Internal variables at many points, flat: point, variable. Trials become accepted all at once.
class InternalVariables
{
public:
  InternalVariables() = default;
  InternalVariables(unsigned int n_points, const std::vector<double> &initial);

  unsigned int n_points() const { return n == 0 ? 0 : accepted_values.size() / n; }
  bool empty() const { return accepted_values.empty(); }
  dealii::ArrayView<const double> accepted(const unsigned int point) const
  {
    return {accepted_values.data() + point * n, n};
  }
  void set_trial(unsigned int point, const dealii::ArrayView<double> &values);
  void set_accepted(unsigned int point, const dealii::ArrayView<const double> &values);
  void accept() { accepted_values = trial_values; } ///< all trials @pre all have been set

private:
  unsigned int n = 0;
  std::vector<double> accepted_values, trial_values;
};

} // namespace dovetail
