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
  Convection(const Section &section, const std::vector<Field> &fields, const Toggles &toggles)
      : Condition<dim>(section, fields, toggles),
        coefficient(
            section.require_expression("Coefficient", {1}, "The heat transfer coefficient h [W/(m^2 K)]")),
        ambient(section.require_expression("Ambient", {1}, "The temperature of the surroundings [K]"))
  {
    section.check(this->field.n_components == 1, "Type",
                  "convection acts on scalar fields such as temperature.");
  }

  bool adds_flux() const override { return true; }
  bool has_constant_tangent() const override { return !coefficient.depends_on_time(); }

  void flux(const dealii::Point<dim> &X, const double t, const double *trace, std::vector<double> &flux,
            dealii::FullMatrix<double> &d_flux) const override
  {
    const double h = finite(coefficient.value(X, t), this->section, "Coefficient", X, t);
    flux[0] = h * (finite(ambient.value(X, t), this->section, "Ambient", X, t) - trace[0]);
    d_flux(0, 0) = -h;
  }

  bool removes_constants() const override { return true; }

private:
  const Expression coefficient;
  const Expression ambient;
};

const bool registered =
    add_condition<Convection>("convection", "Heat exchange with a fluid, h (Ambient - T).");

} // namespace

} // namespace dovetail
