// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/memory.h>

#include <algorithm>

namespace dovetail {

InternalVariables::InternalVariables(const unsigned int n_points, const std::vector<double> &initial)
    : n(initial.size())
{
  for (unsigned int point = 0; point < n_points; ++point)
    of_step.insert(of_step.end(), initial.begin(), initial.end());
  of_trial = of_step;
}

void InternalVariables::set_trial(const unsigned int point, const dealii::ArrayView<double> &values)
{
  AssertDimension(values.size(), n);
  std::copy(values.begin(), values.end(), of_trial.begin() + point * n);
}

void InternalVariables::set_accepted(const unsigned int point, const dealii::ArrayView<const double> &values)
{
  AssertDimension(values.size(), n);
  std::copy(values.begin(), values.end(), of_step.begin() + point * n);
}

} // namespace dovetail
