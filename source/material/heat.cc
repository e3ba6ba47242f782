// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The heat of a material: the temperature and its conduction.
//
//     subsection Heat
//       set Type         = Fourier
//       set Conductivity = 15        # W/(m K)
//     end

#include <dovetail/material/diffusion_term.h>
#include <dovetail/material/material_part.h>
#include <dovetail/scene/catalogue.h>

#include <algorithm>

namespace dovetail {

namespace {

template <int dim>
class Heat : public MaterialPart<dim>
{
public:
  explicit Heat(const Section &material) : MaterialPart<dim>(material), section(material.subsection("Heat"))
  {
  }

  std::vector<Field> fields() const override
  {
    const std::string type = section.peek("Type");
    if (!section.documenting() && (type.empty() || type == "none"))
      return {};
    return {{"temperature", 1, 0, "heat", "T"}};
  }

  void add_terms(const std::vector<Field> &all, typename MaterialPart<dim>::Terms &terms) const override
  {
    auto law = Catalogue<HeatLaw, const ScalarNames &>::create(
        section, "none", "The law of the heat flux; none: the material has no temperature [-]",
        symbols_of(all));
    if (!law && !section.documenting())
      return;
    for (const auto &[entry, description] :
         {std::pair("Density", "Mass per volume, for the heat stored in transient scenes [kg/m^3]"),
          std::pair("Heat capacity", "Heat capacity per mass [J/(kg K)]")})
      section.check(section.read<double>(entry, 0, description) >= 0, entry,
                    "must be positive (or 0: not given).");
    const auto own =
        std::find_if(all.begin(), all.end(), [](const Field &field) { return field.law == "heat"; });
    if (law)
      terms.push_back(std::make_unique<DiffusionTerm<dim>>(*own, all, std::move(law), section.peek("Type")));
  }

private:
  const Section section;
};

[[maybe_unused]] const bool registered = add_material_part<Heat>(20);

} // namespace

} // namespace dovetail
