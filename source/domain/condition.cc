// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/condition.h>

namespace dovetail {

namespace {

Field read_field(const Section &section, const std::vector<Field> &fields)
{
  const auto name = section.require<std::string>(
      "Field", "The field it acts on, for instance temperature or displacement [-]");
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

std::set<dealii::types::boundary_id> read_boundary_ids(const Section &section)
{
  const auto ids = section.require<std::vector<unsigned int>>(
      "Boundary ids", "The boundary ids of the mesh on which the condition acts [-]",
      Patterns::List(Patterns::Integer(0), 1));
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
Condition<dim>::Condition(const Section &section, const std::vector<Field> &fields, const Toggles &toggles)
    : section(section), name(last_part(section.path())), field(read_field(section, fields)),
      boundary_ids(read_boundary_ids(section)), toggles(&toggles), toggle(toggles.read_reference(section))
{
}

template class Condition<2>;
template class Condition<3>;

} // namespace dovetail
