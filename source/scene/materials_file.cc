// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Materials from files of their own: subsections Material NAME as in a scene, with values in SI.

#include "scene_tree.h"

#include <dovetail/scene/user_error.h>

#include <deal.II/base/utilities.h>

#include <algorithm>

namespace dovetail {

namespace {

bool is_below(const std::string &path, const std::string &section)
{
  return path.size() > section.size() && path.compare(0, section.size() + 1, section + "/") == 0;
}

/// Whether the scene leaves the subsection @p path of a material to the library: all parts but those to which
/// it gives another Type, perhaps none.
bool is_wanted(const SceneTree &library, const std::string &path, const std::string &material,
               const SceneTree &scene)
{
  if (path == material)
    return true;
  const std::string part = path.substr(0, path.find('/', material.size() + 1));
  const auto *type = scene.find(part, "Type"), *library_type = library.find(part, "Type");
  return type == nullptr || (library_type != nullptr && type->value == library_type->value);
}

/// "Material copper/Solid with Heat" adds to the part Solid what it has only beside a part Heat.
void take_entries_beside(const SceneTree &library, const std::string &material, SceneTree &tree)
{
  for (const SceneTree::Subsection &subsection : library.subsections()) {
    const auto with = subsection.path.find(" with ", material.size());
    if (!is_below(subsection.path, material) || with == std::string::npos)
      continue;
    const std::string part = subsection.path.substr(0, with),
                      other = material + "/" + subsection.path.substr(with + 6);
    const auto *type = tree.find(other, "Type");
    const auto *own = tree.find(part, "Type"), *of_library = library.find(part, "Type");
    const bool takes_part = own != nullptr && of_library != nullptr && own->value == of_library->value;
    if (takes_part && type != nullptr && type->value != "none")
      for (SceneTree::Entry entry : subsection.entries)
        if (tree.find(part, entry.name) == nullptr) {
          entry.is_in_si = true;
          tree.set(part, entry);
        }
  }
}

void take_material(const SceneTree &library, const std::string &material, SceneTree &tree)
{
  const SceneTree scene = tree; // before it grows
  for (const SceneTree::Subsection &subsection : library.subsections()) {
    if ((subsection.path != material && !is_below(subsection.path, material)) ||
        subsection.path.find(" with ", material.size()) != std::string::npos ||
        !is_wanted(library, subsection.path, material, scene))
      continue;
    if (tree.find(subsection.path) == nullptr)
      tree.open(subsection.path, subsection.location);
    for (SceneTree::Entry entry : subsection.entries)
      if (tree.find(subsection.path, entry.name) == nullptr) {
        entry.is_in_si = true;
        tree.set(subsection.path, entry);
      }
  }
  take_entries_beside(library, material, tree);
}

/// What a file of materials may hold, and the names of its materials.
std::vector<std::string> names_of_materials(const SceneTree &library, const std::string &file)
{
  std::vector<std::string> names;
  for (const SceneTree::Entry &entry : library.find("")->entries)
    throw UserError(
        entry.location.text() + ": the entry '" + entry.name +
        "' stands outside of a material. A file of materials has subsections Material NAME only.");
  for (const std::string &name : library.names_of_subsections("")) {
    if (name.rfind("Material ", 0) != 0)
      throw UserError(library.location_of(name).text() + ": the subsection '" + name +
                      "' is no material. A file of materials has subsections Material NAME only.");
    names.push_back(name.substr(9));
  }
  if (names.empty())
    throw UserError("The file of materials '" + file + "' has no subsection Material NAME.");
  return names;
}

} // namespace

void read_materials_files(SceneTree &tree)
{
  const SceneTree::Entry *entry = tree.find("", "Materials file");
  const SceneTree::Entry *materials = tree.find("", "Materials");
  if (entry == nullptr || materials == nullptr)
    return;
  SceneTree::Entry found = *entry;
  found.value.clear();
  const auto wanted = dealii::Utilities::split_string_list(materials->value, ',');
  std::vector<std::string> known;
  for (const std::string &name : dealii::Utilities::split_string_list(entry->value, ',')) {
    const std::string file = find_file(name, entry->location, tree);
    found.value += (found.value.empty() ? "" : ", ") + file;
    const FileTexts texts = read_files_on_first_rank(file);
    if (const auto obstacle = texts.obstacles.find(file); obstacle != texts.obstacles.end())
      throw UserError("The scene, " + entry->location.text() + ": Materials file names '" + name +
                      "', which " + obstacle->second +
                      " A relative path starts beside the scene or in the working directory.");
    const SceneTree library = parse_prm(file, texts);
    for (const std::string &material : names_of_materials(library, file)) {
      known.push_back(material);
      if (std::find(wanted.begin(), wanted.end(), material) != wanted.end())
        take_material(library, "Material " + material, tree);
    }
  }
  tree.set("", found);
  for (const std::string &name : wanted)
    if (tree.find("Material " + name) == nullptr)
      throw UserError("The scene, " + materials->location.text() + ": Materials names '" + name +
                      "', but there is no subsection 'Material " + name +
                      "', and the file of materials has " + comma_separated(known) + " only. " +
                      did_you_mean(name, known));
}

} // namespace dovetail
