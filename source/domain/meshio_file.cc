// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Formats that the Python module meshio reads (N. Schlömer, meshio, doi:10.5281/zenodo.1173115): converted to
// Gmsh's format 2.2. Sets of cells and Gmsh's, MED's and Medit's groups become physical groups.

#include <dovetail/domain/mesh_file.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace dovetail {

namespace {

const char *const converter = R"(import sys
import numpy
import meshio

mesh = meshio.read(sys.argv[1])
dims = {"vertex": 0, "line": 1, "triangle": 2, "quad": 2, "tetra": 3, "hexahedron": 3, "wedge": 3, "pyramid": 3}
dim_of = lambda block: dims.get(block.type.rstrip("0123456789"), -1)
groups = [numpy.zeros(len(block.data), dtype=int) for block in mesh.cells]
names = {}
for key in ("gmsh:physical", "cell_tags", "medit:ref", "nastran:ref", "MaterialIds", "material", "id"):
    if key in mesh.cell_data and not any(group.any() for group in groups):
        groups = [abs(numpy.asarray(data).astype(int).ravel()) for data in mesh.cell_data[key]]
for name, value in getattr(mesh, "field_data", {}).items():
    if len(value) == 2:
        names[name] = (int(value[0]), int(value[1]))
for tag, its_names in (getattr(mesh, "cell_tags", None) or {}).items():
    for block, group in zip(mesh.cells, groups):
        if (group == abs(tag)).any():
            names[" ".join(its_names)] = (abs(int(tag)), dim_of(block))
free = 1 + max([0] + [int(group.max()) for group in groups if len(group)])
for name, members in mesh.cell_sets.items():
    if name.startswith("gmsh:"):
        continue
    for dim in (2, 3, 1):
        is_there = False
        for block, group, member in zip(mesh.cells, groups, members):
            if member is not None and dim_of(block) == dim and len(member):
                group[numpy.asarray(member, dtype=int)] = free
                is_there = True
        if is_there:
            names[name] = (free, dim)
            free += 1
points = mesh.points
if points.shape[1] == 2:
    points = numpy.hstack([points, numpy.zeros((len(points), 1))])
known = [i for i, block in enumerate(mesh.cells) if dim_of(block) >= 0]
result = meshio.Mesh(points, [(mesh.cells[i].type, mesh.cells[i].data) for i in known],
                     cell_data={key: [groups[i] for i in known] for key in ("gmsh:physical", "gmsh:geometrical")},
                     field_data={name: numpy.array(value) for name, value in names.items()})
meshio.write(sys.argv[2], result, file_format="gmsh22", binary=False)
)";

std::string in_quotes(const std::string &text)
{
  std::string quoted = "'";
  for (const char letter : text)
    quoted += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
  return quoted + "'";
}

std::string last_line_of(const std::string &file)
{
  std::ifstream stream(file);
  std::string line, last;
  while (std::getline(stream, line))
    if (line.find_first_not_of(' ') != std::string::npos)
      last = line;
  return last;
}

} // namespace

void convert_by_meshio(const std::string &file_name, const std::string &result)
{
  const std::string script = result + ".py", log = result + ".log";
  std::ofstream(script) << converter;
  const std::string command =
      "for python in python3 /usr/bin/python3; do if $python -c 'import meshio' 2> /dev/null; then exec "
      "$python " +
      in_quotes(script) + " " + in_quotes(file_name) + " " + in_quotes(result) + " > " + in_quotes(log) +
      " 2>&1; fi; done; exit 127";
  const int status = std::system(("sh -c " + in_quotes(command)).c_str());
  const std::string reason = last_line_of(log);
  if (status == 0)
    return;
  if (reason.empty() && !std::filesystem::exists(log))
    throw MeshError(
        "its format is read by way of the Python module meshio, which is not installed (in Debian "
        "and Ubuntu: apt install python3-meshio). Install it, or save the mesh in Gmsh's format.");
  throw MeshError("meshio cannot convert it: " + reason + ". Save the mesh in Gmsh's format.");
}

} // namespace dovetail
