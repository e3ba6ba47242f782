// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "scene_tree.h"

#include <dovetail/scene/user_error.h>

#include <deal.II/base/utilities.h>

#include <algorithm>

namespace dovetail {

void check_writable(const std::string &name, const std::string &value, const Location &location)
{
  if (name.empty())
    throw UserError(location.text() + ": a name is missing.");
  for (const char forbidden : std::string("/=#\\"))
    if (name.find(forbidden) != std::string::npos)
      throw UserError(location.text() + ": the name '" + name + "' contains '" + forbidden +
                      "', which separates names, values or comments. Choose another name.");
  if (value.find_first_of("#\n") != std::string::npos || (!value.empty() && value.back() == '\\'))
    throw UserError(location.text() + ": the value of '" + name +
                    "' contains a '#' or a line break or ends in '\\', which a scene cannot hold.");
}

void check_depth(const std::string &path, const Location &location)
{
  if (std::count(path.begin(), path.end(), '/') >= largest_depth_of_subsections)
    throw UserError(location.text() + ": subsections are nested more than " +
                    std::to_string(largest_depth_of_subsections) + " deep. No entry stands there.");
}

SceneTree::SceneTree(const std::string &file) : all_subsections{{"", {file, 0}, {}}}, places{{"", 0}} {}

const SceneTree::Subsection *SceneTree::find(const std::string &path) const
{
  const auto found = places.find(path);
  return found == places.end() ? nullptr : &all_subsections[found->second];
}

const SceneTree::Entry *SceneTree::find(const std::string &path, const std::string &name) const
{
  const Subsection *subsection = find(path);
  if (subsection == nullptr)
    return nullptr;
  const auto found = subsection->places.find(name);
  return found == subsection->places.end() ? nullptr : &subsection->entries[found->second];
}

std::vector<std::string> SceneTree::names_of_subsections(const std::string &path) const
{
  std::vector<std::string> names;
  for (const Subsection &subsection : all_subsections)
    if (!subsection.path.empty() && parent_path(subsection.path) == path)
      names.push_back(last_name(subsection.path));
  return names;
}

const Location &SceneTree::location_of(const std::string &path) const
{
  const Subsection *subsection = find(path);
  return subsection ? subsection->location : location_of(parent_path(path));
}

SceneTree::Subsection *SceneTree::find_to_change(const std::string &path)
{
  const auto found = places.find(path);
  return found == places.end() ? nullptr : &all_subsections[found->second];
}

void SceneTree::open(const std::string &path, const Location &location)
{
  if (Subsection *subsection = find_to_change(path))
    subsection->location = location;
  else {
    places[path] = all_subsections.size();
    all_subsections.push_back({path, location, {}});
  }
}

void SceneTree::set(const std::string &path, const Entry &entry)
{
  Subsection &subsection = *find_to_change(path);
  const auto [place, is_new] = subsection.places.emplace(entry.name, subsection.entries.size());
  if (is_new)
    subsection.entries.push_back(entry);
  else
    subsection.entries[place->second] = entry;
}

void SceneTree::remove(const std::string &path, const std::string &name)
{
  Subsection &subsection = *find_to_change(path);
  std::vector<Entry> left;
  subsection.places.clear();
  for (const Entry &entry : subsection.entries)
    if (entry.name != name) {
      subsection.places[entry.name] = left.size();
      left.push_back(entry);
    }
  subsection.entries = left;
}

void apply_override(SceneTree &tree, const std::string &assignment)
{
  const Location location{"--set '" + assignment + "'", 0};
  const std::size_t equal_sign = assignment.find('=');
  std::vector<std::string> names =
      dealii::Utilities::split_string_list(assignment.substr(0, equal_sign), '/');
  const bool has_empty_name = std::find(names.begin(), names.end(), "") != names.end();
  if (equal_sign == std::string::npos || names.empty() || has_empty_name)
    throw UserError(location.text() +
                    " is not understood. Write PATH=value, for instance --set 'Interface seam/Theta=-1'.");

  const std::string name = tidy_name(names.back());
  const std::string value = dealii::Utilities::trim(assignment.substr(equal_sign + 1));
  check_writable(name, value, location);
  names.pop_back();
  std::string path;
  for (const std::string &subsection : names) {
    path = join_path(path, tidy_name(subsection));
    if (!tree.find(path))
      tree.open(path, location);
  }
  if (value.empty() && tree.find(path, name))
    tree.remove(path, name);
  else
    tree.set(path, {name, value, location});
}

} // namespace dovetail
