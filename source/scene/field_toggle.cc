// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/scene/field_toggle.h>

#include <algorithm>

namespace dovetail {

namespace {

using Names = std::function<std::vector<std::string>(const Section &scene)>;

std::vector<Names> &all_names()
{
  static std::vector<Names> all;
  return all;
}

} // namespace

bool add_names_in_toggles(const Names &names)
{
  all_names().push_back(names);
  return true;
}

std::vector<std::string> names_in_toggles(const Section &scene)
{
  std::vector<std::string> result;
  for (const Names &names : all_names())
    for (const std::string &name : names(scene))
      if (std::find(result.begin(), result.end(), name) == result.end())
        result.push_back(name);
  return result;
}

Expression formula_of_toggle(const Section &section, const std::string &toggle)
{
  const Section scene = section.top();
  return scene.subsection("Toggle " + toggle)
      .require_expression("Active while", {1},
                          "The toggle is on while this formula is not zero, for instance t >= 0.5 && t < 2, "
                          "or, for what acts at points, of x, y, z, t and the names of scalar fields at "
                          "the last good step: temperature > 1700 [-]",
                          names_in_toggles(scene));
}

std::vector<std::string> names_in_toggle(const Section &section)
{
  const std::string toggle = section.peek("Toggle");
  if (section.documenting() || toggle.empty() || !section.top().has_subsection("Toggle " + toggle))
    return {};
  const Expression formula = formula_of_toggle(section, toggle);
  const std::vector<std::string> names = names_in_toggles(section.top());
  std::vector<std::string> result;
  for (unsigned int s = 0; s < names.size(); ++s)
    if (formula.depends_on_scalar(s))
      result.push_back(names[s]);
  return result;
}

bool has_field_toggle(const Section &section)
{
  return !names_in_toggle(section).empty();
}

std::string name_in_toggles(std::string field)
{
  std::replace(field.begin(), field.end(), ' ', '_');
  return field;
}

} // namespace dovetail
