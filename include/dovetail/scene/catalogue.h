// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Families of plugins: name in the scene -> creator. A law, a condition, a tie or a solver registers itself
// in the last line of its own file; no list, enum or switch knows it.

#pragma once

#include <dovetail/scene/section.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

namespace dovetail {

/// What has been registered under a name that was taken, by a plugin from outside: the first one stays.
std::vector<std::string> &names_registered_twice();

/// The members of the family @p Base, each constructed from its Section and further @p Arguments.
///
///     namespace { const bool registered = Catalogue<SolidLaw>::add<NeoHookean>("neo-Hookean", "one
///     sentence"); }
///
/// Registration only stores names and functions: no MPI and no deal.II call happens before main.
template <class Base, typename... Arguments>
class Catalogue
{
public:
  using Creator = std::function<std::unique_ptr<Base>(const Section &, Arguments...)>;

  struct Member
  {
    std::string help;
    Creator create; ///< empty for "none"
  };

  template <class Derived>
  static bool add(const std::string &name, const std::string &help)
  {
    const Creator create = [](const Section &section, Arguments... arguments) -> std::unique_ptr<Base> {
      return std::make_unique<Derived>(section, arguments...);
    };
    const bool is_new = members().emplace(name, Member{help, create}).second;
    if (!is_new)
      names_registered_twice().push_back(name);
    return is_new;
  }

  /// Read `Type` and create the member of that name from @p section. If @p default_type is empty the entry is
  /// required. "none" is always known to families whose @p default_type is "none", and gives nullptr.
  static std::unique_ptr<Base> create(const Section &section, const std::string &default_type,
                                      const std::string &description, Arguments... arguments)
  {
    return create_by("Type", section, default_type, description, arguments...);
  }

  /// The same where the name stands in another @p entry.
  static std::unique_ptr<Base> create_by(const std::string &entry, const Section &section,
                                         const std::string &default_type, const std::string &description,
                                         Arguments... arguments)
  {
    std::vector<std::string> all = names();
    if (default_type == "none")
      all.insert(all.begin(), "none");
    const std::string type = read_type(entry, section, all, default_type, description);
    if (section.documenting())
      for (const auto &[name, member] : members())
        member.create(section.variant(name, member.help, entry), arguments...);
    return section.documenting() || type == "none" ? nullptr : create_member(type, section, arguments...);
  }

  static std::vector<std::string> names()
  {
    std::vector<std::string> all;
    for (const auto &[name, member] : members())
      all.push_back(name);
    return all;
  }

  /// @pre @p name is one of names()
  static std::unique_ptr<Base> create_member(const std::string &name, const Section &section,
                                             Arguments... arguments)
  {
    return members().at(name).create(section, arguments...);
  }

  /// Let every member read its entries below a heading of its own.
  static void document(const Section &section, Arguments... arguments)
  {
    for (const auto &[name, member] : members())
      member.create(section.variant(name, member.help), arguments...);
  }

private:
  static std::map<std::string, Member> &members()
  {
    static std::map<std::string, Member> all;
    return all;
  }

  static std::string read_type(const std::string &entry, const Section &section,
                               const std::vector<std::string> &names, const std::string &default_type,
                               const std::string &description)
  {
    std::string alternatives;
    for (const std::string &name : names)
      alternatives += (alternatives.empty() ? "" : "|") + name;
    const Patterns::Selection pattern(alternatives);
    return default_type.empty() ? section.require<std::string>(entry, description, pattern)
                                : section.read<std::string>(entry, default_type, description, pattern);
  }
};

} // namespace dovetail
