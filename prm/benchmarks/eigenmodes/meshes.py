#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
#
# Writes beside this file what the scenes include: the meshes membrane_*.msh, parts of a trapezoid whose half width
# falls from 2.5 at x = 0 to 0.5 at x = 10 (boundary 0: its left end, 1: its right end, 2 and 3: below and above), and
# edges.inc, the supports u_z = 0 of the nodes on the lower edges of the plate.
#
#     python3 prm/benchmarks/eigenmodes/meshes.py

import os

FOLDER = os.path.dirname(os.path.abspath(__file__))
LICENCE = "# SPDX-License-Identifier: LGPL-2.1-or-later\n# Copyright (C) 2026 by the Dovetail authors\n"


def write_membrane(name, begin, end, nx, ny):
    """nx cells along and ny across the part from begin to end."""
    def node(i, j):
        return i * (ny + 1) + j + 1

    lines = []
    for i in range(nx + 1):
        x = begin + (end - begin) * i / nx
        for j in range(ny + 1):
            lines.append(f"{node(i, j)} {x:.15g} {(2.5 - 0.2 * x) * (2 * j / ny - 1):.15g} 0")
    elements = [(1, 0, [node(0, j), node(0, j + 1)]) for j in range(ny)]
    elements += [(1, 1, [node(nx, j), node(nx, j + 1)]) for j in range(ny)]
    elements += [(1, 2, [node(i, 0), node(i + 1, 0)]) for i in range(nx)]
    elements += [(1, 3, [node(i, ny), node(i + 1, ny)]) for i in range(nx)]
    elements += [(3, 0, [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)])
                 for i in range(nx) for j in range(ny)]
    text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(lines))] + lines + ["$EndNodes"]
    text += ["$Elements", str(len(elements))]
    text += [f"{k + 1} {kind} 2 {tag} {tag} " + " ".join(map(str, nodes))
             for k, (kind, tag, nodes) in enumerate(elements)]
    with open(os.path.join(FOLDER, name + ".msh"), "w", encoding="utf-8") as file:
        file.write("\n".join(text + ["$EndElements"]) + "\n")


def supports(domain, begin, end, nx, ny, edge):
    """Of the degree 2: the vertices and the middles on the edges below; @p edge: the x of the one across."""
    xs = [begin + (end - begin) * i / (2 * nx) for i in range(2 * nx + 1)]
    ys = [10 * j / (2 * ny) for j in range(2 * ny + 1)]
    points = [(x, y) for x in xs for y in (0, 10)] + [(edge, y) for y in ys[1:-1]]
    names = [f"edge {k}" for k in range(len(points))]
    text = [f"subsection Domain {domain}", f"  set Boundary conditions = {', '.join(names)}"]
    for name, (x, y) in zip(names, points):
        text += [f"  subsection Boundary condition {name}", "    set Type       = point support",
                 f"    set Point      = {x:.15g}; {y:.15g}; 0", "    set Components = z", "  end"]
    return text + ["end"]


write_membrane("membrane_left", 0, 5, 6, 8)
write_membrane("membrane_right", 5, 10, 5, 6)
with open(os.path.join(FOLDER, "edges.inc"), "w", encoding="utf-8") as edges:
    edges.write(LICENCE + "#\n# Written by meshes.py: the lower edges of plate.prm, for the degree 2.\n")
    edges.write("\n".join(supports("left", 0, 5, 4, 8, 0) + supports("right", 5, 10, 4, 6, 10)) + "\n")
