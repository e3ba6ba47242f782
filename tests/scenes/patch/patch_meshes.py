#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
#
# Writes the meshes tilted_*.msh beside this file: two bodies, 0 < x < 1/2 and 1/2 < x < 1, whose nodes are moved at
# random (on the outside and at the interface x = 1/2: within it), rotated by an angle that is no multiple of 15 degrees
# and shifted. In 3D the faces at the interface stay plane but are no parallelograms, or, in the meshes named
# tilted_*_affine_3d.msh, they stay rectangles. Boundary ids as those of subdivided_hyper_rectangle.
#
#     python3 tests/scenes/patch/patch_meshes.py

import itertools
import math
import os
import random


def rotation(dim):
    """By 37.3 degrees about z in 2D, by 52.7 degrees about (1, 2, 3) in 3D (Rodrigues)."""
    a, angle = ((0, 0, 1), math.radians(37.3)) if dim == 2 else ((1, 2, 3), math.radians(52.7))
    norm = math.sqrt(sum(c * c for c in a))
    a = [c / norm for c in a]
    cross = [[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]]
    return [[(i == j) * math.cos(angle) + (1 - math.cos(angle)) * a[i] * a[j] + math.sin(angle) * cross[i][j]
             for j in range(3)] for i in range(3)]


def write(name, n, begin, end, interface, at_interface=True):
    """n cells in each direction from begin to end; at the x of interface nodes move only if at_interface."""
    dim = len(n)
    moved = random.Random(1)
    R, shift = rotation(dim), (3.1, -2.7, 1.9 if dim == 3 else 0)
    number, lines = {}, []
    for i in itertools.product(*(range(m + 1) for m in n)):
        x = [b + (e - b) * k / m for b, e, k, m in zip(begin, end, i, n)] + [0] * (3 - dim)
        for d in range(dim):
            u = moved.uniform(-0.25, 0.25) * (end[d] - begin[d]) / n[d]
            if 0 < i[d] < n[d] and (at_interface or i[0] != (n[0] if interface else 0)):
                x[d] += u
        number[i] = len(number) + 1
        x = [sum(R[r][c] * x[c] for c in range(3)) + shift[r] for r in range(3)]
        lines.append(f"{number[i]} " + " ".join(f"{c:.15g}" for c in x))
    head = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(lines))] + lines + ["$EndNodes"]

    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    elements = []
    for i in itertools.product(*(range(m) for m in n)):
        def node(corner):
            return number[tuple(a + b for a, b in zip(i, corner))]
        if dim == 2:
            elements.append((3, 0, [node(c) for c in corners]))
        else:
            elements.append((5, 0, [node(c + (z,)) for z in (0, 1) for c in corners]))
        for d in range(dim):
            for side in (0, 1):
                if i[d] == side * (n[d] - 1):
                    flat = [(0,), (1,)] if dim == 2 else corners
                    elements.append((1 if dim == 2 else 3, 2 * d + side, [node(c[:d] + (side,) + c[d:]) for c in flat]))
    elements.sort(key=lambda e: e[0])
    body = ["$Elements", str(len(elements))]
    for k, (kind, tag, nodes) in enumerate(elements):
        body.append(f"{k + 1} {kind} 2 {tag} {tag} " + " ".join(map(str, nodes)))
    folder = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(folder, name + ".msh"), "w", encoding="utf-8") as file:
        file.write("\n".join(head + body + ["$EndElements"]) + "\n")


write("tilted_left_2d", (3, 5), (0, 0), (0.5, 1), 1)
write("tilted_right_2d", (3, 8), (0.5, 0), (1, 1), 0)
for kind, at_interface in (("", True), ("_affine", False)):
    write(f"tilted_left{kind}_3d", (2, 2, 2), (0, 0, 0), (0.5, 1, 1), 1, at_interface)
    write(f"tilted_right{kind}_3d", (2, 3, 3), (0.5, 0, 0), (1, 1, 1), 0, at_interface)
