#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
#
# Writes the manufactured solutions exact_*.prm beside this file: exact solution, source and prescribed values of two
# bodies, left (x < 1/2) and right (x > 1/2), which share trace and flux at the seam x = 1/2.
#
#     python3 tests/convergence/manufactured.py          needs sympy
#
# Heat: -div(k grad T) = r. Solids: -Div P(F) = b. Each body has its own material; where the two differ, the solution of
# side i is B_i = g(y, z) + (x - s) D_i(y, z) with one trace g and one flux.

import os
import sympy as sp

x, y, z = X = sp.symbols("x y z")
half = sp.Rational(1, 2)



def heat_source(T, k, dim):
    return -sum(sp.diff(k * sp.diff(T, c), c) for c in X[:dim])


def gradient(u, dim):
    """3 x 3; plane strain in two dimensions."""
    return sp.Matrix(3, 3, lambda i, j: sp.diff(u[i], X[j]) if i < dim and j < dim else 0)


def linear_elastic(u, lame, mu, dim):
    eps = (gradient(u, dim) + gradient(u, dim).T) / 2
    return lame * eps.trace() * sp.eye(3) + 2 * mu * eps


def neo_hookean_of(F, mu, kappa):
    """W = mu/2 (J^(-2/3) tr C - 3) + kappa/4 (J^2 - 1 - 2 ln J)"""
    J = F.det()
    return (mu * J**sp.Rational(-2, 3) * (F - (F.T * F).trace() / 3 * F.inv().T) +
            kappa * (J**2 - 1) / 2 * F.inv().T)


def body_force(P, dim):
    return [-sum(sp.diff(P[i, j], X[j]) for j in range(dim)) for i in range(dim)]


def numbers(value):
    """Rational numbers as decimals: the formulas become shorter and are evaluated faster."""
    return value.xreplace({n: n.evalf(17) for n in value.atoms(sp.Rational) if not n.is_Integer})


def write(name, comment, field, left, right):
    """left, right: (exact, source), each a list of components"""
    lines = ["# SPDX-License-Identifier: LGPL-2.1-or-later", "# Copyright (C) 2026 by the Dovetail authors", "#",
             "# Written by manufactured.py: " + comment]
    for side, (exact, source) in (("left", left), ("right", right)):
        exact, source = ("; ".join(str(numbers(sp.sympify(c))).replace("**", "^") for c in part)
                         for part in (exact, source))
        lines += ["subsection Domain " + side, "  subsection Exact", f"    set {field} = {exact}", "  end",
                  "  subsection Source", f"    set {field} = {source}", "  end",
                  "  subsection Boundary condition outer", f"    set Field      = {field}",
                  f"    set Expression = {exact}", "  end", "end", ""]
    folder = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(folder, name + ".prm"), "w", encoding="utf-8") as file:
        file.write("\n".join(lines))


def heat(dim):
    T = sp.sin(3 * x + 2 * y + half) if dim == 2 else sp.sin(2 * x + sp.Rational(3, 2) * y + z + half)
    side = ([T], [sp.simplify(heat_source(T, 1, dim))])
    write(f"exact_heat_{dim}d", f"one smooth temperature, k = 1, {dim}D", "temperature", side, side)


def heat_contrast(k_left, k_right):
    g, t = sp.sin(2 * y + half), sp.cos(3 * y)
    sides = []
    for k in (k_left, k_right):
        T = g + (x - half) * t / k
        sides.append(([T], [sp.expand(heat_source(T, k, 2))]))
    write("exact_heat_contrast", f"k = {k_left} and {k_right}, one trace and one flux at the seam", "temperature",
          *sides)


def elasticity(dim):
    if dim == 2:
        u = [sp.sin(2 * x + 3 * y + half), sp.cos(3 * x - 2 * y)]
    else:
        u = [sp.sin(2 * x + y + z), sp.cos(x - 2 * y + z), sp.sin(x + y + 2 * z + half)]
    side = (u, [sp.expand(b) for b in body_force(linear_elastic(u, 3, 2, dim), dim)])
    write(f"exact_elasticity_{dim}d", f"one smooth displacement, Lame constants 3 and 2, {dim}D", "displacement",
          side, side)


def elasticity_contrast(stiffness_right):
    """Lame constants (3, 2) on the left, a multiple on the right."""
    g, traction = [sp.sin(2 * y + half), sp.cos(2 * y)], [sp.cos(3 * y), sp.sin(2 * y)]
    sides = []
    for factor in (1, stiffness_right):
        lame, mu = 3 * factor, 2 * factor
        D = [(traction[0] - lame * sp.diff(g[1], y)) / (lame + 2 * mu), traction[1] / mu - sp.diff(g[0], y)]
        u = [g[i] + (x - half) * D[i] for i in range(2)]
        sides.append((u, [sp.expand(b) for b in body_force(linear_elastic(u, lame, mu, 2), 2)]))
    write("exact_elasticity_contrast", f"Lame constants (3, 2) and {stiffness_right} times as much", "displacement",
          *sides)


def finite_strain():
    """A plane wave u = a sin(s): F = I + cos(s) a x k depends on s = k.X + 1/2 only, which keeps the formulas short."""
    s, C, a, k = sp.Symbol("s"), sp.Symbol("C"), (sp.Rational(1, 10), sp.Rational(-1, 50)), (2, 3)
    F = sp.eye(3) + sp.Matrix(3, 3, lambda i, j: C * a[i] * k[j] if i < 2 and j < 2 else 0)
    by_C = neo_hookean_of(F, 2, 5).diff(C)
    phase = k[0] * x + k[1] * y + half
    b = [sp.factor(sum(by_C[i, j] * k[j] for j in range(2))).subs(C, sp.cos(phase)) * sp.sin(phase) for i in range(2)]
    side = ([c * sp.sin(phase) for c in a], b)
    write("exact_neo_hookean_2d", "one smooth displacement, neo-Hookean, mu = 2, kappa = 5, plane strain",
          "displacement", side, side)


for dim in (2, 3):
    heat(dim)
    elasticity(dim)
heat_contrast(1, 1000)
elasticity_contrast(1000)
finite_strain()
