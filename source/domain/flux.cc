// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A nominal influx per undeformed area: A.N = h(X, t). For the displacement a dead load, the first
// Piola-Kirchhoff traction P N; for the temperature the heat into the body.
//
//     subsection Boundary condition pull
//       set Type         = flux
//       set Field        = displacement
//       set Boundary ids = 1
//       set Expression   = 0; -2e6*t
//     end

#include <dovetail/domain/condition.h>
#include <dovetail/scene/undefined.h>

namespace dovetail {

namespace {

template <int dim>
class Flux : public Condition<dim>
{
public:
  Flux(const Section &section, const Material<dim> &material, const Toggles &toggles)
      : Condition<dim>(section, material, toggles),
        expression(section.require_expression(
            "Expression", {this->field.n_components},
            "The influx per undeformed area: traction or heat into the body [Pa or W/m^2]"))
  {
  }

  bool adds_flux() const override { return true; }
  bool adds_flux_to(const unsigned int component) const override { return !expression.is_zero(component); }
  bool has_tangent() const override { return false; }
  bool has_constant_tangent() const override { return true; }
  bool depends_on_time() const override { return expression.depends_on_time(); }

  void influx(const State<dim> &state, const dealii::Tensor<1, dim> & /*N*/,
              Influx<dim> &influx) const override
  {
    for (unsigned int c = 0; c < this->field.n_components; ++c)
      influx.value[c] =
          finite(expression.value(state.X, state.t, c), this->section, "Expression", state.X, state.t);
  }

private:
  const Expression expression;
};

const bool registered = add_condition<Flux>("flux", "A given influx: dead traction or heat.");

} // namespace

} // namespace dovetail
