// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// b = rho (a + omega^2 r)

#include <dovetail/domain/body_force.h>
#include <dovetail/scene/undefined.h>

namespace dovetail {

template <int dim>
BodyForce<dim>::BodyForce(const Section &section, const Material<dim> &material) : section(section)
{
  const Expression a = section.read_expression(
      "Acceleration", "", {section.dimension()},
      "Body force per mass, such as gravity; it needs the Density of the Solid [m/s^2]");
  const Expression velocity = section.read_expression(
      "Angular velocity", "", {1},
      "Of a body that turns about the Axis: centrifugal force; it needs the Density of the Solid [rad/s]");
  const bool has_acceleration = section.is_set("Acceleration") && !a.is_zero(),
             has_rotation = section.is_set("Angular velocity") && !velocity.is_zero();
  for (const std::string entry : {"Axis", "Axis point"})
    section.check(!section.is_set(entry) || section.is_set("Angular velocity"), entry,
                  "belongs to an Angular velocity, which is not given.");
  section.check(!velocity.depends_on_position(), "Angular velocity", "must depend on t only.");
  if (section.is_set("Angular velocity") || section.documenting()) {
    const RotationAxis<dim> axis(section);
    if (has_rotation)
      rotation = Rotation{velocity, axis};
  }
  if (section.documenting())
    return;
  if (has_acceleration)
    acceleration = a;
  if (!is_given())
    return;
  const std::string entry = acceleration ? "Acceleration" : "Angular velocity";
  const Field *solid = material.solid_field();
  section.check(solid != nullptr, entry,
                "acts on the mass of a solid, but the material " + material.name +
                    " of this domain has no solid law.");
  density = material.solid_density();
  section.check(density > 0, entry,
                "needs the Density of the Solid of the material " + material.name + ", which is not given.");
  first = solid->first_component;
  has_large_strain = material.has_large_strain();
}

template <int dim>
double BodyForce<dim>::square_of_velocity(const dealii::Point<dim> &X, const double t) const
{
  const double omega = finite(rotation->velocity.value(X, t), section, "Angular velocity", X, t);
  return omega * omega;
}

template <int dim>
dealii::Tensor<1, dim> BodyForce<dim>::value(const dealii::Point<dim> &X, const double t,
                                             const dealii::Tensor<1, dim> &u) const
{
  dealii::Tensor<1, dim> b;
  if (acceleration)
    for (unsigned int c = 0; c < dim; ++c)
      b[c] = density * finite(acceleration->value(X, t, c), section, "Acceleration", X, t);
  if (rotation)
    b += density * square_of_velocity(X, t) * rotation->axis.distance(depends_on_displacement() ? X + u : X);
  return b;
}

template <int dim>
dealii::Tensor<2, dim> BodyForce<dim>::derivative(const dealii::Point<dim> &X, const double t) const
{
  return density * square_of_velocity(X, t) * rotation->axis.projection();
}

template class BodyForce<2>;
template class BodyForce<3>;

} // namespace dovetail
