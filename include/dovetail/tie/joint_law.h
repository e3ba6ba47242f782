// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Laws of joints between solids at one point: traction over opening, with a memory. A law is one file.

#pragma once

#include <dovetail/material/memory.h>
#include <dovetail/scene/catalogue.h>

#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>

#include <array>

namespace dovetail {

/// Where a joint is and what it remembers there.
struct JointPlace
{
  dealii::Point<3> X;
  double t = 0;
  std::array<double, 2> stiffness = {{0, 0}}; ///< `Joint stiffness` along the normal and across it, positive
  Memory memory;
};

/// Traction and its derivative. Component 0 is along the normal, positive in tension; the others are across.
struct JointResponse
{
  dealii::Tensor<1, 3> traction;
  dealii::Tensor<2, 3> by_opening;
};

/// The traction by which a joint pulls the two sides together, per undeformed area, as a function of its
/// opening, the displacement of the destination from the source: component 0 along the normal, the other two
/// across it, where all directions are alike. Each evaluation writes the trial memory (memory.h).
class JointLaw
{
public:
  virtual ~JointLaw() = default;

  virtual std::vector<InternalVariable> internal_variables() const { return {}; }
  /// @return false if it is not defined there
  virtual bool evaluate(const JointPlace &place, const dealii::Tensor<1, 3> &opening,
                        JointResponse &response) const = 0;
  /// The largest amount by which the traction falls per opening [Pa/m]; what a tie adds to its penalty, so
  /// that the opening of the joint follows from the states of the two sides.
  virtual double softening(const JointPlace &place) const = 0;
  /// The derivative, with one stiffness for all directions or two.
  virtual bool is_symmetric(bool has_one_stiffness) const = 0;
};

using JointCatalogue = Catalogue<JointLaw>;

/// The opening w in series with a penalty, t(w) + gamma w = r, by Newton's method with halved steps: the left
/// side is monotone if gamma is larger than the softening. @return false if the law is not defined, or no
/// solution is found
bool find_opening(const JointLaw &law, const JointPlace &place, double gamma, const dealii::Tensor<1, 3> &r,
                  dealii::Tensor<1, 3> &opening, JointResponse &response);

} // namespace dovetail
