// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The heat of a material: the temperature, its conduction, the heat produced and, in transient scenes, the
// heat stored,
//
//     S = -q(T, X, t) + rho c(T, X, t) dT/dt
//
//     subsection Heat
//       set Type          = Fourier
//       set Conductivity  = 15              # W/(m K)
//       set Density       = 7800            # kg/m^3
//       set Heat capacity = 420 + 0.2*T     # J/(kg K)
//       set Heat source   = 1e5*exp(-T/500) # W/m^3
//     end

#include <dovetail/material/capacity_term.h>
#include <dovetail/material/diffusion_term.h>
#include <dovetail/material/material_part.h>
#include <dovetail/material/reaction_term.h>
#include <dovetail/material/transient.h>
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
    const double density = section.read<double>(
        "Density", 0, "Mass per volume, for the heat stored in transient scenes [kg/m^3]");
    section.check(density >= 0, "Density", "must be positive (or 0: not given).");
    const Expression capacity = read_capacity(
        section, "Heat capacity", "0",
        "Heat capacity per mass, which may depend on x, y, z, t and every scalar of the material, for "
        "transient scenes [J/(kg K)]",
        symbols_of(all));
    const Expression source = section.read_expression("Heat source", "0", {1},
                                                      "Heat produced in the material, which may depend on x, "
                                                      "y, z, t and every scalar of the material [W/m^3]",
                                                      symbols_of(all));
    const auto own =
        std::find_if(all.begin(), all.end(), [](const Field &field) { return field.law == "heat"; });
    if (!law)
      return;
    terms.push_back(std::make_unique<DiffusionTerm<dim>>(*own, all, std::move(law), section.peek("Type")));
    if (!source.is_zero())
      terms.push_back(std::make_unique<ReactionTerm<dim>>(*own, all, section, "Heat source", source));
    if (!is_transient(section))
      return;
    const auto check_given = [&](const bool is_given, const std::string &entry) {
      const bool is_set = section.is_set(entry);
      section.check(is_given, is_set ? entry : "",
                    (is_set ? "is zero" : "has no " + entry) +
                        ", but a transient scene needs it: the heat stored is Density times Heat capacity "
                        "times the rate of the temperature.");
    };
    check_given(density > 0, "Density");
    check_given(!capacity.is_zero(), "Heat capacity");
    terms.push_back(
        std::make_unique<CapacityTerm<dim>>(*own, all, section, "Heat capacity", capacity, density));
  }

private:
  const Section section;
};

[[maybe_unused]] const bool registered = add_material_part<Heat>(20);

} // namespace

} // namespace dovetail
