// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A boundary turns like a rigid body: u = (R(angle) - 1)(X - axis point), with the rotation R about the axis
// (in 2D about the point), also by large angles.
//
//     subsection Boundary condition grip
//       set Type         = rotation
//       set Boundary ids = 5
//       set Axis         = 0; 0; 1
//       set Axis point   = 0.5; 0.5; 0
//       set Angle        = pi/6*t
//     end

#include <dovetail/domain/condition.h>
#include <dovetail/domain/rotation_axis.h>
#include <dovetail/scene/undefined.h>

namespace dovetail {

namespace {

template <int dim>
class Rotation : public Condition<dim>
{
public:
  Rotation(const Section &section, const Material<dim> &material, const Toggles &toggles)
      : Condition<dim>(section, material, toggles, {Scope::vectors, Scope::boundary}),
        components(read_components(section, this->field)), axis(section),
        angle(section.require_expression("Angle", {1},
                                         "Angle of the rotation, a formula in t; right-handed about the "
                                         "axis, in 2D counterclockwise [rad]"))
  {
    section.check(dim == 3 || section.top().peek("Geometry") != "axisymmetric", "Type",
                  "is rotation, but a body of revolution has no displacement around its axis.");
    section.check(!angle.depends_on_position(), "Angle", "must depend on t only.");
  }

  std::vector<unsigned int> prescribed_components() const override { return components; }
  double prescribed_value(const dealii::Point<dim> &X, const double t,
                          const unsigned int component) const override
  {
    return axis.displacement(X, finite(angle.value(X, t), this->section, "Angle", X, t))[component];
  }

private:
  const std::vector<unsigned int> components;
  const RotationAxis<dim> axis;
  const Expression angle;
};

const bool registered = add_condition<Rotation>("rotation", "The boundary turns about an axis.");

} // namespace

} // namespace dovetail
