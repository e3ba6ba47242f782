// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/material/transient.h>
#include <dovetail/run/magnitudes.h>
#include <dovetail/scene/units.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_units("units",
                        "lengths, moduli or densities look as if they were given in different units");
const NoteName of_unused_density("unused density", "a Density of the scene takes part in nothing");

double number_in(const Section &scene, const std::string &material, const std::string &part,
                 const std::string &entry)
{
  return std::strtod(scene.peek("Material " + material + "/" + part, entry).c_str(), nullptr);
}

/// Whether the scene itself gives a part of a material a Density; files of materials are for all purposes.
bool has_density(const Section &scene, const std::string &material, const std::string &part)
{
  return scene.peek("Materials file").empty() && number_in(scene, material, part, "Density") > 0;
}

double largest_density_of(const std::string &material, const Section &scene)
{
  return std::max(number_in(scene, material, "Solid", "Density"),
                  number_in(scene, material, "Heat", "Density"));
}

/// Osmium has 22600 kg/m^3.
const double largest_density = 3e4;

/// No matter has so many g/cm^3 or t/mm^3; foams, insulation and all that is denser have it in kg/m^3.
const double least_density_in_si = 30;

void add_notes_on_magnitude_of_density(const std::string &material, const Section &scene,
                                       const std::string &units, NoteList &notes)
{
  const double in_units = Units(units).from_si("kg/m^3").value_or(1.);
  for (const char *part : {"Solid", "Heat"}) {
    const double density = number_in(scene, material, part, "Density");
    if (density <= largest_density * in_units)
      continue;
    std::ostringstream text;
    text << "Material " << material << "/" << part << ": the Density " << density
         << " is higher than that of any matter in the Units " << units << "; in these, steel has "
         << 7850 * in_units;
    notes.push_back(of_units(text.str()));
  }
}

template <int dim>
void add_notes_on_density(const Model<dim> &model, const Section &scene, NoteList &notes)
{
  const bool stores_heat = is_transient(scene), moves_masses = has_inertia(scene);
  for (const auto &material : model.materials) {
    const bool has_force = std::any_of(model.domains.begin(), model.domains.end(), [&](const auto &domain) {
      return &domain->material == material.get() && domain->body_force().is_given();
    });
    if (!has_force && !moves_masses && has_density(scene, material->name, "Solid"))
      notes.push_back(of_unused_density(
          "Material " + material->name +
          "/Solid: nothing uses its Density. Weight needs Acceleration in the subsection of the Domain, "
          "rotation an Angular velocity, and inertia the entry Inertia in the subsection Steps"));
    const bool is_complete = !scene.peek("Material " + material->name + "/Heat", "Heat capacity").empty();
    if (!stores_heat && !is_complete && has_density(scene, material->name, "Heat"))
      notes.push_back(of_unused_density("Material " + material->name +
                                        "/Heat: nothing uses its Density, because a static scene stores no "
                                        "heat. Set Kind = transient in the subsection Steps if it should"));
  }
}

} // namespace

template <int dim>
NoteList notes_on_magnitudes(const Model<dim> &model, const Section &scene)
{
  NoteList notes;
  const std::string units = scene.peek("Units");
  for (const auto &domain : model.domains) {
    const double E = number_in(scene, domain->material.name, "Solid", "Young modulus"),
                 density = largest_density_of(domain->material.name, scene),
                 length = domain->typical_length();
    std::ostringstream text;
    if (units.empty() && length > 50 && (E > 1e9 || density > least_density_in_si)) {
      text << "the body " << domain->name << " is " << length << " long and has the ";
      if (E > 1e9)
        text << "Young modulus " << E << ": with a modulus in pascals";
      else
        text << "Density " << density << ": with a density in kg/m^3";
      text
          << " these are metres. If the mesh is in millimetres, set Scale = 0.001 in its subsection Mesh, or "
             "give all values in mm, t, s (MPa). To silence this, set Units";
    }
    if (!units.empty() && E > 2e12 * Units(units).from_si("Pa").value_or(1.))
      text << "the Young modulus " << E << " of the body " << domain->name
           << " is higher than that of any solid in "
           << "the Units " << units << "; in these, steel has "
           << 2.1e11 * Units(units).from_si("Pa").value_or(1.);
    if (!text.str().empty())
      notes.push_back(of_units(text.str()));
    for (const auto &condition : domain->conditions())
      for (const Note &note : condition->notes())
        notes.push_back(note.of(condition->section.path()));
  }
  for (const auto &material : model.materials)
    if (!units.empty())
      add_notes_on_magnitude_of_density(material->name, scene, units, notes);
  add_notes_on_density(model, scene, notes);
  return notes;
}

template NoteList notes_on_magnitudes(const Model<2> &, const Section &);
template NoteList notes_on_magnitudes(const Model<3> &, const Section &);

} // namespace dovetail
