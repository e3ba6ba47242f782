// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/memory.h>

#include <algorithm>

namespace dovetail {

InternalVariables::InternalVariables(const unsigned int n_points, const std::vector<double> &initial)
    : n(initial.size())
{
  for (unsigned int point = 0; point < n_points; ++point)
    accepted_values.insert(accepted_values.end(), initial.begin(), initial.end());
  trial_values = accepted_values;
}

void InternalVariables::set_trial(const unsigned int point, const dealii::ArrayView<double> &values)
{
  AssertDimension(values.size(), n);
  std::copy(values.begin(), values.end(), trial_values.begin() + point * n);
}

void InternalVariables::set_accepted(const unsigned int point, const dealii::ArrayView<const double> &values)
{
  AssertDimension(values.size(), n);
  std::copy(values.begin(), values.end(), accepted_values.begin() + point * n);
}

} // namespace dovetail
