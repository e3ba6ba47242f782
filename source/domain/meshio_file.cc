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

const char *const converter = R"(import re
import sys
import numpy
import meshio

families = {"SPHERE": "vertex", "CIRCLE": "vertex", "POINT": "vertex", "BAR": "line", "BEAM": "line",
            "TRUSS": "line", "EDGE": "line", "ROD": "line", "TRI": "triangle", "TRIANGLE": "triangle",
            "TRISHELL": "triangle", "QUAD": "quad", "SHELL": "quad", "TET": "tetra", "TETRA": "tetra",
            "HEX": "hexahedron", "HEXAHEDRON": "hexahedron", "WEDGE": "wedge", "PYRAMID": "pyramid"}
orders = {"vertex": [1], "line": [2, 3], "triangle": [3, 6], "quad": [4, 8, 9], "tetra": [4, 10],
          "hexahedron": [8, 20, 27], "wedge": [6, 15], "pyramid": [5, 13]}
# of the nodes of a hexahedron between the corners: Exodus has those of the upright edges before those of the top
order_of_hexahedron = {20: [*range(12), 16, 17, 18, 19, 12, 13, 14, 15],
                       27: [*range(12), 16, 17, 18, 19, 12, 13, 14, 15, 23, 24, 25, 26, 21, 22, 20]}

def read_exodus(file):
    # points and cells; with the ids and names of blocks, side sets and node sets. meshio's own reader knows
    # neither names nor side sets and takes the nodes of quadratic hexahedra in another order.
    import netCDF4
    with netCDF4.Dataset(file) as data:
        data.set_auto_mask(False)
        if "num_nodes" not in data.dimensions or "num_el_blk" not in data.dimensions:
            sys.exit("it has no nodes or no blocks of elements")
        values = lambda name: data.variables[name][:] if name in data.variables else numpy.zeros(0, dtype=int)
        def text(row):
            return b"".join(letter or b"" for letter in row.tolist()).decode(errors="replace").split("\0")[0].strip()
        def ids_and_names(kind, id_name, n):
            n = len(data.dimensions[n]) if n in data.dimensions else 0
            ids = [int(i) for i in values(id_name)] or [k + 1 for k in range(n)]
            rows = data.variables[kind][:] if kind in data.variables else []
            names_of = [text(row) for row in rows] + [""] * len(ids)
            # 0 is no group in Gmsh's format
            return [(i if i > 0 else max(0, *ids) + 1 + k, names_of[k] or str(i)) for k, i in enumerate(ids)]
        n_dims = len(data.dimensions["num_dim"])
        points = numpy.zeros((len(data.dimensions["num_nodes"]), 3))
        for d in range(n_dims):
            points[:, d] = values("coord")[d] if "coord" in data.variables else values("coord" + "xyz"[d])
        cells, blocks, shells = [], [], []
        for k, block in enumerate(ids_and_names("eb_names", "eb_prop1", "num_el_blk")):
            if "connect%d" % (k + 1) not in data.variables:
                continue # a block without elements
            connect = data.variables["connect%d" % (k + 1)]
            nodes, kind = numpy.asarray(connect[:], dtype=int) - 1, str(getattr(connect, "elem_type", "")).strip("\0 ")
            family = families.get(kind.upper().rstrip("0123456789"))
            if family == "quad" and nodes.shape[1] in (3, 6):
                family = "triangle"
            if family is None or nodes.shape[1] not in orders[family]:
                sys.exit("the block '%s' has elements of type %s with %d nodes, which are not read"
                         % (block[1], kind, nodes.shape[1]))
            if nodes.min(initial=0) < 0 or nodes.max(initial=0) >= len(points):
                sys.exit("the block '%s' names a node that does not exist" % block[1])
            if family == "hexahedron" and nodes.shape[1] in order_of_hexahedron:
                nodes = nodes[:, order_of_hexahedron[nodes.shape[1]]]
            cells.append((family + ("" if nodes.shape[1] == orders[family][0] else str(nodes.shape[1])), nodes))
            blocks.append(block)
            shells += [n_dims == 3 and (family == "triangle" or "SHELL" in kind.upper())] * len(nodes)
        side_sets = [(i, name, values("elem_ss%d" % (k + 1)), values("side_ss%d" % (k + 1)))
                     for k, (i, name) in enumerate(ids_and_names("ss_names", "ss_prop1", "num_side_sets"))]
        node_sets = [(i, name, values("node_ns%d" % (k + 1)))
                     for k, (i, name) in enumerate(ids_and_names("ns_names", "ns_prop1", "num_node_sets"))]
    return meshio.Mesh(points, cells), blocks, shells, side_sets, node_sets

sides = {"triangle": [(0, 1), (1, 2), (2, 0)], "quad": [(0, 1), (1, 2), (2, 3), (3, 0)],
         "tetra": [(0, 1, 3), (1, 2, 3), (0, 3, 2), (0, 2, 1)],
         "hexahedron": [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 4, 7, 3), (0, 3, 2, 1), (4, 5, 6, 7)],
         "wedge": [(0, 1, 4, 3), (1, 2, 5, 4), (0, 3, 5, 2), (0, 2, 1), (3, 4, 5)],
         "pyramid": [(0, 1, 4), (1, 2, 4), (2, 3, 4), (0, 4, 3), (0, 3, 2, 1)]}
shapes = {2: "line", 3: "triangle", 4: "quad"}

def faces_of_side_set(name, elements, numbers, rows, shells, top):
    faces = []
    for element, number in zip(elements, numbers):
        if not 1 <= element <= len(rows):
            sys.exit("the side set '%s' names the element %d, but there are %d" % (name, element, len(rows)))
        shape, row = rows[element - 1]
        if shells[element - 1]: # sides 1 and 2 of a shell are its faces, no boundary of a plane mesh
            if number in (1, 2):
                faces += [tuple(row[:len(sides[shape])])] if top == 3 else []
                continue
            number -= 2
        if shape not in sides or number < 1 or number > len(sides[shape]):
            sys.exit("the side set '%s' names a side of the element %d that does not exist" % (name, element))
        faces.append(tuple(row[v] for v in sides[shape][number - 1]))
    return faces

def faces_of_node_set(name, nodes, cells, top, n_nodes):
    # of cells, those all corners of which are in the set
    if len(nodes) and not 1 <= min(nodes) <= max(nodes) <= n_nodes:
        sys.exit("the node set '%s' names a node that does not exist" % name)
    inside = numpy.zeros(n_nodes, dtype=bool)
    inside[numpy.asarray(nodes, dtype=int) - 1] = True
    if inside.all():
        return []
    faces = []
    for block in cells:
        if dims.get(base_of(block.type), 0) == top:
            for side in sides.get(base_of(block.type), []):
                of_side = block.data[:, list(side)]
                faces += [tuple(face) for face in of_side[inside[of_side].all(axis=1)]]
    return faces

def add_sets(mesh, blocks, shells, side_sets, node_sets):
    rows = [(base_of(block.type), row) for block in mesh.cells for row in block.data]
    top = max([dims.get(base_of(block.type), 0) for block in mesh.cells], default=0)
    named = [(tag, name, faces_of_side_set(name, elements, numbers, rows, shells, top))
             for tag, name, elements, numbers in side_sets]
    names_of_sides = [name for tag, name, faces in named]
    named += [(tag, "node set " + name if name in names_of_sides else name,
               faces_of_node_set(name, nodes, mesh.cells, top, len(mesh.points))) for tag, name, nodes in node_sets]
    taken = {tag for block, (tag, name) in zip(mesh.cells, blocks) if dims.get(base_of(block.type), 0) == top - 1}
    for tag, name, faces in named:
        if tag in taken:
            tag = max(taken) + 1
        taken.add(tag)
        for n in (2, 3, 4):
            of_shape = [face for face in faces if len(face) == n]
            if of_shape:
                mesh.cells.append(meshio.CellBlock(shapes[n], numpy.array(of_shape)))
                groups.append(numpy.full(len(of_shape), tag, dtype=int))
        if faces and name != str(tag):
            names.add((name if not name.isdigit() else "set " + name, top - 1, tag))

base_of = lambda shape: shape.rstrip("0123456789")
exodus = sys.argv[1].lower().endswith((".e", ".exo", ".ex2"))
if exodus:
    mesh, blocks, shells, side_sets, node_sets = read_exodus(sys.argv[1])
else:
    file = sys.argv[1]
    if file.lower().endswith((".bdf", ".nas", ".fem")) and "BEGIN BULK" not in open(file, errors="replace").read():
        file = sys.argv[2] + ".bdf" # of Gmsh: bulk data alone
        open(file, "w").write("BEGIN BULK\n" + open(sys.argv[1], errors="replace").read())
    if file.lower().endswith((".vtu", ".vtk")):
        content = open(file, "rb").read()
        # Versions 2.0 and later of .vtu differ from 1.0 in Lagrange cells only; meshio does not know them.
        known = re.sub(rb'(<VTKFile[^>]*\sversion=")2\.[0-9]+"', rb'\g<1>1.0"', content, count=1)
        if file.lower().endswith(".vtk"):
            known = content + b"\n" # it must end a binary .vtk, which Gmsh leaves out
        if known != content:
            file = sys.argv[2] + file[-4:].lower()
            open(file, "wb").write(known)
    mesh = meshio.read(file)
    if any("LAGRANGE" in block.type for block in mesh.cells):
        sys.exit("it has Lagrange cells of VTK, which are not read: write linear or quadratic cells")
dims = {"vertex": 0, "line": 1, "triangle": 2, "quad": 2, "tetra": 3, "hexahedron": 3, "wedge": 3, "pyramid": 3}
dim_of = lambda block: dims.get(block.type.rstrip("0123456789"), -1)
groups = [numpy.zeros(len(block.data), dtype=int) for block in mesh.cells]
names = set()
for key in ("gmsh:physical", "cell_tags", "medit:ref", "nastran:ref", "su2:tag", "MaterialID", "MaterialIDs", "MaterialIds",
            "CellEntityIds", "material", "id"):
    if key in mesh.cell_data and not any(group.any() for group in groups):
        groups = [abs(numpy.asarray(data).astype(int).ravel()) for data in mesh.cell_data[key]]
if exodus:
    for block, group, (tag, name) in zip(mesh.cells, groups, blocks):
        group[:] = tag
        if name != str(tag):
            names.add((name, dim_of(block), tag))
    add_sets(mesh, blocks, shells, side_sets, node_sets)
if sys.argv[1].lower().endswith(".su2"):
    # the names of markers, which meshio counts from the last one that is a number
    markers = [line.split("=", 1)[1].strip() for line in open(sys.argv[1]) if line.startswith("MARKER_TAG")]
    top = max(dim_of(block) for block in mesh.cells)
    number = 0
    for name in markers:
        is_number = name.lstrip("-").isdigit()
        number = int(name) if is_number else number + 1
        if not is_number:
            names.add((name, top - 1, number))
for name, value in getattr(mesh, "field_data", {}).items():
    if len(value) == 2:
        names.add((name, int(value[1]), int(value[0])))
for tag, its_names in (getattr(mesh, "cell_tags", None) or {}).items():
    for block, group in zip(mesh.cells, groups):
        if (group == abs(tag)).any():
            names.update((name, dim_of(block), abs(int(tag))) for name in its_names)
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
            names.add((name, dim, free))
            free += 1
points = mesh.points
if points.shape[1] == 2:
    points = numpy.hstack([points, numpy.zeros((len(points), 1))])
known = [i for i, block in enumerate(mesh.cells) if dim_of(block) >= 0]
result = meshio.Mesh(points, [(mesh.cells[i].type, mesh.cells[i].data) for i in known],
                     cell_data={key: [groups[i] for i in known] for key in ("gmsh:physical", "gmsh:geometrical")})
meshio.write(sys.argv[2], result, file_format="gmsh22", binary=False)
# a block and a side set may have one name, which meshio's own table of names does not hold
lines = open(sys.argv[2]).read().split("$EndMeshFormat\n", 1)
table = "".join('%d %d "%s"\n' % (dim, tag, name.replace('"', "'")) for name, dim, tag in sorted(names))
table = "$EndMeshFormat\n$PhysicalNames\n%d\n%s$EndPhysicalNames\n" % (len(names), table)
open(sys.argv[2], "w").write(lines[0] + table + lines[1])
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
  const std::string no_room = "its conversion cannot be written to " +
                              std::filesystem::path(result).parent_path().parent_path().string() +
                              ". Is the disk full? Set TMPDIR to a directory with room.";
  if (!(std::ofstream(script) << converter << std::flush))
    throw MeshError(no_room);
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
  if (reason.empty() || reason.find("No space left") != std::string::npos)
    throw MeshError(no_room);
  for (const auto &[module, package] :
       {std::pair("netCDF4", "python3-netcdf4"), std::pair("h5py", "python3-h5py")})
    if (reason.find("No module named '" + std::string(module)) != std::string::npos)
      throw MeshError("meshio reads its format by way of the Python module " + std::string(module) +
                      ", which is not installed (in Debian and Ubuntu: apt install " + package +
                      "). Install it, or save the mesh in Gmsh's format.");
  throw MeshError("meshio cannot convert it: " + reason + ". Save the mesh in Gmsh's format.");
}

} // namespace dovetail
