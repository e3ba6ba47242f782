// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "scene_state.h"

#include <algorithm>

namespace dovetail {

namespace {

bool ends_with(const std::string &text, const std::string &end)
{
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

std::string quoted(const std::string &kind, const std::string &name)
{
  return "the " + kind + " '" + name + "'";
}

/// "Did you mean …", or if nothing is near what would be legal.
std::string remedy(const std::string &name, const std::vector<std::string> &known, const std::string &kind)
{
  const std::string guess = did_you_mean(name, known);
  return guess.empty() ? "Known " + kind + ": " + comma_separated(known) + "." : guess;
}

/// 'Interface' of 'Interface seam'.
std::string kind_of(const std::string &path)
{
  const std::string name = last_name(path);
  return name.substr(0, name.find(' '));
}

/// "It belongs to …", if sections of another kind have such an entry.
std::string where_it_belongs(const SceneState &state, const std::string &path, const std::string &entry)
{
  std::vector<std::string> sections;
  for (const std::string &section : state.declarations.sections_with(entry))
    if (kind_of(section) != kind_of(path))
      sections.push_back(section.empty() ? "the top of the scene" : section);
  if (sections.empty())
    return "";
  const bool are_many = sections.size() > 3;
  sections.resize(std::min<std::size_t>(sections.size(), 3));
  return "It belongs to " + comma_separated(sections) + (are_many ? ", …. " : ". ");
}

[[noreturn]] void refuse_entry(const SceneState &state, const std::string &path, const std::string &name)
{
  const SceneTree::Entry *type = state.tree.find(path, "Type");
  const std::string condition = type && name != "Type" ? " with Type = " + type->value : "";
  throw UserError(state.where(path, name) + quoted("entry", name) + " is not known here" + condition + ". " +
                  where_it_belongs(state, path, name) +
                  remedy(name, state.declarations.known_entries(path), "entries"));
}

} // namespace

std::string SceneState::where(const std::string &path, const std::string &name) const
{
  const SceneTree::Entry *entry = tree.find(path, name);
  const Location &location = entry ? entry->location : tree.location_of(path);
  return (path.empty() ? "The scene" : path) + ", " + location.text() + ": ";
}

void SceneState::refuse_subsection(const std::string &path) const
{
  const std::string parent = parent_path(path), name = last_name(path);
  throw UserError((parent.empty() ? "The scene" : parent) + ", " + tree.location_of(path).text() + ": " +
                  quoted("subsection", name) + " is not known here. " +
                  remedy(name, declarations.known_subsections(parent), "subsections"));
}

void SceneState::refuse_misspelt_subsection() const
{
  for (const SceneTree::Subsection &subsection : tree.subsections())
    if (!declarations.has_section(subsection.path)) {
      const std::string parent = parent_path(subsection.path);
      for (const std::string &known : declarations.known_subsections(parent))
        if (tree.find(join_path(parent, known)) == nullptr &&
            !did_you_mean(last_name(subsection.path), {known}).empty())
          refuse_subsection(subsection.path);
    }
}

std::shared_ptr<SceneText> SceneText::copy() const
{
  return std::shared_ptr<SceneText>(new SceneText(std::make_unique<Implementation>(*implementation)));
}

SceneText::SceneText(std::unique_ptr<Implementation> implementation)
    : implementation(std::move(implementation))
{
}

SceneText::~SceneText() = default;

std::shared_ptr<SceneText> SceneText::from_file(const std::string &file_name,
                                                const std::vector<std::string> &overrides)
{
  const FileTexts texts =
      read_files_on_first_rank(file_name); // parsed on all, so that all find the same errors
  if (const auto found = texts.obstacles.find(file_name); found != texts.obstacles.end())
    throw UserError("The scene '" + file_name + "' " + found->second);

  auto implementation = std::make_unique<Implementation>();
  implementation->tree =
      ends_with(file_name, ".json") ? parse_json(file_name, texts) : parse_prm(file_name, texts);
  for (const std::string &assignment : overrides)
    apply_override(implementation->tree, assignment);
  read_materials_files(implementation->tree);
  implementation->tables = read_tables(implementation->tree);
  return std::shared_ptr<SceneText>(new SceneText(std::move(implementation)));
}

std::shared_ptr<SceneText> SceneText::from_prm(const std::string &prm_text)
{
  auto implementation = std::make_unique<Implementation>();
  implementation->tree = parse_prm("scene.prm", {{{"scene.prm", prm_text}}, {}});
  return std::shared_ptr<SceneText>(new SceneText(std::move(implementation)));
}

std::shared_ptr<SceneText> SceneText::for_documentation()
{
  auto implementation = std::make_unique<Implementation>();
  implementation->is_documenting = true;
  return std::shared_ptr<SceneText>(new SceneText(std::move(implementation)));
}

Section SceneText::root(const std::shared_ptr<SceneText> &text)
{
  return Section(text, "");
}

void SceneText::check_all_read() const
{
  for (const SceneTree::Subsection &subsection : implementation->tree.subsections()) {
    if (!implementation->declarations.has_section(subsection.path))
      implementation->refuse_subsection(subsection.path);
    for (const SceneTree::Entry &entry : subsection.entries)
      if (!implementation->declarations.has_entry(subsection.path, entry.name))
        refuse_entry(*implementation, subsection.path, entry.name);
  }
}

void SceneText::print_used(std::ostream &out) const
{
  implementation->declarations.print_used(out);
}

void SceneText::print_reference(std::ostream &out) const
{
  implementation->declarations.print_reference(out);
}

std::map<std::string, std::string> SceneText::given() const
{
  std::map<std::string, std::string> result;
  for (const SceneTree::Subsection &subsection : implementation->tree.subsections())
    for (const SceneTree::Entry &entry : subsection.entries)
      result[join_path(subsection.path, entry.name)] = entry.value;
  return result;
}

std::vector<std::string> SceneText::tables() const
{
  std::vector<std::string> contents;
  for (const auto &[file, content] : implementation->tables.texts)
    contents.push_back(content);
  return contents;
}

std::map<std::string, std::string> SceneText::used() const
{
  return implementation->declarations.used();
}

void SceneText::check_unchanged(const std::map<std::string, std::string> &before,
                                const std::function<bool(const std::string &)> &may_differ,
                                const std::string &refusal) const
{
  const auto now = used();
  const auto in_words = [](const std::string &value) {
    return value.empty() ? "nothing" : "'" + value + "'";
  };
  const auto refuse = [&](const std::string &path, const std::string &change) {
    const std::string parent = parent_path(path), name = last_name(path);
    throw UserError(implementation->where(parent, name) + "the entry '" + name + "' " + change + ". " +
                    refusal);
  };
  for (const auto &[path, value] : now)
    if (const auto old = before.find(path); !may_differ(path)) {
      if (old == before.end())
        refuse(path, "is new, with the value " + in_words(value));
      else if (old->second != value)
        refuse(path, "was " + in_words(old->second) + " and is " + in_words(value));
    }
  for (const auto &[path, value] : before)
    if (now.count(path) == 0 && !may_differ(path))
      refuse(path, "had the value " + in_words(value) + " and is gone");
}

BoundaryNames SceneText::boundary_names(const std::string &domain) const
{
  const auto found = implementation->boundary_names.find("Domain " + domain);
  return found == implementation->boundary_names.end() ? BoundaryNames() : found->second;
}

const std::vector<FormulaWithTables> &SceneText::formulas_with_tables() const
{
  return implementation->formulas_with_tables;
}

const std::string &SceneText::file_name() const
{
  return implementation->tree.location_of("").file;
}

std::string SceneText::name() const
{
  const std::string last = file_name().substr(file_name().rfind('/') + 1);
  const std::string stem = last.substr(0, last.rfind('.'));
  return stem.find_first_not_of('.') == std::string::npos ? "scene" : stem; // "..": another directory
}

} // namespace dovetail
