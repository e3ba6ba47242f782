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
#include <dovetail/material/transient.h>
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
    return {{"displacement", dim, 0, "solid", "", "velocity"}};
  }

  void add_terms(const std::vector<Field> &all, typename MaterialPart<dim>::Terms &terms) const override
  {
    auto law = Catalogue<SolidLaw>::create(
        section, "none", "The law of the stress; none: the material has no displacement [-]");
    if (!law && !section.documenting())
      return;
    section.choose("Formulation", {"displacement"}, 0, "Unknowns of the solid [-]");
    const double density = section.read<double>(
        "Density", 0,
        "Mass per undeformed volume, for body forces by acceleration and rotation, and for inertia [kg/m^3]");
    section.check(density >= 0, "Density", "must be positive (or 0: not given).");
    const double alpha =
        section.read<double>("Expansion coefficient", 0,
                             "alpha in the free thermal strain alpha (T - Reference temperature) [1/K]");
    const double reference = section.read<double>(
        "Reference temperature", 0, "Temperature at which the undeformed solid is free of stress [K]");
    const auto temperature =
        std::find_if(all.begin(), all.end(), [](const Field &field) { return field.name == "temperature"; });
    section.check(
        temperature != all.end() || alpha == 0, "Expansion coefficient",
        "needs a Heat law whose temperature expands the solid: add subsection Heat to the material, "
        "or remove the entry.");
    if (section.documenting())
      return;
    std::optional<typename SolidTerm<dim>::Expansion> expansion;
    if (alpha != 0)
      expansion = {temperature->first_component, alpha, reference};
    const std::string name = this->material.path();
    std::string type = section.peek("Type");
    const std::string geometry = dim == 2 ? section.top().peek("Geometry") : "";
    if (geometry == "plane stress") {
      law = std::make_unique<PlaneStress>(std::move(law));
      type += ", plane stress";
    }
    terms.push_back(std::make_unique<SolidTerm<dim>>(all.front(), std::move(law), expansion,
                                                     geometry == "axisymmetric",
                                                     name.substr(name.find(' ') + 1), type, density));
    if (!has_inertia(section))
      return;
    section.check(density > 0, section.is_set("Density") ? "Density" : "",
                  std::string(section.is_set("Density") ? "is zero" : "has no Density") +
                      ", but inertia needs it. Give it, or remove Inertia from the subsection Steps.");
    terms.push_back(std::make_unique<InertiaTerm<dim>>(all.front(), density));
  }

private:
  const Section section;
};

[[maybe_unused]] const bool registered = add_material_part<Solid>(10);

} // namespace

} // namespace dovetail
