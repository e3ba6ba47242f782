// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The solid of a material: the displacement and its stress.
//
//     subsection Solid
//       set Type                  = linear elastic
//       set Expansion coefficient = 1.2e-5           # 1/K
//     end

#include <dovetail/material/inertia_term.h>
#include <dovetail/material/material_part.h>
#include <dovetail/material/plane_stress.h>
#include <dovetail/material/solid_term.h>
#include <dovetail/material/thermal_law.h>
#include <dovetail/material/transient.h>
#include <dovetail/material/volume_term.h>
#include <dovetail/scene/catalogue.h>

#include <algorithm>

namespace dovetail {

namespace {

template <int dim>
class Solid : public MaterialPart<dim>
{
public:
  explicit Solid(const Section &material) : MaterialPart<dim>(material), section(material.subsection("Solid"))
  {
  }

  std::vector<Field> fields() const override
  {
    const std::string type = section.peek("Type");
    if (!section.documenting() && (type.empty() || type == "none"))
      return {};
    const Field displacement = {"displacement", dim, 0, "solid", "", "velocity"};
    if (section.documenting() || !is_mixed(section))
      return {displacement};
    return {displacement, {"pressure", 1, 0, "volume", "pressure", "", -1, false, true}};
  }

  std::vector<std::pair<std::string, std::string>> entries_of_storage() const override
  {
    return {{"Solid", "Density"}};
  }

  void add_terms(const std::vector<Field> &all, typename MaterialPart<dim>::Terms &terms) const override
  {
    auto law = Catalogue<SolidLaw>::create(
        section, "none", "The law of the stress; none: the material has no displacement [-]");
    if (!law && !section.documenting())
      return;
    const bool mixed = section.choose("Formulation", {"displacement", "mixed"}, 0,
                                      "Unknowns of the solid; mixed: displacement and pressure, for bodies "
                                      "whose volume hardly changes; needs Degree = 2 or higher [-]") == 1;
    const double density = section.read<double>(
        "Density", 0,
        "Mass per undeformed volume, for body forces by acceleration and rotation, and for inertia [kg/m^3]");
    section.check(density >= 0, "Density", "must be positive (or 0: not given).");
    const ThermalStrain strain(section);
    const auto temperature =
        std::find_if(all.begin(), all.end(), [](const Field &field) { return field.name == "temperature"; });
    section.check(temperature != all.end() || strain.is_zero(), "Expansion coefficient",
                  "needs a Heat law whose temperature expands the solid: give its subsection Heat a Type, "
                  "or remove the entry.");
    if (section.documenting())
      return;
    const Volumetric *volume = law->volume();
    std::optional<unsigned int> T;
    if (temperature != all.end() && (!strain.is_zero() || depends_on_temperature(*law)))
      T = temperature->first_component;
    std::optional<typename SolidTerm<dim>::Expansion> expansion;
    if (ThermalLaw::is_needed(*law, strain)) {
      check_temperature(*law, temperature != all.end());
      law = std::make_unique<ThermalLaw>(std::move(law), strain);
      if (T)
        expansion = {*T, 1, 0};
    } else if (T)
      expansion = {*T, *strain.constant_coefficient(), strain.reference_temperature()};
    const std::string name = this->material.path();
    std::string type = section.peek("Type");
    const std::string geometry = dim == 2 ? section.top().peek("Geometry") : "";
    if (geometry == "plane stress") {
      law = std::make_unique<PlaneStress>(std::move(law));
      type += ", plane stress";
    }
    if (mixed)
      check_mixed(all, volume, geometry);
    const bool is_axisymmetric = geometry == "axisymmetric", is_large = law->has_large_strain();
    const std::string name_of_material = name.substr(name.find(' ') + 1);
    auto solid = std::make_unique<SolidTerm<dim>>(all.front(), std::move(law), expansion, is_axisymmetric,
                                                  name_of_material, type, density);
    const SolidTerm<dim> &stress = *solid;
    terms.push_back(std::move(solid));
    if (mixed) {
      terms.push_back(
          std::make_unique<SolidTerm<dim>>(all.front(), std::make_unique<PressureStress>(is_large),
                                           typename SolidTerm<dim>::Expansion{all[1].first_component, 1, 0},
                                           is_axisymmetric, name_of_material, "pressure", density));
      terms.push_back(std::make_unique<VolumeTerm<dim>>(all[1], stress, *volume, T, strain, is_axisymmetric));
    }
    if (!has_inertia(section))
      return;
    check_density(density);
    terms.push_back(std::make_unique<InertiaTerm<dim>>(all.front(), density));
  }

private:
  void check_density(const double density) const
  {
    section.check(
        density > 0, section.is_set("Density") ? "Density" : "",
        std::string(section.is_set("Density") ? "is zero" : "has no Density") +
            (finds_eigenmodes(section)
                 ? ", but eigenmodes need it: Kind = eigenmodes in the subsection Steps. Give it."
                 : ", but inertia needs it. Give it, or remove Inertia from the subsection Steps."));
  }

  static bool depends_on_temperature(const SolidLaw &law)
  {
    return std::any_of(law.formulas().begin(), law.formulas().end(),
                       [](const SolidLaw::Formula &formula) { return formula.depends_on_temperature; });
  }

  void check_temperature(const SolidLaw &law, const bool has_temperature) const
  {
    for (const SolidLaw::Formula &formula : law.formulas())
      section.check(has_temperature || !formula.depends_on_temperature, formula.entry,
                    "depends on the temperature T, but the material has none: add subsection Heat to it, or "
                    "give the entry in x, y, z and t.");
  }

  void check_mixed(const std::vector<Field> &all, const Volumetric *volume, const std::string &geometry) const
  {
    section.check(geometry != "plane stress", "Formulation",
                  "is mixed, but in plane stress the thickness follows the volume, so that nothing locks. "
                  "Remove the entry.");
    section.check(
        volume != nullptr, "Formulation",
        "is mixed, but the energy of this Type has no part of its own for the change of volume. Set "
        "Formulation = displacement, or take linear elastic, a law of plasticity or creep, or a hyperelastic "
        "law with Volumetric.");
    section.check(std::count_if(all.begin(), all.end(),
                                [](const Field &field) { return field.name == "pressure"; }) == 1,
                  "Formulation", "is mixed, which has a field pressure: give the species another name.");
  }

  const Section section;
};

[[maybe_unused]] const bool registered = add_material_part<Solid>(10);

} // namespace

} // namespace dovetail
