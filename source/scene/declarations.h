// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// What the program has asked of a scene: every entry that was read, for used.prm and for the reference.

#pragma once

#include <iosfwd>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace dovetail {

struct Declaration
{
  std::string path, variant, name;
  std::optional<std::string> default_text; ///< none: the entry is required
  std::string range, description, value;
};

/// All sections and entries that were read, in that order, each once.
class Declarations
{
public:
  /// A variant ("Type = mortar") has its own heading in the reference, and is the same section otherwise.
  void add_section(const std::string &path, const std::string &variant = "", const std::string &help = "");
  void add(const Declaration &declaration);
  /// Names that somebody asks for without reading them, worth suggesting for a misspelt one.
  void add_known_entry(const std::string &path, const std::string &name);
  void add_known_subsection(const std::string &path, const std::string &name);

  bool has_section(const std::string &path) const;
  bool has_entry(const std::string &path, const std::string &name) const;
  /// What may stand in the section @p path, as far as anybody has asked.
  std::vector<std::string> known_entries(const std::string &path) const;
  std::vector<std::string> known_subsections(const std::string &path) const;
  /// The paths of the sections that have such an entry.
  std::vector<std::string> sections_with(const std::string &entry) const;

  std::map<std::string, std::string> used() const; ///< path -> value
  void print_used(std::ostream &out) const;
  void print_reference(std::ostream &out) const;

private:
  struct Section
  {
    std::string path, variant, help;
  };

  void print_used(std::ostream &out, const std::string &path, const std::string &indent) const;
  void print_table(std::ostream &out, const Section &section) const;
  std::vector<Declaration> entries_of(const Section &section) const;
  std::vector<std::string> subsections_of(const std::string &path) const;

  std::vector<Section> sections{{"", "", ""}};
  std::vector<Declaration> declarations;
  std::map<std::string, std::set<std::string>> asked_entries, asked_subsections; ///< path -> names
};

} // namespace dovetail
