# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
"""Exact solutions of the scenes of the stability map, as formulas in x, y (and z): (exact, source)."""

import math


def heat(k, length=1.0, dim=2, skew=0.0):
    """T = g + (x - L) q / k on both sides of the seam x = L, with one trace g and one flux q = k dT/dx; with a skew part of the
    conductivity, K = (k, s; -s, k), the flux is k dT/dx + s dT/dy."""
    if skew:
        return heat_skew(k, skew)
    wave = f"cos(pi*y/{length!r})" + (f"*cos(pi*z/{length!r})" if dim == 3 else "")
    g = f"1 + {wave}/2"
    q = f"({1 / length!r})*(1 + {wave})"
    minus_laplacian = (dim - 1) * math.pi ** 2 / length ** 2  # of the wave
    distance = f"(x - {length!r})"
    exact = f"{g} + {distance}*{q}/({k!r})"
    source = f"{minus_laplacian!r}*{wave}*({k / 2!r} + {distance}*({1 / length!r}))"
    return exact, source


def heat_skew(k, s):
    """T = g + (x - 1) (q - s g')/k with g = 1 + cos(pi y)/2, q = 1 + cos(pi y); a skew part adds nothing to Div(K grad T)."""
    slope = f"(1 + cos(pi*y) + {s / 2!r}*pi*sin(pi*y))/({k!r})"
    source = f"pi^2*({k / 2!r}*cos(pi*y) + (x - 1)*(cos(pi*y) + {s / 2!r}*pi*sin(pi*y)))"
    return f"1 + cos(pi*y)/2 + (x - 1)*{slope}", source


def three(thickness, k):
    """The same trace and flux through three bodies in a row: of each, (exact, source). Trace at x = 1, and what the middle adds."""
    result = []
    offset, x0 = "0", 1.0
    for k_i, begin in zip(k, (1.0, 1.0, 1.0 + thickness)):
        if begin > x0:  # behind the middle body
            offset, x0 = f"{thickness / k[1]!r}*(1 + cos(pi*y))", begin
        distance = f"(x - {begin!r})"
        exact = f"1 + cos(pi*y)/2 + {offset} + {distance}*(1 + cos(pi*y))/({k_i!r})"
        across = 0.5 + (thickness / k[1] if offset != "0" else 0.0)
        result.append((exact, f"pi^2*cos(pi*y)*({k_i * across!r} + {distance})"))
    return result


def pull(load, nu=0.3):
    """(a, b) of u = (a x; b y) for a Saint Venant-Kirchhoff solid of E = 1 under the traction `load` (Newton; small differences exact)."""
    a = load * (1 - nu * nu)
    for _ in range(50):
        a -= ((1 + a) * (a + a * a / 2) - load * (1 - nu * nu)) / (1 + 3 * a + 1.5 * a * a)
    strain = -nu / (1 - nu) * (a + a * a / 2)
    return a, 2 * strain / (1 + math.sqrt(1 + 2 * strain))


def lame(E, nu):
    return E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))


def elastic(E, nu=0.3, length=1.0, unit=1.0):
    """u = g + (x - L) D on both sides of the seam x = L, with one trace g and one traction t; u in units of the length,
    t in those of `unit`."""
    L, M = lame(E, nu)
    p = math.pi / length
    c, s, X = f"cos({p!r}*y)", f"sin({p!r}*y)", f"(x - {length!r})"
    a, b = 0.05 * length, 0.05 * length                  # g = (2a + a c; b s)
    t0, t1, t2 = 0.1 * unit, 0.1 * unit, 0.05 * unit     # t = (t0 + t1 c; t2 s)
    d0, d1 = t0 / (L + 2 * M), (t1 - L * b * p) / (L + 2 * M)
    d2 = t2 / M + a * p                                  # D = (d0 + d1 c; d2 s)
    exact = f"{2 * a!r} + {a!r}*{c} + {X}*({d0!r} + {d1!r}*{c}); {b!r}*{s} + {X}*{d2!r}*{s}"
    # b = -Div sigma
    x0, x1 = -(L * d2 * p + M * (-a * p * p + d2 * p)), M * d1 * p * p
    y0, y1 = -(-(M + L) * d1 * p - (L + 2 * M) * b * p * p), (L + 2 * M) * d2 * p * p
    source = f"({x0!r} + {x1!r}*{X})*{c}; ({y0!r} + {y1!r}*{X})*{s}"
    return exact, source


def elastic_traction(x, E=1.0, nu=0.3):
    """Of the same solution (length and unit one) on a plane of this x, whose normal is (1, 0)."""
    L, M = lame(E, nu)
    p, X, a, b = math.pi, x - 1.0, 0.05, 0.05
    d0, d1, d2 = 0.1 / (L + 2 * M), (0.1 - L * b * p) / (L + 2 * M), 0.05 / M + a * p
    return (f"{(L + 2 * M) * d0!r} + {(L + 2 * M) * d1 + L * (b + X * d2) * p!r}*cos({p!r}*y); "
            f"{M * (d2 - (a + X * d1) * p)!r}*sin({p!r}*y)")


def bending(half_thickness, nu=0.3):
    """A cantilever bent by an end load (Timoshenko), of unit curvature at x = 1; the seam y = 0 carries the largest shear.
    Plane strain."""
    n, ratio, c = nu / (1 - nu), 2 / (1 - nu), half_thickness
    u = f"-x^2*y/2 - {n!r}*y^3/6 + {ratio!r}*(y^3/6 - {c * c / 2!r}*y)"
    v = f"{n!r}*x*y^2/2 + x^3/6"
    return f"{u}; {v}"


def conductivity(decades):
    """k = 10^(m T) with 0 <= T <= 1, growing with the time t from 0 to 1."""
    T = "t*(x/4 + (1 + cos(pi*y))/4)"
    k = f"10^({decades!r}*{T})"
    slope = decades * math.log(10)
    source = (f"-{k}*({slope!r}*(t^2*(1/16 + (pi/4*sin(pi*y))^2)) - t*pi^2/4*cos(pi*y))")
    return T, source


def neo_hookean(strain, mu=2.0, kappa=5.0):
    """A plane wave u = a sin(s), s = k.X + 1/2, so F = I + C a x k with C = cos(s); |a| |k| is the strain."""
    k = (2.0, 1.5)
    a = (strain / 2.5 * 0.8, -strain / 2.5 * 0.6)
    al = a[0] * k[0] + a[1] * k[1]
    kk, beta = 6.25, strain ** 2
    phase = "(2*x + 1.5*y + 0.5)"
    C = f"cos{phase}"
    J = f"(1 + {al!r}*{C})"
    tr = f"(3 + {2 * al!r}*{C} + {beta!r}*{C}^2)"
    trd = f"({2 * al!r} + {2 * beta!r}*{C})"
    # P k = mu J^(-2/3) (k + C |k|^2 a - tr/(3 J) k) + kappa/2 (J - 1/J) k; b = sin(s) d(P k)/dC
    along_k = (f"{mu!r}*({-2 / 3 * al!r}*{J}^(-5/3)*(1 - {tr}/(3*{J})) - {J}^(-2/3)*({trd}/(3*{J}) - {tr}*{al!r}/(3*{J}^2)))"
               f" + {kappa / 2 * al!r}*(1 + 1/{J}^2)")
    along_a = f"{mu!r}*{kk!r}*({-2 / 3 * al!r}*{J}^(-5/3)*{C} + {J}^(-2/3))"
    source = "; ".join(f"sin{phase}*(({along_k})*{k[i]!r} + ({along_a})*{a[i]!r})" for i in (0, 1))
    exact = "; ".join(f"{a[i]!r}*sin{phase}" for i in (0, 1))
    return exact, source


def rotation(degrees):
    """About (1, 1/2), as fast in t as t grows to 1."""
    w = math.radians(degrees)
    c, s = f"(cos({w!r}*t) - 1)", f"sin({w!r}*t)"
    return f"{c}*(x - 1) - {s}*(y - 0.5); {s}*(x - 1) + {c}*(y - 0.5)"
