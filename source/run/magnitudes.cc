// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/magnitudes.h>
#include <dovetail/scene/units.h>

#include <cstdlib>
#include <sstream>

namespace dovetail {

template <int dim>
std::vector<std::string> notes_on_magnitudes(const Model<dim> &model, const Section &scene)
{
  std::vector<std::string> notes;
  const std::string units = scene.peek("Units");
  for (const auto &domain : model.domains) {
    const std::string modulus = scene.peek("Material " + domain->material.name + "/Solid", "Young modulus");
    const double E = std::strtod(modulus.c_str(), nullptr), length = domain->typical_length();
    std::ostringstream text;
    if (units.empty() && E > 1e9 && length > 50)
      text << "the body " << domain->name << " is " << length << " long and has the Young modulus " << E
           << ": with a modulus in pascals these are metres. If the mesh is in millimetres, set Scale = "
              "0.001 in "
              "its subsection Mesh, or give all values in mm, t, s (MPa). To silence this, set Units";
    else if (!units.empty() && E > 2e12 * Units(units).from_si("Pa").value_or(1.))
      text << "the Young modulus " << E << " of the body " << domain->name
           << " is higher than that of any solid in "
           << "the Units " << units << "; in these, steel has "
           << 2.1e11 * Units(units).from_si("Pa").value_or(1.);
    if (!text.str().empty())
      notes.push_back(text.str());
    for (const auto &condition : domain->conditions())
      if (const std::string doubt = condition->doubt(); !doubt.empty())
        notes.push_back(condition->section.path() + ": " + doubt);
  }
  return notes;
}

template std::vector<std::string> notes_on_magnitudes(const Model<2> &, const Section &);
template std::vector<std::string> notes_on_magnitudes(const Model<3> &, const Section &);

} // namespace dovetail
