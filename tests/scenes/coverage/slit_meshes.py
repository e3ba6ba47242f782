#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
#
# Writes slit_2d.msh and slit_3d.msh beside this file: one mesh of two blocks, 0 < x < 1/2 and 1/2 < x < 1, that meet at x = 1/2
# with different faces and share no node there. Boundary ids: 0 and 3 at x = 0 and 1, 4 at the rest of the outside; 1 and 2 on the
# two sides of x = 1/2 where y < 1/2, 11 and 12 above. Material ids: 10 for y < 1/2, 20 above.
#
# And ring_2d.msh: a square ring of 8 cells, 0 < x, y < 3 without 1 < x, y < 2, cut at x = 1, y < 1. Boundary ids: 0 outside, 3 at the hole, 1 and
# 2 on the left and right of the cut.
#
#     python3 tests/scenes/coverage/slit_meshes.py

import itertools
import os


def output(name, lines, elements):
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), name + ".msh"), "w") as file:
        file.write("\n".join(["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(lines))] + lines
                             + ["$EndNodes", "$Elements", str(len(elements))]
                             + [f"{k + 1} {kind} 2 {tag} {tag} " + " ".join(map(str, nodes))
                                for k, (kind, tag, nodes) in enumerate(elements)] + ["$EndElements"]) + "\n")


def write(name, blocks):
    numbers, lines, elements = {}, [], []
    for block, n in enumerate(blocks):
        dim = len(n)
        for i in itertools.product(*(range(m + 1) for m in n)):
            x = [k / m for k, m in zip(i, n)] + [0] * (3 - dim)
            x[0] = (x[0] + block) / 2
            numbers[(block,) + i] = len(numbers) + 1
            lines.append(f"{len(numbers)} " + " ".join(f"{c:.15g}" for c in x))
        flat = [(0, 0), (1, 0), (1, 1), (0, 1)]
        for i in itertools.product(*(range(m) for m in n)):
            def node(corner):
                return numbers[(block,) + tuple(a + b for a, b in zip(i, corner))]
            cell = flat if dim == 2 else [c + (z,) for z in (0, 1) for c in flat]
            elements.append((3 if dim == 2 else 5, 10 if 2 * i[1] < n[1] else 20, [node(c) for c in cell]))
            for d in range(dim):
                for side in (0, 1):
                    if i[d] == side * (n[d] - 1):
                        corners = [(0,), (1,)] if dim == 2 else flat
                        face = [node(c[:d] + (side,) + c[d:]) for c in corners]
                        tag = 2 * block + side if d == 0 else 4
                        elements.append((1 if dim == 2 else 3, tag + 10 if tag in (1, 2) and 2 * i[1] >= n[1] else tag, face))
    output(name, lines, elements)


write("slit_2d", [(2, 4), (2, 6)])
write("slit_3d", [(1, 2, 2), (1, 4, 3)])


def write_ring():
    number = {(x, y): 4 * x + y + 1 for x in range(4) for y in range(4)}
    lines = [f"{n} {x} {y} 0" for (x, y), n in number.items()] + ["17 1 0 0", "18 1 1 0"]
    elements = []
    for x, y in itertools.product(range(3), range(3)):
        if (x, y) == (1, 1):
            continue
        nodes = [number[x, y], number[x + 1, y], number[x + 1, y + 1], number[x, y + 1]]
        if x == 0:  # the left one of the two sides has its own nodes
            nodes = [{number[1, 0]: 17, number[1, 1]: 18}.get(n, n) for n in nodes]
        elements.append((3, 1, nodes))
        for face, (u, v) in enumerate([(0, -1), (1, 0), (0, 1), (-1, 0)]):
            neighbour = (x + u, y + v)
            tag = (1 if x == 0 else 2) if {(x, y), neighbour} == {(0, 0), (1, 0)} else 3 if neighbour == (1, 1) else 0
            if tag or not (0 <= neighbour[0] < 3 and 0 <= neighbour[1] < 3):
                elements.append((1, tag, [nodes[face], nodes[(face + 1) % 4]]))
    output("ring_2d", lines, elements)


write_ring()
