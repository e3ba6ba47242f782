// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The heat of a material: the temperature, its conduction, the heat produced and, in transient scenes, the
// heat stored,
//
//     S = -q(T, X, t) + rho dH/dt,   dH/dT = c(T, X, t) + L df/dT
//
// with the latent heat L and the liquid fraction f.
//
//     subsection Heat
//       set Type          = Fourier
//       set Conductivity  = 15              # W/(m K)
//       set Density       = 7800            # kg/m^3
//       set Heat capacity = 420 + 0.2*T     # J/(kg K)
//       set Heat source   = 1e5*exp(-T/500) # W/m^3
//     end

#include <dovetail/material/capacity_term.h>
#include <dovetail/material/deformation_heat.h>
#include <dovetail/material/deformed_diffusion_term.h>
#include <dovetail/material/diffusion_term.h>
#include <dovetail/material/material_part.h>
#include <dovetail/material/reaction_term.h>
#include <dovetail/material/transient.h>
#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/field_toggle.h>

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

  std::vector<std::pair<std::string, std::string>> entries_of_storage() const override
  {
    return {{"Heat", "Density"},  {"Heat", "Heat capacity"}, {"Heat", "Latent heat"}, {"Heat", "Solidus"},
            {"Heat", "Liquidus"}, {"Heat", "Melting"},       {"Heat", "Enthalpy"}};
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
    const bool is_in_deformed_body =
        section.choose("Configuration", {"material", "deformed"}, 0,
                       "The body in which Conductivity holds: the undeformed one, or the deformed one, where "
                       "a stretched body conducts less along it and more across it [-]") == 1;
    auto latent_heat = read_latent_heat(section);
    const Expression enthalpy = section.read_expression(
        "Enthalpy", "0", {1},
        "Heat content per mass, of x, y, z and T only, in place of Heat capacity and Latent heat, for "
        "transient scenes [J/kg]",
        symbols_of(all));
    const double reference = section.read<double>(
        "Reference temperature of enthalpy", 0,
        "Temperature at which the quantity enthalpy is zero; the solution does not depend on it [K]");
    const Expression source = section.read_expression("Heat source", "0", {1},
                                                      "Heat produced in the material, which may depend on x, "
                                                      "y, z, t and every scalar of the material [W/m^3]",
                                                      symbols_of(all));
    const DeformationEntries deformation = read_deformation();
    const auto own =
        std::find_if(all.begin(), all.end(), [](const Field &field) { return field.law == "heat"; });
    if (!law)
      return;
    if (is_in_deformed_body) {
      check_deforms(all);
      terms.push_back(std::make_unique<DeformedDiffusionTerm<dim>>(*own, all, section, std::move(law),
                                                                   section.peek("Type")));
    } else
      terms.push_back(std::make_unique<DiffusionTerm<dim>>(*own, all, std::move(law), section.peek("Type")));
    if (!source.is_zero())
      terms.push_back(std::make_unique<ReactionTerm<dim>>(*own, all, section, "Heat source", source));
    section.check(
        !enthalpy.depends_on_time() && !depends_on_others(enthalpy, *own, all), "Enthalpy",
        "depends on t or on another scalar than T. The heat content of a material is a formula of T "
        "and of the position; heat that appears in other ways is a Heat source.");
    if (!is_transient(section))
      return;
    add_deformation_heat(deformation, *own, terms);
    terms.push_back(std::make_unique<CapacityTerm<dim>>(
        *own, all, section,
        contents(density, capacity, std::move(latent_heat), enthalpy, depends_on_others(capacity, *own, all)),
        density, reference));
  }

private:
  /// Heat that the solid of the material produces.
  struct DeformationEntries
  {
    bool with_compression = false;
    double share_of_flow = 0, offset = 0;
  };

  DeformationEntries read_deformation() const
  {
    DeformationEntries result;
    result.with_compression = section.read<bool>(
        "Heat of compression", false,
        "A solid that expands with the temperature heats up when it is compressed and cools when it is "
        "pulled, in transient scenes [-]");
    result.share_of_flow = section.read<double>(
        "Share of plastic work", 0,
        "Of the work of plastic flow or creep, which turns to heat in transient scenes; about 0.9 in metals "
        "[-]",
        Patterns::Double(0, 1));
    result.offset = section.read<double>(
        "Offset", 0,
        "Added to T for the absolute temperature of the Heat of compression: 273.15 if T is in degrees "
        "Celsius [K]");
    section.check(result.offset == 0 || result.with_compression, "Offset",
                  "belongs to the Heat of compression.");
    return result;
  }

  void add_deformation_heat(const DeformationEntries &entries, const Field &own,
                            typename MaterialPart<dim>::Terms &terms) const
  {
    const auto &[with_compression, share, offset] = entries;
    if (!with_compression && share == 0)
      return;
    const SolidTerm<dim> &solid = find_solid(
        terms, with_compression ? "Heat of compression" : "Share of plastic work", with_compression, share);
    const VolumeTerm<dim> *volume = nullptr;
    for (const auto &term : terms)
      if (const auto *candidate = dynamic_cast<const VolumeTerm<dim> *>(term.get()))
        volume = candidate;
    section.check(
        !with_compression || volume == nullptr || volume->is_compressible() || !volume->expands(),
        "Heat of compression",
        "needs a volume that can be kept while the temperature changes, since Heat capacity is that "
        "at a constant strain. Give the solid a finite Bulk modulus, or a Poisson ratio below 0.5.");
    terms.push_back(
        std::make_unique<DeformationHeat<dim>>(own, solid, volume, with_compression, share, offset));
  }

  /// The stress of the law, the first one of the material; it comes before the heat (solid.cc).
  const SolidTerm<dim> &find_solid(const typename MaterialPart<dim>::Terms &terms, const std::string &entry,
                                   const bool with_compression, const double share) const
  {
    const SolidTerm<dim> *solid = nullptr;
    for (const auto &term : terms)
      if (const auto *candidate = dynamic_cast<const SolidTerm<dim> *>(term.get());
          candidate != nullptr && solid == nullptr)
        solid = candidate;
    section.check(solid != nullptr, entry,
                  "needs a solid, but the material has no law in its subsection Solid.");
    section.check(!with_compression || solid->has_expansion_work(), "Heat of compression",
                  "needs the second derivatives of the stress, which this solid law does not have.");
    section.check(share == 0 || solid->can_flow(), "Share of plastic work",
                  "needs a law that flows (J2 plasticity, finite J2 plasticity, Norton creep), not in plane "
                  "stress; with finite J2 plasticity the Expansion coefficient is a number.");
    return *solid;
  }

  void check_deforms(const std::vector<Field> &all) const
  {
    section.check(
        std::any_of(all.begin(), all.end(), [](const Field &field) { return field.law == "solid"; }),
        "Configuration", "is deformed, but the material has no solid law, by which it deforms.");
    section.check(
        section.top().peek("Geometry") != "plane stress", "Configuration",
        "is deformed, which does not go with Geometry = plane stress. Use plane strain, or compute in "
        "3D.");
  }

  Contents contents(const double density, const Expression &capacity,
                    std::unique_ptr<const Content> latent_heat, const Expression &enthalpy,
                    const bool capacity_depends_on_others) const
  {
    const auto check_given = [this](const bool is_given, const std::string &entry) {
      const bool is_set = section.is_set(entry);
      section.check(is_given, is_set ? entry : "",
                    (is_set ? "is zero" : "has no " + entry) +
                        ", but a transient scene needs it: the heat stored is Density times the rate of the "
                        "enthalpy, which follows from Heat capacity, or is given as Enthalpy.");
    };
    check_given(density > 0, "Density");
    Contents result;
    if (!enthalpy.is_zero()) {
      section.check(capacity.is_zero() && !latent_heat, "Enthalpy",
                    "is the whole heat content: remove Heat capacity and Latent heat.");
      result.push_back(content_of_formula("Enthalpy", enthalpy));
      return result;
    }
    check_given(!capacity.is_zero(), "Heat capacity");
    result.push_back(content_of_capacity("Heat capacity", capacity, capacity_depends_on_others));
    if (latent_heat)
      result.push_back(std::move(latent_heat));
    return result;
  }

  const Section section;
};

[[maybe_unused]] const bool registered =
    add_material_part<Heat>(20) &&
    add_names_in_toggles([](const Section & /*scene*/) { return std::vector<std::string>{"temperature"}; });

} // namespace

} // namespace dovetail
