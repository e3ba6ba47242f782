// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Exchange with a surrounding fluid (Newton's law of cooling): A.N = h (T_ambient - T).
//
//     subsection Boundary condition hot gas
//       set Type         = convection
//       set Field        = temperature
//       set Boundary ids = 2
//       set Coefficient  = 1500
//       set Ambient      = 1300
//     end

#include <dovetail/domain/condition.h>
#include <dovetail/scene/undefined.h>

namespace dovetail {

namespace {

template <int dim>
class Convection : public Condition<dim>
{
public:
  Convection(const Section &section, const Material<dim> &material, const Toggles &toggles)
      : Condition<dim>(section, material, toggles),
        coefficient(
            section.require_expression("Coefficient", {1}, "The heat transfer coefficient h [W/(m^2 K)]")),
        ambient(section.require_expression("Ambient", {1}, "The temperature of the surroundings [K]"))
  {
    section.check(this->field.n_components == 1, "Type",
                  "convection acts on scalar fields such as temperature.");
  }

  bool adds_flux() const override { return true; }
  bool has_constant_tangent() const override { return !coefficient.depends_on_time(); }

  void influx(const State<dim> &state, const dealii::Tensor<1, dim> & /*N*/,
              Influx<dim> &influx) const override
  {
    const unsigned int own = this->field.first_component;
    const double h =
        finite(coefficient.value(state.X, state.t), this->section, "Coefficient", state.X, state.t);
    influx.value[0] =
        h * (finite(ambient.value(state.X, state.t), this->section, "Ambient", state.X, state.t) -
             state.value[own]);
    influx.by_value(0, own) = -h;
  }

  bool removes_constant(unsigned int /*component*/) const override { return true; }

private:
  const Expression coefficient;
  const Expression ambient;
};

const bool registered =
    add_condition<Convection>("convection", "Heat exchange with a fluid, h (Ambient - T).");

} // namespace

} // namespace dovetail
