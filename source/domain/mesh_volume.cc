// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// One body out of a file with several.

#include <dovetail/domain/mesh_file.h>
#include <dovetail/scene/user_error.h>

#include <boost/algorithm/string/predicate.hpp>

#include <set>

namespace dovetail {

namespace {

bool is_whole_number(const std::string &text)
{
  return !text.empty() && text.size() < 10 && text.find_first_not_of("0123456789") == std::string::npos;
}

std::string words_on_unwritable(const std::vector<std::string> &names)
{
  for (const std::string &name : names)
    if (name.find_first_of(",#") != std::string::npos)
      return " A name with ',' or '#' cannot be written in a scene: take the id, or rename the volume.";
  return "";
}

/// Names first, then numbers that are no names.
std::string names_of_volumes(const MeshFile &mesh)
{
  std::vector<std::string> names, numbers;
  for (const auto &[name, cells] : mesh.volumes)
    (is_whole_number(name) ? numbers : names).push_back(name);
  std::set<unsigned int> ids(mesh.cells.ids.begin(), mesh.cells.ids.end());
  for (const unsigned int id : ids)
    if (const std::string number = std::to_string(id); mesh.volumes.count(number) == 0)
      numbers.push_back(number);
  if (names.size() > 30)
    names.resize(30);
  if (numbers.size() > 30)
    numbers.resize(30);
  return (names.empty() ? "It names no volumes" : "It has the volumes " + comma_separated(names)) +
         ", and the ids " + comma_separated(numbers) + "." + words_on_unwritable(names);
}

std::vector<std::size_t> cells_of_volume(const std::string &name, const MeshFile &mesh)
{
  if (const auto exact = mesh.volumes.find(name); exact != mesh.volumes.end())
    return exact->second;
  std::vector<std::size_t> cells;
  for (std::size_t c = 0; is_whole_number(name) && c < mesh.cells.size(); ++c)
    if (std::to_string(mesh.cells.ids[c]) == name)
      cells.push_back(c);
  for (const auto &[known, its_cells] : mesh.volumes)
    if (cells.empty() && boost::algorithm::iequals(known, name))
      cells = its_cells;
  if (cells.empty()) {
    std::vector<std::string> known;
    for (const auto &[volume, its_cells] : mesh.volumes)
      known.push_back(volume);
    const std::string guess = did_you_mean(name, known);
    throw MeshError("has '" + name + "', which is no volume of this mesh. " + names_of_volumes(mesh) +
                    (guess.empty() ? "" : " " + guess));
  }
  return cells;
}

} // namespace

void select_volumes(const std::vector<std::string> &names, MeshFile &mesh)
{
  std::vector<char> is_selected(mesh.cells.size(), 0);
  for (const std::string &name : names)
    for (const std::size_t cell : cells_of_volume(name, mesh))
      is_selected[cell] = 1;
  MeshElements selected;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c)
    if (is_selected[c] != 0) {
      const unsigned int *nodes = mesh.cells.nodes_of(c);
      selected.add(mesh.cells.numbers[c], mesh.cells.ids[c], {nodes, nodes + mesh.cells.n_nodes(c)});
    }
  mesh.is_part = selected.size() < mesh.cells.size();
  mesh.cells = std::move(selected);
  mesh.volumes.clear();
}

} // namespace dovetail
