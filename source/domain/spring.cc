// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// An elastic foundation: the traction P N = -c u per undeformed area, component by component.
//
//     subsection Boundary condition soil
//       set Type         = spring
//       set Boundary ids = 2
//       set Coefficient  = 1e8; 0; 2e8
//     end

#include <dovetail/domain/condition.h>
#include <dovetail/scene/undefined.h>

namespace dovetail {

namespace {

template <int dim>
class Spring : public Condition<dim>
{
public:
  Spring(const Section &section, const Material<dim> &material, const Toggles &toggles)
      : Condition<dim>(section, material, toggles, {Scope::vectors, Scope::boundary}),
        stiffness(section.require_expression(
            "Coefficient", {1, section.dimension()},
            "Traction per displacement: one number for all directions, or one for each component [Pa/m]"))
  {
    if (!stiffness.depends_on_position() && !stiffness.depends_on_time())
      for (unsigned int c = 0; c < stiffness.n_components(); ++c)
        section.check(stiffness.value(dealii::Point<dim>(), 0., c) >= 0, "Coefficient",
                      "is negative, but must be at least 0.");
  }

  bool adds_flux() const override { return true; }
  bool has_constant_tangent() const override { return !stiffness.depends_on_time(); }
  bool depends_on_time() const override { return stiffness.depends_on_time(); }

  void influx(const State<dim> &state, const dealii::Tensor<1, dim> & /*N*/,
              Influx<dim> &influx) const override
  {
    for (unsigned int i = 0; i < dim; ++i) {
      const unsigned int own = this->field.first_component + i;
      const double c = finite(stiffness.value(state.X, state.t, formula(i)), this->section, "Coefficient",
                              state.X, state.t);
      influx.value[i] = -c * state.value[own];
      influx.by_value(i, own) = -c;
    }
  }

  /// A coefficient that is zero in places or at times counts as one that holds.
  bool removes_constant(const unsigned int component) const override
  {
    return stiffness.depends_on_position() || stiffness.depends_on_time() ||
           stiffness.value(dealii::Point<dim>(), 0., formula(component)) != 0;
  }

private:
  unsigned int formula(const unsigned int component) const
  {
    return stiffness.n_components() == 1 ? 0 : component;
  }

  const Expression stiffness;
};

const bool registered = add_condition<Spring>("spring", "An elastic foundation, traction -c u.");

} // namespace

} // namespace dovetail
