// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/scene/field_toggle.h>
#include <dovetail/scene/toggle.h>
#include <dovetail/scene/undefined.h>

#include <cmath>

namespace dovetail {

Toggles::Toggles(const Section &scene)
{
  for (const std::string &name :
       scene.announce("Toggles", "Toggle",
                      "Names of conditions, in time or by fields, that switch interfaces, boundary "
                      "conditions and materials [-]")) {
    const Section section = scene.subsection("Toggle " + name);
    const Expression condition = formula_of_toggle(section, name);
    section.check(condition.depends_on_scalars() || !condition.depends_on_position(), "Active while",
                  "may only depend on the time t, unless it looks at a field.");
    active_while.emplace(name, condition);
  }
}

std::string Toggles::read_reference(const Section &section) const
{
  const auto name = section.read<std::string>(
      "Toggle", "",
      "The toggle that switches this subsection on and off; if empty, the subsection is always on [-]");
  std::vector<std::string> known;
  for (const auto &toggle : active_while)
    known.push_back(toggle.first);
  if (!name.empty() && active_while.count(name) == 0)
    section.fail("Toggle", "names '" + name + "', which is not among Toggles (" + comma_separated(known) +
                               "). " + did_you_mean(name, known));
  return name;
}

bool Toggles::is_active(const std::string &name, const double t) const
{
  if (name.empty())
    return true;
  if (active_while.at(name).depends_on_scalars()) // somewhere; who refers to it asks at points
    return true;
  const double condition = active_while.at(name).value(dealii::Point<3>(), t);
  if (std::isnan(condition)) // the same on all ranks
    throw UserError("Toggle " + name + ": Active while is not a number at t = " + in_words(t) +
                    ", but must be one.");
  return condition != 0.;
}

} // namespace dovetail
