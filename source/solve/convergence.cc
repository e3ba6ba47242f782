// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/solve/convergence.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

Convergence::Convergence(std::vector<unsigned int> field_of_part, std::vector<bool> is_constraint,
                         const double relative_tolerance, const double absolute_tolerance)
    : field_of_part(std::move(field_of_part)), is_constraint(std::move(is_constraint)),
      is_measured(this->field_of_part.size(), true), relative_tolerance(relative_tolerance),
      absolute_tolerance(absolute_tolerance)
{
  begin_step();
}

void Convergence::begin_step()
{
  const unsigned int n_fields =
      field_of_part.empty() ? 0 : *std::max_element(field_of_part.begin(), field_of_part.end()) + 1;
  first_forces.assign(n_fields, 0.);
}

double Convergence::residual(const WorkingForces &now)
{
  const unsigned int n_parts = field_of_part.size();
  std::vector<double> field_forces(first_forces.size(), 0.);
  for (unsigned int p = 0; p < n_parts; ++p) // moving prescribed values act at first by the residual alone
    if (is_measured[p])
      field_forces[field_of_part[p]] =
          std::hypot(field_forces[field_of_part[p]], std::max(now.forces[p], now.residuals[p]));
  for (unsigned int f = 0; f < field_forces.size(); ++f)
    if (first_forces[f] == 0 && std::isfinite(field_forces[f]))
      first_forces[f] = field_forces[f];
  last_forces = now.forces;

  double largest = 0;
  hides_any = false;
  for (unsigned int p = 0; p < n_parts; ++p) {
    const double first = first_forces[field_of_part[p]];
    if (!is_measured[p])
      continue;
    if (!std::isfinite(now.residuals[p]) || !std::isfinite(now.forces[p])) {
      worst = p;
      return std::numeric_limits<double>::quiet_NaN();
    }
    if (now.residuals[p] <= absolute_tolerance)
      continue;
    const double reference = std::min(now.forces[p], largest_growth * first);
    const double relative = reference > 0 ? now.residuals[p] / reference : 1.;
    if (now.residuals[p] <= now.rounding[p]) {
      hides_any = hides_any || relative > relative_tolerance;
      continue;
    }
    if (relative > largest)
      worst = p;
    largest = std::max(largest, relative);
  }
  return largest;
}

bool Convergence::is_small(const WorkingUpdate &update) const
{
  const double infinity = std::numeric_limits<double>::infinity();
  std::vector<double> smallest(first_forces.size(), infinity), largest(first_forces.size(), -infinity);
  for (unsigned int p = 0; p < field_of_part.size(); ++p) {
    smallest[field_of_part[p]] = std::min(smallest[field_of_part[p]], update.smallest_value[p]);
    largest[field_of_part[p]] = std::max(largest[field_of_part[p]], update.largest_value[p]);
  }
  for (unsigned int p = 0; p < field_of_part.size(); ++p) {
    const unsigned int f = field_of_part[p];
    const double range = std::max(largest[f] - smallest[f],
                                  smallest_range * std::max(std::abs(largest[f]), std::abs(smallest[f])));
    if (is_constraint[p] || !is_measured[p])
      continue;
    if (!(update.largest[p] <= largest_update * range))
      return false;
    const double work = last_forces[p] * range * std::sqrt(update.n_unknowns[p]);
    if (!(update.energies[p] <= largest_update * largest_update * work))
      return false;
  }
  return true;
}

} // namespace dovetail
