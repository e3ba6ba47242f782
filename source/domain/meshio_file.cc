// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Formats that the Python module meshio reads (N. Schlömer, meshio, doi:10.5281/zenodo.1173115): converted to
// Gmsh's format 2.2. Sets of cells, Gmsh's, MED's and Medit's groups, the markers of SU2, the blocks, side
// sets and node sets of Exodus (Schoof and Yarberry 1994) and cell data with ids become physical groups.

#include <dovetail/domain/mesh_file.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

namespace dovetail {

namespace {

const char *const converter = R"(import sys
import numpy
import meshio

def read_exodus(file):
    # of meshio's reader the points and cells; with the ids and names of blocks, side sets and node sets
    import netCDF4
    mesh = meshio.read(file)
    with netCDF4.Dataset(file) as data:
        values = lambda name: data.variables[name][:].data if name in data.variables else numpy.zeros(0, dtype=int)
        text = lambda row: b"".join(letter if letter else b"" for letter in row.tolist()).decode().split("\0")[0].strip()
        def ids_and_names(kind, id_name):
            ids = [int(i) for i in values(id_name)]
            rows = data.variables[kind][:].data if kind in data.variables else []
            names_of = [text(row) for row in rows] + [""] * len(ids)
            return [(i, names_of[k] or str(i)) for k, i in enumerate(ids)]
        blocks = ids_and_names("eb_names", "eb_prop1")
        counts = [len(data.dimensions["num_el_in_blk%d" % (k + 1)]) if "num_el_in_blk%d" % (k + 1) in data.dimensions
                  else 0 for k in range(len(blocks))]
        cells = [block for block, n in zip(blocks, counts) if n > 0]
        side_sets = [(i, name, values("elem_ss%d" % (k + 1)), values("side_ss%d" % (k + 1)))
                     for k, (i, name) in enumerate(ids_and_names("ss_names", "ss_prop1"))]
        node_sets = [(i, name, values("node_ns%d" % (k + 1)))
                     for k, (i, name) in enumerate(ids_and_names("ns_names", "ns_prop1"))]
    return mesh, cells, side_sets, node_sets

sides = {"triangle": [(0, 1), (1, 2), (2, 0)], "quad": [(0, 1), (1, 2), (2, 3), (3, 0)],
         "tetra": [(0, 1, 3), (1, 2, 3), (0, 3, 2), (0, 2, 1)],
         "hexahedron": [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 4, 7, 3), (0, 3, 2, 1), (4, 5, 6, 7)]}
shapes = {2: "line", 3: "triangle", 4: "quad"}

def add_sets(mesh, blocks, side_sets, node_sets):
    # faces of cells: those of the side sets, then those all vertices of which are in a node set
    rows = [(base_of(block.type), row) for block in mesh.cells for row in block.data]
    top = max(dims.get(base_of(block.type), 0) for block in mesh.cells)
    named = []
    for tag, name, elements, numbers in side_sets:
        named.append((tag, name, [tuple(rows[e - 1][1][v] for v in sides[rows[e - 1][0]][s - 1])
                                  for e, s in zip(elements, numbers) if rows[e - 1][0] in sides]))
    for tag, name, nodes in node_sets:
        inside = numpy.zeros(len(mesh.points), dtype=bool)
        inside[numpy.asarray(nodes, dtype=int) - 1] = True
        if not inside.all():
            named.append((tag, name, [tuple(row[v] for v in side) for shape, row in rows if dims.get(shape, 0) == top
                                      for side in sides.get(shape, []) if inside[[row[v] for v in side]].all()]))
    taken = {tag for block, (tag, name) in zip(mesh.cells, blocks) if dims.get(base_of(block.type), 0) == top - 1}
    for tag, name, faces in named:
        while tag in taken:
            tag = max(taken) + 1
        taken.add(tag)
        for n in (2, 3, 4):
            of_shape = [face for face in faces if len(face) == n]
            if of_shape:
                mesh.cells.append(meshio.CellBlock(shapes[n], numpy.array(of_shape)))
                groups.append(numpy.full(len(of_shape), tag, dtype=int))
        if faces:
            names[name] = (tag, top - 1)

base_of = lambda shape: shape.rstrip("0123456789")
exodus = sys.argv[1].lower().endswith((".e", ".exo", ".ex2"))
if exodus:
    mesh, blocks, side_sets, node_sets = read_exodus(sys.argv[1])
else:
    mesh = meshio.read(sys.argv[1])
dims = {"vertex": 0, "line": 1, "triangle": 2, "quad": 2, "tetra": 3, "hexahedron": 3, "wedge": 3, "pyramid": 3}
dim_of = lambda block: dims.get(block.type.rstrip("0123456789"), -1)
groups = [numpy.zeros(len(block.data), dtype=int) for block in mesh.cells]
names = {}
for key in ("gmsh:physical", "cell_tags", "medit:ref", "nastran:ref", "su2:tag", "MaterialID", "MaterialIds",
            "CellEntityIds", "material", "id"):
    if key in mesh.cell_data and not any(group.any() for group in groups):
        groups = [abs(numpy.asarray(data).astype(int).ravel()) for data in mesh.cell_data[key]]
if exodus:
    for block, group, (tag, name) in zip(mesh.cells, groups, blocks):
        group[:] = tag
        names[name] = (tag, dim_of(block))
    add_sets(mesh, blocks, side_sets, node_sets)
if sys.argv[1].lower().endswith(".su2"):
    # the names of markers, which meshio counts from the last one that is a number
    markers = [line.split("=", 1)[1].strip() for line in open(sys.argv[1]) if line.startswith("MARKER_TAG")]
    top = max(dim_of(block) for block in mesh.cells)
    number = 0
    for name in markers:
        is_number = name.lstrip("-").isdigit()
        number = int(name) if is_number else number + 1
        if not is_number:
            names[name] = (number, top - 1)
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
  for (const auto &[module, package] :
       {std::pair("netCDF4", "python3-netcdf4"), std::pair("h5py", "python3-h5py")})
    if (reason.find("No module named '" + std::string(module)) != std::string::npos)
      throw MeshError("meshio reads its format by way of the Python module " + std::string(module) +
                      ", which is not installed (in Debian and Ubuntu: apt install " + package +
                      "). Install it, or save the mesh in Gmsh's format.");
  throw MeshError("meshio cannot convert it: " + reason + ". Save the mesh in Gmsh's format.");
}

} // namespace dovetail
