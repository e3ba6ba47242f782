// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The trace is prescribed: B_c = g_c(X, t) for all components or some of them.
//
//     subsection Boundary condition clamp
//       set Type         = value
//       set Field        = displacement
//       set Boundary ids = 0
//       set Components   = x, y
//       set Expression   = 0; 1e-3*t
//     end

#include <dovetail/domain/condition.h>
#include <dovetail/scene/undefined.h>

namespace dovetail {

namespace {

template <int dim>
class Value : public Condition<dim>
{
public:
  Value(const Section &section, const Material<dim> &material, const Toggles &toggles)
      : Condition<dim>(section, material, toggles), components(read_components(section, this->field)),
        expression(
            section.require_expression("Expression", {static_cast<unsigned int>(components.size())},
                                       "The value, one formula per component, separated by ';' [m or K]")),
        by_nitsche(section.choose("Method", {"strong", "Nitsche"}, 0,
                                  "strong: the nodes of the boundary have the value; Nitsche: weakly, with "
                                  "consistent fluxes and a penalty from the trace eigenvalues of the cells "
                                  "[-]") == 1),
        is_skew(by_nitsche && this->field.n_components > 1 && material.has_large_strain())
  {
  }

  std::vector<unsigned int> prescribed_components() const override { return components; }
  bool is_weak() const override { return by_nitsche; }
  bool is_symmetric() const override { return !is_skew; }
  bool depends_on_time() const override { return expression.depends_on_time(); }

  double prescribed_value(const dealii::Point<dim> &X, const double t,
                          const unsigned int component) const override
  {
    const auto position = std::find(components.begin(), components.end(), component) - components.begin();
    return finite(expression.value(X, t, position), this->section, "Expression", X, t);
  }

private:
  const std::vector<unsigned int> components;
  const Expression expression;
  const bool by_nitsche, is_skew; ///< skew-symmetric at large strain (weak_values.cc)
};

const bool registered = add_condition<Value>("value", "The value of the field is prescribed.");

} // namespace

} // namespace dovetail
