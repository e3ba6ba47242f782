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
  Flux(const Section &section, const std::vector<Field> &fields, const Toggles &toggles)
      : Condition<dim>(section, fields, toggles),
        expression(section.require_expression(
            "Expression", {this->field.n_components},
            "The influx per undeformed area: traction or heat into the body [Pa or W/m^2]"))
  {
  }

  bool adds_flux() const override { return true; }
  bool has_constant_tangent() const override { return true; } // it has none

  void flux(const dealii::Point<dim> &X, const double t, const double *, std::vector<double> &flux,
            dealii::FullMatrix<double> &) const override
  {
    for (unsigned int c = 0; c < this->field.n_components; ++c)
      flux[c] = finite(expression.value(X, t, c), this->section, "Expression", X, t);
  }

private:
  const Expression expression;
};

const bool registered = add_condition<Flux>("flux", "A given influx: dead traction or heat.");

} // namespace

} // namespace dovetail
