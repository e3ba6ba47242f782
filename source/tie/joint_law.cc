// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/tie/joint_law.h>

#include <dovetail/scene/undefined.h>

#include <cmath>

namespace dovetail {

namespace {

using dealii::Tensor;

/// t(w) + gamma w - r at an opening w, and the size of its terms.
struct Imbalance
{
  bool evaluate(const JointLaw &law, const JointPlace &place, const double gamma, const Tensor<1, 3> &r)
  {
    if (!law.evaluate(place, opening, response))
      return false;
    rest = response.traction + gamma * opening - r;
    size = response.traction.norm() + gamma * opening.norm() + r.norm();
    return std::isfinite(rest.norm());
  }

  Tensor<1, 3> opening, rest;
  JointResponse response;
  double size = 0;
};

constexpr double rounding = 1e-15, acceptable = 1e-12; ///< of the terms

} // namespace

bool find_opening(const JointLaw &law, const JointPlace &place, const double gamma, const Tensor<1, 3> &r,
                  Tensor<1, 3> &opening, JointResponse &response)
{
  const Tensor<2, 3> penalty = gamma * dealii::unit_symmetric_tensor<3>();
  Imbalance now, next;
  now.opening[0] = r[0] / (gamma + place.stiffness[0]);
  for (const unsigned int i : {1, 2})
    now.opening[i] = r[i] / (gamma + place.stiffness[1]);
  if (!now.evaluate(law, place, gamma, r))
    return false;
  const unsigned int most_iterations = 100, most_halvings = 20;
  for (unsigned int i = 0; i < most_iterations && now.rest.norm() > rounding * now.size; ++i) {
    const Tensor<2, 3> slope = now.response.by_opening + penalty;
    if (!(determinant(slope) > 0))
      return undefined("the traction of the joint falls by more per opening than the law says");
    const Tensor<1, 3> step = invert(slope) * now.rest;
    double share = 1;
    unsigned int n_halvings = 0;
    for (; n_halvings < most_halvings; ++n_halvings, share /= 2) {
      next.opening = now.opening - share * step;
      if (!next.evaluate(law, place, gamma, r))
        return false;
      if (next.rest.norm() < now.rest.norm())
        break;
    }
    if (n_halvings == most_halvings) // rounding, or none
      break;
    std::swap(now, next);
  }
  if (!(now.rest.norm() <= acceptable * now.size))
    return undefined("no opening of the joint fits the states of the two sides");
  if (!law.evaluate(place, now.opening, response)) // the trial memory is that of the solution
    return false;
  opening = now.opening;
  return true;
}

} // namespace dovetail
