#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
#
# Writes the meshes arch_*.msh beside this file: half of a shallow arch, y = (1 - x^2) / 20 + s with -1 < x < 0 and
# 0 < s < 0.015, in two parts that meet at x = -0.4. Boundary ids: 0 and 1 left and right, 2 and 3 below and above. In 3D
# (arch_*_3d.msh) of the width 0.1, with the sides 4 and 5.
#
#     python3 tests/scenes/arc_length/arch_meshes.py

import os


def save(name, lines, elements):
    text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(lines))] + lines + ["$EndNodes"]
    text += ["$Elements", str(len(elements))]
    text += [f"{k + 1} {kind} 2 {tag} {tag} " + " ".join(map(str, nodes))
             for k, (kind, tag, nodes) in enumerate(elements)]
    folder = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(folder, name + ".msh"), "w", encoding="utf-8") as file:
        file.write("\n".join(text + ["$EndElements"]) + "\n")


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
    save(name, lines, elements)


def write_3d(name, begin, end, nx, ny, nz):
    def node(i, j, k):
        return (i * (ny + 1) + j) * (nz + 1) + k + 1

    lines = []
    for i in range(nx + 1):
        x = begin + (end - begin) * i / nx
        for j in range(ny + 1):
            for k in range(nz + 1):
                y = (1 - x * x) / 20 + 0.015 * j / ny
                lines.append(f"{node(i, j, k)} {x:.15g} {y:.15g} {0.1 * k / nz:.15g}")
    elements = []
    for tag, i in ((0, 0), (1, nx)):
        elements += [(3, tag, [node(i, j, k), node(i, j + 1, k), node(i, j + 1, k + 1), node(i, j, k + 1)])
                     for j in range(ny) for k in range(nz)]
    for tag, j in ((2, 0), (3, ny)):
        elements += [(3, tag, [node(i, j, k), node(i + 1, j, k), node(i + 1, j, k + 1), node(i, j, k + 1)])
                     for i in range(nx) for k in range(nz)]
    for tag, k in ((4, 0), (5, nz)):
        elements += [(3, tag, [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k)])
                     for i in range(nx) for j in range(ny)]
    elements += [(5, 0, [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k),
                         node(i, j, k + 1), node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1), node(i, j + 1, k + 1)])
                 for i in range(nx) for j in range(ny) for k in range(nz)]
    save(name, lines, elements)


write("arch_left", -1, -0.4, 12, 3)
write("arch_right", -0.4, 0, 8, 2)
write_3d("arch_left_3d", -1, -0.4, 8, 1, 1)
write_3d("arch_right_3d", -0.4, 0, 5, 1, 2)
