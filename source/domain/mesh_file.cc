// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/mesh_file.h>
#include <dovetail/domain/mesh_text.h>

#include <boost/algorithm/string/case_conv.hpp>
#include <boost/algorithm/string/predicate.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

namespace dovetail {

namespace {

std::string content_of(const std::string &file_name)
{
  std::error_code error;
  if (std::filesystem::exists(file_name, error) && !std::filesystem::is_regular_file(file_name, error))
    throw MeshError("it is a directory or a device, not a file.");
  std::ifstream file(file_name, std::ios::binary);
  std::ostringstream content;
  content << file.rdbuf();
  if (!file.good() || content.str().empty())
    throw MeshError("it is empty or cannot be read.");
  return content.str();
}

/// Both Abaqus and AVS UCD end in .inp; only Abaqus has keyword lines, which start with '*'.
MeshFile read_inp(MeshText &text, const unsigned int dim)
{
  const auto first = text.peek();
  return !first.empty() && first[0] == '*' ? read_abaqus(text, dim) : read_ucd(text, dim);
}

using Reader = MeshFile (*)(MeshText &, unsigned int);
const std::map<std::string, Reader> readers = {
    {".msh", read_gmsh}, {".vtk", read_vtk}, {".unv", read_unv}, {".inp", read_inp}};

/// Of the formats that meshio reads those of solids.
const std::set<std::string> suffixes_of_meshio = {".vtu",  ".e",     ".ex2",  ".exo",  ".med",
                                                  ".bdf",  ".nas",   ".fem",  ".xdmf", ".xmf",
                                                  ".mesh", ".meshb", ".cgns", ".h5m",  ".su2"};

/// Its third line says so. Of this format, meshio reads what is binary.
bool is_binary_vtk(const std::string &file_name)
{
  std::ifstream file(file_name, std::ios::binary);
  std::string line;
  for (unsigned int n = 0; n < 3; ++n)
    std::getline(file, line);
  return boost::starts_with(line, "BINARY");
}

/// A new directory, taken away at the end.
class TemporaryDirectory
{
public:
  TemporaryDirectory()
  {
    std::string pattern = (std::filesystem::temp_directory_path() / "dovetail_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr)
      throw MeshError("no directory can be made for its conversion in " +
                      std::filesystem::temp_directory_path().string() + ". Set TMPDIR to one with room.");
    path = pattern;
  }
  ~TemporaryDirectory()
  {
    std::error_code error;
    std::filesystem::remove_all(path, error);
  }
  TemporaryDirectory(const TemporaryDirectory &) = delete;
  TemporaryDirectory &operator=(const TemporaryDirectory &) = delete;

  std::string path;
};

/// In small letters: capitals do not count.
std::string suffix_of(const std::string &file_name)
{
  return boost::to_lower_copy(std::filesystem::path(file_name).extension().string());
}

} // namespace

bool is_known_mesh_format(const std::string &file_name)
{
  return readers.count(suffix_of(file_name)) > 0 || suffixes_of_meshio.count(suffix_of(file_name)) > 0;
}

MeshFile read_mesh_file(const std::string &file_name, const unsigned int dim)
{
  const std::string suffix = suffix_of(file_name);
  if (suffixes_of_meshio.count(suffix) > 0 || (suffix == ".vtk" && is_binary_vtk(file_name))) {
    content_of(file_name);
    const TemporaryDirectory directory;
    const std::string converted = directory.path + "/mesh.msh";
    convert_by_meshio(file_name, converted);
    MeshText text(content_of(converted));
    MeshFile mesh = read_gmsh(text, dim);
    mesh.format = suffix + ", converted by meshio";
    mesh.note = file_name + " was converted by the Python module meshio";
    return mesh;
  }
  MeshText text(content_of(file_name), file_name);
  MeshFile mesh = readers.at(suffix)(text, dim);
  if (mesh.format.empty())
    mesh.format = suffix;
  return mesh;
}

} // namespace dovetail
