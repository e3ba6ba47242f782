// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/linear_sums.h>

#include <algorithm>
#include <numeric>

namespace dovetail {

void LinearSums::add(const std::vector<dealii::types::global_dof_index> &dofs,
                     const std::vector<double> &weights_of_sum)
{
  if (places_of.empty() || dofs != last_list) {
    places_of.push_back(unknowns.size());
    unknowns.insert(unknowns.end(), dofs.begin(), dofs.end());
    last_list = dofs;
  } else
    places_of.push_back(places_of.back());
  weights_of.push_back(weights.size());
  lengths.push_back(dofs.size());
  weights.insert(weights.end(), weights_of_sum.begin(), weights_of_sum.end());
}

void LinearSums::close()
{
  const std::vector<dealii::types::global_dof_index> lists = unknowns;
  std::sort(unknowns.begin(), unknowns.end());
  unknowns.erase(std::unique(unknowns.begin(), unknowns.end()), unknowns.end());
  places.clear();
  for (const auto dof : lists)
    places.push_back(std::lower_bound(unknowns.begin(), unknowns.end(), dof) - unknowns.begin());
  values.resize(unknowns.size());
  last_list.clear();
}

void LinearSums::evaluate(const Vector &ghosted, std::vector<double> &sums) const
{
  ghosted.extract_subvector_to(unknowns.begin(), unknowns.end(), values.begin());
  sums.resize(size());
  for (unsigned int k = 0; k < size(); ++k) {
    const unsigned int *place = &places[places_of[k]];
    const double *weight = &weights[weights_of[k]];
    double sum = 0;
    for (unsigned int j = 0; j < lengths[k]; ++j)
      sum += weight[j] * values[place[j]];
    sums[k] = sum;
  }
}

} // namespace dovetail
