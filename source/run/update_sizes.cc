// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/update_sizes.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace dovetail {

double UpdateSizes::rounding_of_energy(const BlockMatrix &K, const Vector &dx) const
{
  double largest = 0;
  for (const unsigned int f : std::set<unsigned int>(fields.begin(), fields.end())) {
    Vector of_field = dx, product = dx;
    for (unsigned int b = 0; b < blocks.size(); ++b)
      if (fields[b] != f || blocks[b].is_constraint)
        of_field.block(b) = 0;
    if (of_field.linfty_norm() == 0)
      continue;
    const std::vector<double> sizes = K.sizes_of_products(of_field);
    K.vmult(product, of_field);
    double rounding = 0;
    for (unsigned int b = 0; b < blocks.size(); ++b)
      rounding += sizes[b] * of_field.block(b).l2_norm();
    const double energy = std::abs(of_field * product);
    largest = std::max(largest, energy > 0 ? std::numeric_limits<double>::epsilon() / 2 * rounding / energy
                                           : std::numeric_limits<double>::infinity());
  }
  return largest;
}

double UpdateSizes::share_of(const Vector &correction, const Vector &x, const Vector &dx) const
{
  const double nothing = 1e-12;
  std::vector<double> least(blocks.size(), 0.); // by field
  for (unsigned int b = 0; b < blocks.size(); ++b)
    least[fields[b]] =
        std::max({least[fields[b]], nothing * x.block(b).l2_norm(), nothing * dx.block(b).l2_norm()});
  double largest = 0;
  for (unsigned int b = 0; b < blocks.size(); ++b)
    if (const double size = std::max(dx.block(b).l2_norm(), least[fields[b]]);
        size > 0 && !blocks[b].is_constraint)
      largest = std::max(largest, correction.block(b).l2_norm() / size);
  return largest;
}

double UpdateSizes::part_of_solution(const Vector &x, const Vector &dx) const
{
  Vector sum = x;
  sum += dx;
  std::vector<double> of_update(blocks.size(), 0.), of_sum(blocks.size(), 0.); // by field
  for (unsigned int b = 0; b < blocks.size(); ++b)
    if (!blocks[b].is_constraint) {
      of_update[fields[b]] = std::hypot(of_update[fields[b]], dx.block(b).l2_norm());
      of_sum[fields[b]] = std::hypot(of_sum[fields[b]], sum.block(b).l2_norm());
    }
  double largest = 0;
  for (unsigned int f = 0; f < of_sum.size(); ++f)
    if (of_update[f] > 0)
      largest = std::max(largest, of_update[f] / std::max(of_update[f], of_sum[f]));
  return largest;
}

} // namespace dovetail
