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

std::vector<unsigned int> read_components(const Section &section, const Field &field)
{
  const std::string letters = "xyz";
  const auto names = section.read<std::vector<std::string>>(
      "Components", {},
      "The prescribed components of a vector (x, y, z); if empty, all components are prescribed [-]");
  std::vector<unsigned int> components;
  if (names.empty() || section.documenting())
    for (unsigned int c = 0; c < field.n_components; ++c)
      components.push_back(c);
  else
    for (const std::string &name : names) {
      const auto c = name.size() == 1 ? letters.find(name) : std::string::npos;
      section.check(c != std::string::npos && c < field.n_components && field.n_components > 1, "Components",
                    "has '" + name + "', but " +
                        (field.n_components > 1
                             ? "the components of the " + field.name + " are " +
                                   (field.n_components == 2 ? "x, y." : "x, y, z.")
                             : "the " + field.name + " is a scalar: leave the entry out."));
      section.check(std::find(components.begin(), components.end(), c) == components.end(), "Components",
                    "has '" + name + "' twice.");
      components.push_back(c);
    }
  return components;
}

template <int dim>
class Value : public Condition<dim>
{
public:
  Value(const Section &section, const std::vector<Field> &fields, const Toggles &toggles)
      : Condition<dim>(section, fields, toggles), components(read_components(section, this->field)),
        expression(
            section.require_expression("Expression", {static_cast<unsigned int>(components.size())},
                                       "The value, one formula per component, separated by ';' [m or K]"))
  {
  }

  std::vector<unsigned int> prescribed_components() const override { return components; }

  double prescribed_value(const dealii::Point<dim> &X, const double t,
                          const unsigned int component) const override
  {
    const auto position = std::find(components.begin(), components.end(), component) - components.begin();
    return finite(expression.value(X, t, position), this->section, "Expression", X, t);
  }

  bool removes_constants() const override { return true; }

private:
  const std::vector<unsigned int> components;
  const Expression expression;
};

const bool registered = add_condition<Value>("value", "The value of the field is prescribed.");

} // namespace

} // namespace dovetail
