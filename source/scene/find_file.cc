// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where the input files are that a scene names, and what they hold.

#include "scene_tree.h"

#include <dovetail/scene/input_file.h>

#include <deal.II/base/mpi.h>

#include <boost/serialization/map.hpp>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace dovetail {

namespace {

/// What the first rank finds, for all of them. A study has no ranks.
template <typename Result, typename Find>
Result on_first_rank(const Find &find)
{
  if (!dealii::Utilities::MPI::job_supports_mpi())
    return find();
  const bool is_root = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0;
  return dealii::Utilities::MPI::broadcast(MPI_COMM_WORLD, is_root ? find() : Result(), 0);
}

/// That of the installed program, ../share/dovetail/materials beside its folder.
std::filesystem::path library_of_materials()
{
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  return program.parent_path().parent_path() / "share" / "dovetail" / "materials";
}

} // namespace

std::string first_that_exists(const std::string &name, const std::vector<std::string> &files)
{
  for (const std::string &file : files) {
    const std::filesystem::path beside = std::filesystem::path(file).parent_path() / name;
    std::error_code error;
    if (std::filesystem::exists(beside, error))
      return beside.lexically_normal().string();
  }
  return name;
}

std::string find_file(const std::string &name, const Location &from, const SceneTree &tree)
{
  std::vector<std::string> files;
  if (from.line > 0) // else it is given by --set, or by the one file of a scene
    files.push_back(from.file);
  files.push_back(tree.location_of("").file);
  return on_first_rank<std::string>([&] {
    const std::string found = first_that_exists(name, files);
    std::error_code error;
    if (found != name || std::filesystem::exists(name, error))
      return found;
    const auto in_library = library_of_materials() / name;
    return std::filesystem::exists(in_library, error) ? in_library.string() : name;
  });
}

std::string content_of(const std::string &file)
{
  std::ostringstream stream;
  stream << std::ifstream(file).rdbuf();
  const std::string content = stream.str(), byte_order_mark = "\xEF\xBB\xBF";
  return content.compare(0, 3, byte_order_mark) == 0 ? content.substr(3) : content;
}

FileTexts read_files_on_first_rank(const std::string &file)
{
  return on_first_rank<FileTexts>([&] { return read_files(file); });
}

FileTexts read_on_first_rank(const std::vector<std::string> &files)
{
  return on_first_rank<FileTexts>([&] {
    FileTexts found;
    for (const std::string &file : files)
      if (const std::string obstacle = obstacle_to_reading(file, largest_scene); !obstacle.empty())
        found.obstacles[file] = obstacle;
      else
        found.texts[file] = content_of(file);
    return found;
  });
}

} // namespace dovetail
