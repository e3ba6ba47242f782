#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
#
# Writes the meshes arch_*.msh beside this file: half of a shallow arch, y = (1 - x^2) / 20 + s with -1 < x < 0 and
# 0 < s < 0.015, in two parts that meet at x = -0.4. Boundary ids: 0 and 1 left and right, 2 and 3 below and above.
#
#     python3 tests/scenes/arc_length/arch_meshes.py

import os


def write(name, begin, end, nx, ny):
    def node(i, j):
        return i * (ny + 1) + j + 1

    lines = []
    for i in range(nx + 1):
        x = begin + (end - begin) * i / nx
        for j in range(ny + 1):
            lines.append(f"{node(i, j)} {x:.15g} {(1 - x * x) / 20 + 0.015 * j / ny:.15g} 0")
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
    folder = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(folder, name + ".msh"), "w", encoding="utf-8") as file:
        file.write("\n".join(text + ["$EndElements"]) + "\n")


write("arch_left", -1, -0.4, 12, 3)
write("arch_right", -0.4, 0, 8, 2)
