// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Weight and centrifugal force.

#pragma once

#include <dovetail/domain/rotation_axis.h>
#include <dovetail/material/material.h>
#include <dovetail/scene/section.h>

#include <optional>

namespace dovetail {

/// The force per undeformed volume of a body with the density rho of its Solid in an accelerated and a
/// turning frame,
/// @f[ b = \rho\,(a + \omega^2 r), \qquad r = (1 - e e^T)(x - \text{Axis point}) . @f]
/// At large strain x = X + u is the deformed position, so that the force grows where the body moves outward
/// (spin softening, with the derivative rho omega^2 (1 - e e^T)); for a law of small strain x = X.
template <int dim>
class BodyForce
{
public:
  /// Reads Acceleration, Angular velocity, Axis and Axis point of a Domain.
  BodyForce(const Section &section, const Material<dim> &material);

  bool is_given() const { return acceleration || rotation; }
  bool depends_on_displacement() const { return rotation && has_large_strain; }
  bool depends_on_time() const
  {
    return (acceleration && acceleration->depends_on_time()) ||
           (rotation && rotation->velocity.depends_on_time());
  }
  /// The component of the domain with which the displacement begins.
  unsigned int first_component() const { return first; }

  /// b at X and t; @p u: the displacement there.
  dealii::Tensor<1, dim> value(const dealii::Point<dim> &X, double t, const dealii::Tensor<1, dim> &u) const;
  dealii::Tensor<2, dim> derivative(const dealii::Point<dim> &X, double t) const; ///< db/du

private:
  double square_of_velocity(const dealii::Point<dim> &X, double t) const;

  struct Rotation
  {
    Expression velocity;
    RotationAxis<dim> axis;
  };
  const Section section; ///< for error messages
  std::optional<Expression> acceleration;
  std::optional<Rotation> rotation;
  double density = 0;
  unsigned int first = 0;
  bool has_large_strain = false;
};

} // namespace dovetail
