// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "declarations.h"
#include "scene_tree.h"

#include <dovetail/scene/expression.h>

#include <algorithm>
#include <ostream>

namespace dovetail {

namespace {

std::string escape_bars(const std::string &text)
{
  std::string escaped;
  for (const char letter : text)
    escaped += letter == '|' ? "\\|" : std::string(1, letter);
  return escaped;
}

void append_new(std::vector<std::string> &names, const std::map<std::string, std::set<std::string>> &asked,
                const std::string &path)
{
  const auto found = asked.find(path);
  if (found == asked.end())
    return;
  for (const std::string &name : found->second)
    if (std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(name);
}

} // namespace

void Declarations::add_section(const std::string &path, const std::string &variant, const std::string &help)
{
  for (const Section &section : sections)
    if (section.path == path && section.variant == variant)
      return;
  if (!path.empty() && !has_section(parent_path(path)))
    add_section(parent_path(path));
  sections.push_back({path, variant, help});
}

void Declarations::add(const Declaration &declaration)
{
  for (const Declaration &known : declarations)
    if (known.path == declaration.path && known.name == declaration.name &&
        (known.variant == declaration.variant || known.variant.empty()))
      return;
  declarations.push_back(declaration);
}

void Declarations::add_known_entry(const std::string &path, const std::string &name)
{
  asked_entries[path].insert(name);
}

void Declarations::add_known_subsection(const std::string &path, const std::string &name)
{
  asked_subsections[path].insert(name);
}

bool Declarations::has_section(const std::string &path) const
{
  return std::any_of(sections.begin(), sections.end(),
                     [&](const Section &section) { return section.path == path; });
}

bool Declarations::has_entry(const std::string &path, const std::string &name) const
{
  return std::any_of(declarations.begin(), declarations.end(), [&](const Declaration &declaration) {
    return declaration.path == path && declaration.name == name;
  });
}

std::vector<std::string> Declarations::known_entries(const std::string &path) const
{
  std::vector<std::string> names;
  for (const Declaration &declaration : declarations)
    if (declaration.path == path)
      names.push_back(declaration.name);
  append_new(names, asked_entries, path);
  return names;
}

std::vector<std::string> Declarations::known_subsections(const std::string &path) const
{
  std::vector<std::string> names = subsections_of(path);
  append_new(names, asked_subsections, path);
  return names;
}

std::vector<std::string> Declarations::sections_with(const std::string &entry) const
{
  std::vector<std::string> paths;
  for (const Declaration &declaration : declarations)
    if (declaration.name == entry && std::find(paths.begin(), paths.end(), declaration.path) == paths.end())
      paths.push_back(declaration.path);
  return paths;
}

std::vector<std::string> Declarations::subsections_of(const std::string &path) const
{
  std::vector<std::string> names;
  for (const Section &section : sections)
    if (!section.path.empty() && section.variant.empty() && parent_path(section.path) == path)
      names.push_back(last_name(section.path));
  return names;
}

std::map<std::string, std::string> Declarations::used() const
{
  std::map<std::string, std::string> values;
  for (const Declaration &declaration : declarations)
    values[join_path(declaration.path, declaration.name)] = declaration.value;
  return values;
}

void Declarations::print_used(std::ostream &out) const
{
  print_used(out, "", "");
}

void Declarations::print_used(std::ostream &out, const std::string &path, const std::string &indent) const
{
  std::size_t width = 0;
  for (const Declaration &declaration : declarations)
    if (declaration.path == path)
      width = std::max(width, declaration.name.size());
  for (const Declaration &declaration : declarations)
    if (declaration.path == path)
      out << indent << "set " << declaration.name << std::string(width - declaration.name.size(), ' ') << " ="
          << (declaration.value.empty() ? "" : " ") << declaration.value << '\n';

  for (const std::string &name : subsections_of(path)) {
    out << (indent.empty() ? "\n" : "") << indent << "subsection " << name << '\n';
    print_used(out, join_path(path, name), indent + "  ");
    out << indent << "end\n";
  }
}

std::vector<Declaration> Declarations::entries_of(const Section &section) const
{
  std::vector<Declaration> entries;
  for (const Declaration &declaration : declarations)
    if (declaration.path == section.path && declaration.variant == section.variant) {
      // What a variant has read before its section did stands in the table of the section.
      const bool is_common =
          std::any_of(declarations.begin(), declarations.end(), [&](const Declaration &other) {
            return other.path == section.path && other.variant.empty() && other.name == declaration.name;
          });
      if (section.variant.empty() || !is_common)
        entries.push_back(declaration);
    }
  return entries;
}

void Declarations::print_table(std::ostream &out, const Section &section) const
{
  const std::vector<Declaration> entries = entries_of(section);
  if (entries.empty() && section.variant.empty())
    return;

  out << (section.variant.empty() ? "\n## " : "\n### ")
      << (section.path.empty() ? "Top of the scene" : "`" + section.path + "`")
      << (section.variant.empty() ? "" : ", `" + section.variant + "`") << "\n";
  if (!section.help.empty())
    out << '\n' << section.help << '\n';
  if (entries.empty())
    return;

  out << "\n| entry | default | range | meaning |\n|---|---|---|---|\n";
  for (const Declaration &entry : entries) {
    std::string default_text = "required";
    if (entry.default_text)
      default_text = entry.default_text->empty() ? "empty" : "`" + escape_bars(*entry.default_text) + "`";
    out << "| `" << entry.name << "` | " << default_text << " | " << escape_bars(entry.range) << " | "
        << escape_bars(entry.description) << " |\n";
  }
}

void Declarations::print_reference(std::ostream &out) const
{
  out << "# All entries of a scene\n\n"
         "`NAME` stands for a name from a list: `set Domains = left, right` announces the subsections\n"
         "`Domain left` and `Domain right`. Elements of lists are separated by ',' and components by ';'.\n"
         "Any consistent set of units can be used. Each meaning ends with the unit in brackets.\n"
         "Names of files are relative to the file in which they stand, to the scene, or to the working\n"
         "directory, whichever has them first; the same holds for `include FILE`.\n\n"
         "## Formulas\n\n"
         "A formula may use x, y, z (material coordinates), t, the scalars that its range names, and\n\n"
         "| written | meaning |\n|---|---|\n";
  for (const auto &[name, meaning] : Expression::functions())
    out << "| `" << escape_bars(name) << "` | " << escape_bars(meaning) << " |\n";
  for (const Section &section : sections)
    if (section.variant.empty())
      for (const Section &variant : sections)
        if (variant.path == section.path)
          print_table(out, variant);
}

} // namespace dovetail
