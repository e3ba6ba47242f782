// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What brings fields and terms to a material: its subsections Solid, Heat, Species.

#pragma once

#include <dovetail/material/term.h>
#include <dovetail/scene/section.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace dovetail {

/// Part of a material: reads its subsections and brings fields and the terms of their balances. A plugin, one
/// file: its last line registers it, no list knows it.
template <int dim>
class MaterialPart
{
public:
  explicit MaterialPart(const Section &material) : material(material) {}
  virtual ~MaterialPart() = default;

  /// Its fields, without numbers of components, from the names in the scene. While documenting one of each
  /// kind.
  virtual std::vector<Field> fields() const = 0;

  /// Subsection and name of the entries that say what is stored, which no change of phase may change.
  virtual std::vector<std::pair<std::string, std::string>> entries_of_storage() const { return {}; }

  using Terms = std::vector<std::unique_ptr<Term<dim>>>;
  /// Reads the rest, where @p all are the fields of all parts; formulas may use the symbols of scalars.
  virtual void add_terms(const std::vector<Field> &all, Terms &terms) const = 0;

protected:
  const Section material;
};

/// The parts that a material may have, in the order of their fields.
template <int dim>
class MaterialParts
{
public:
  /// @param position in that order; a field depends as a rule on those after it
  template <template <int> class Part>
  static bool add(const unsigned int position)
  {
    creators().emplace(position, [](const Section &material) -> std::unique_ptr<MaterialPart<dim>> {
      return std::make_unique<Part<dim>>(material);
    });
    return true;
  }

  static std::vector<std::unique_ptr<MaterialPart<dim>>> create(const Section &material)
  {
    std::vector<std::unique_ptr<MaterialPart<dim>>> parts;
    for (const auto &[position, create] : creators())
      parts.push_back(create(material));
    return parts;
  }

private:
  using Creator = std::function<std::unique_ptr<MaterialPart<dim>>(const Section &)>;
  static std::multimap<unsigned int, Creator> &creators()
  {
    static std::multimap<unsigned int, Creator> all;
    return all;
  }
};

/// Registers a part for both dimensions.
template <template <int> class Part>
bool add_material_part(const unsigned int position)
{
  return MaterialParts<2>::add<Part>(position) && MaterialParts<3>::add<Part>(position);
}

/// The symbols of the scalars among @p fields, in their order: the variables of a law's formulas.
inline std::vector<std::string> symbols_of(const std::vector<Field> &fields)
{
  std::vector<std::string> symbols;
  for (const Field &field : fields)
    if (field.n_components == 1)
      symbols.push_back(field.symbol);
  return symbols;
}

} // namespace dovetail
