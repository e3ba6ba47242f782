#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
#
# Writes exact.inc beside this file: the exact displacement u_i = prod_d sin(pi x_d + phi_id) of the cube, the body force
# b = -Div(lambda tr(eps) I + 2 mu eps) that belongs to it, E = 1 and nu = 0.3, and the prescribed values.
#
#     python3 prm/benchmarks/performance/cube/exact.py          needs sympy

import os
import sympy as sp

X = sp.symbols("x y z")
pi = sp.Symbol("pi")  # kept by name
phase = [[0.5, 1.3, 0.9], [1.1, 0.4, 0.7], [0.8, 1.2, 0.3]]
nu = sp.Rational(3, 10)
lame, mu = nu / ((1 + nu) * (1 - 2 * nu)), 1 / (2 * (1 + nu))


def arguments(i):
    return [pi * X[d] + phase[i][d] for d in range(3)]


u = [sp.Mul(*[sp.sin(s) for s in arguments(i)]) for i in range(3)]
eps = [[(sp.diff(u[i], X[j]) + sp.diff(u[j], X[i])) / 2 for j in range(3)] for i in range(3)]
trace = sum(eps[i][i] for i in range(3))
stress = [[2 * mu * eps[i][j] + (lame * trace if i == j else 0) for j in range(3)] for i in range(3)]
force = [sp.factor_terms(sp.expand(-sum(sp.diff(stress[i][j], X[j]) for j in range(3)))) for i in range(3)]


def text(components):
    decimals = [c.xreplace({n: n.evalf(17) for n in c.atoms(sp.Rational) if not n.is_Integer}) for c in components]
    return "; ".join(str(c).replace("**", "^") for c in decimals)


lines = ["# SPDX-License-Identifier: LGPL-2.1-or-later", "# Copyright (C) 2026 by the Dovetail authors", "#",
         "# Written by exact.py."]
for side in ("left", "right"):
    lines += ["subsection Domain " + side,
              "  subsection Exact", "    set displacement = " + text(u), "  end",
              "  subsection Source", "    set displacement = " + text(force), "  end",
              "  subsection Boundary condition outer", "    set Field      = displacement",
              "    set Expression = " + text(u), "  end", "end", ""]
with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "exact.inc"), "w", encoding="utf-8") as file:
    file.write("\n".join(lines))
