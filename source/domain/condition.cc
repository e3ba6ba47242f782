// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/condition.h>
#include <dovetail/material/fields_in_toggles.h>
#include <dovetail/scene/field_toggle.h>
#include <dovetail/scene/undefined.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

Field find_field(const Section &section, const std::vector<Field> &fields, const std::string &name)
{
  std::vector<std::string> known;
  for (const Field &field : fields) {
    if (field.name == name)
      return field;
    known.push_back(field.name);
  }
  section.check(false, "Field",
                "names '" + name + "', which this domain does not have; its material gives it: " +
                    comma_separated(known) + ".");
  return {name, 1, 0, "", ""}; // while documenting: nobody asks for it
}

Field read_field(const Section &section, const std::vector<Field> &fields, const Scope &scope)
{
  if (scope.fields == Scope::any)
    return find_field(section, fields,
                      section.require<std::string>(
                          "Field", "The field it acts on, for instance temperature or displacement [-]"));
  const auto vector =
      std::find_if(fields.begin(), fields.end(), [](const Field &field) { return field.n_components > 1; });
  section.check(vector != fields.end(), "Type",
                "acts on the displacement, which this domain does not have: its material has no solid law.");
  const Field field =
      find_field(section, fields,
                 section.read<std::string>("Field", vector != fields.end() ? vector->name : "",
                                           "The field it acts on, which must be a vector [-]"));
  section.check(field.n_components > 1, "Field",
                "names the " + field.name + ", but this type of condition acts on the displacement.");
  return field;
}

std::set<dealii::types::boundary_id> read_boundary_ids(const Section &section, const Scope &scope)
{
  if (scope.place == Scope::point)
    return {};
  const auto ids = section.require_boundary_ids(
      "Boundary ids", "The boundaries of the mesh on which the condition acts, by ids or names [-]");
  return {ids.begin(), ids.end()};
}

std::string last_part(const std::string &path)
{
  const std::string part = path.substr(path.rfind('/') + 1);
  const std::string kind = "Boundary condition ";
  return part.compare(0, kind.size(), kind) == 0 ? part.substr(kind.size()) : part;
}

} // namespace

template <int dim>
Condition<dim>::Condition(const Section &section, const Material<dim> &material, const Toggles &toggles,
                          const Scope &scope)
    : section(section), name(last_part(section.path())), field(read_field(section, material.fields(), scope)),
      boundary_ids(read_boundary_ids(section, scope)), toggles(&toggles),
      toggle(toggles.read_reference(section))
{
  if (has_field_toggle(section))
    read_formula(material);
}

template <int dim>
void Condition<dim>::read_formula(const Material<dim> &material)
{
  formula = formula_of_toggle(section, toggle);
  components_of_names = components_in_toggles(section.top(), material.fields());
  const std::vector<std::string> names = names_in_toggles(section.top());
  for (unsigned int s = 0; s < names.size(); ++s)
    if (!formula->depends_on_scalar(s))
      components_of_names[s].reset();
    else
      section.check(components_of_names[s].has_value(), "Toggle",
                    "names '" + toggle + "', which looks at the " + names[s] +
                        ", which this domain does not have. Take a toggle of fields that it has.");
}

template <int dim>
std::optional<bool> Condition<dim>::is_on(const dealii::Point<dim> &X, const double t,
                                          const std::vector<double> &values) const
{
  const double value = finite(formula->value(X, t, 0, values), section, "Toggle", X, t);
  if (std::isnan(value))
    return {};
  return value != 0;
}

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

template class Condition<2>;
template class Condition<3>;

} // namespace dovetail
