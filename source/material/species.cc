// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The species of a material: a scalar field each, the concentration c, with diffusion and reaction,
//
//     R(delta) = int A.grad delta c + S delta c,   S = -r(scalars, X, t) + C(scalars, X, t) dc/dt
//
// where the reaction r is what is produced, and C, in transient scenes only, the capacity.
//
//     set Species = carbon
//     subsection Species carbon
//       set Type        = Fick
//       set Diffusivity = 2e-11              # m^2/s
//       set Reaction    = -1e-4 * carbon     # amount/(m^3 s)
//     end

#include <dovetail/material/capacity_term.h>
#include <dovetail/material/diffusion_term.h>
#include <dovetail/material/material_part.h>
#include <dovetail/material/reaction_term.h>
#include <dovetail/material/transient.h>
#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/field_toggle.h>

#include <deal.II/base/utilities.h>

#include <algorithm>
#include <cctype>
#include <set>

namespace dovetail {

namespace {

/// As formulas call it: they know no spaces.
std::string symbol_of(std::string name)
{
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

bool is_good_name(const std::string &name)
{
  for (const std::string reserved :
       {"x", "y", "z", "t", "T", "pi", "inf", "displacement", "velocity", "temperature"})
    if (name == reserved)
      return false;
  return std::isalpha(static_cast<unsigned char>(name[0])) &&
         std::all_of(name.begin(), name.end(), [](const char letter) {
           return std::isalnum(static_cast<unsigned char>(letter)) || letter == '_' || letter == ' ';
         });
}

template <int dim>
class Species : public MaterialPart<dim>
{
public:
  explicit Species(const Section &material)
      : MaterialPart<dim>(material),
        names(material.announce("Species", "Species",
                                "Names of scalars besides the temperature, each with a law of its "
                                "own [-]"))
  {
    for (const std::string &name : names)
      material.check(
          is_good_name(name), "Species",
          "names '" + name +
              "', but a species is a field and a variable of formulas: its name begins with a letter, holds "
              "letters, digits and underscores only (spaces become underscores in formulas), and is none of "
              "x, y, z, t, T, pi, inf, displacement, velocity, temperature.");
    std::set<std::string> symbols;
    for (const std::string &name : names)
      material.check(symbols.insert(symbol_of(name)).second, "Species",
                     "has two names that formulas write as " + symbol_of(name) + ". Change one of them.");
  }

  std::vector<Field> fields() const override
  {
    std::vector<Field> all;
    for (const std::string &name : names)
      all.push_back({name, 1, 0, "species", symbol_of(name)});
    return all;
  }

  std::vector<std::pair<std::string, std::string>> entries_of_storage() const override
  {
    std::vector<std::pair<std::string, std::string>> entries;
    for (const std::string &name : names)
      entries.push_back({"Species " + name, "Capacity"});
    return entries;
  }

  void add_terms(const std::vector<Field> &all, typename MaterialPart<dim>::Terms &terms) const override
  {
    for (const std::string &name : names) {
      const Section section = this->material.subsection("Species " + name);
      auto law = Catalogue<SpeciesLaw, const ScalarNames &>::create(section, "", "The law of the flux [-]",
                                                                    symbols_of(all));
      const Expression reaction = section.read_expression(
          "Reaction", "0", {1},
          "Production of the species by reactions, negative where it is consumed [1/(m^3 s)]",
          symbols_of(all));
      const Expression capacity = read_capacity(
          section, "Capacity", "1",
          "What is stored per volume and concentration in transient scenes, for instance a porosity; it may "
          "depend on x, y, z, t and every scalar of the material [-]",
          symbols_of(all));
      if (section.documenting())
        continue;
      const Field &own =
          *std::find_if(all.begin(), all.end(), [&](const Field &field) { return field.name == name; });
      terms.push_back(std::make_unique<DiffusionTerm<dim>>(own, all, std::move(law), section.peek("Type")));
      if (!reaction.is_zero())
        terms.push_back(std::make_unique<ReactionTerm<dim>>(own, all, section, "Reaction", reaction));
      if (!is_transient(section) || capacity.is_zero())
        continue;
      Contents contents;
      contents.push_back(content_of_capacity("Capacity", capacity, depends_on_others(capacity, own, all)));
      terms.push_back(std::make_unique<CapacityTerm<dim>>(own, all, section, std::move(contents)));
    }
  }

private:
  const std::vector<std::string> names;
};

/// Those of all materials of a scene; bad ones are refused where they are read.
std::vector<std::string> names_of_species(const Section &scene)
{
  std::vector<std::string> result;
  for (const std::string &material : dealii::Utilities::split_string_list(scene.peek("Materials")))
    for (const std::string &name :
         dealii::Utilities::split_string_list(scene.peek("Material " + material, "Species")))
      if (is_good_name(name))
        result.push_back(symbol_of(name));
  return result;
}

[[maybe_unused]] const bool registered =
    add_material_part<Species>(30) && add_names_in_toggles(names_of_species);

} // namespace

} // namespace dovetail
