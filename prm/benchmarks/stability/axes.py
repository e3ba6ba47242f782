# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
"""What the stability map varies: ties and axes. A case is a scene and the entries that replace those in it."""

import math

import exact

SEAM = "Interface seam/"


def nitsche(theta, side="source", quadrature="segments"):
    return {"Type": "Nitsche", "Theta": theta, "Integrate on": side, "Quadrature": quadrature}


SIDES = ("source", "destination", "both", "own sides")
QUADRATURES = ("segments", "mapped points")

# every tie: name -> entries of the interface
ALL = {f"θ = {theta}, {side}, {quadrature}": nitsche(theta, side, quadrature)
       for quadrature in QUADRATURES for side in SIDES for theta in (1, 0, -1)}
ALL["contact resistance"] = {"Type": "contact resistance"}  # the axes set how stiff it is
ALL["mortar, dual"] = {"Type": "mortar", "Multiplier space": "dual"}
ALL["mortar, standard"] = {"Type": "mortar", "Multiplier space": "standard"}
ALL["pointwise"] = {"Type": "pointwise"}

FEW = ["θ = 1, source, segments", "θ = 0, source, segments", "θ = -1, source, segments", "θ = 1, own sides, mapped points",
       "contact resistance", "mortar, dual", "mortar, standard", "pointwise"]
NITSCHE = [name for name in ALL if name.startswith("θ")]
VERY_STIFF = 1e8  # times k / L: a joint that is as good as tied


class Axis:
    """values: what is varied; benign: the value the others are compared with; entries(value): entries of the scene;
    small: values of the small map; measure: the error of the bodies that counts; allowed: how many times that of the benign
    value it may be; with_flux: whether the flux is judged."""

    def __init__(self, name, title, scene, values, benign, entries, small=(), ties=None, label="", log=True,
                 measure="energy", spectrum=True, field="temperature", allowed=2.0, with_flux=True):
        self.name, self.title, self.scene, self.values, self.benign = name, title, scene, values, benign
        self.entries, self.small, self.ties, self.label, self.log = entries, small, ties or list(ALL), label, log
        self.measure, self.spectrum, self.field = measure, spectrum, field
        self.allowed, self.with_flux = allowed, with_flux


def box(nx, ny, x0, y0, x1, y1):
    return f"{nx}, {ny} : {x0!r}, {y0!r} : {x1!r}, {y1!r} : true"


def body(domain, field, mesh, solution, conditions):
    """Entries of a body; solution: (exact, source)."""
    entries = {f"Domain {domain}/Mesh/Arguments": mesh} if mesh else {}
    entries[f"Domain {domain}/Exact/{field}"] = solution[0]
    if solution[1] is not None:
        entries[f"Domain {domain}/Source/{field}"] = solution[1]
    for condition in conditions:
        entries[f"Domain {domain}/Boundary condition {condition}/Expression"] = solution[0]
    return entries


def squares(physics, k=(1.0, 1.0), n=(6, 9), length=1.0, gap=0.0, across=None):
    """heat.prm or elastic.prm with other moduli and meshes."""
    entries = {}
    for side, domain in enumerate(("left", "right")):
        x0 = length * side + (gap if side else 0.0)
        mesh = box((across or n)[side], n[side], x0, 0.0, x0 + length, length)
        if physics == "heat":
            entries[f"Material of {domain}/Heat/Conductivity"] = repr(k[side])
            entries.update(body(domain, "temperature", mesh, exact.heat(k[side], length), ["end"]))
        else:
            entries[f"Material of {domain}/Solid/Young modulus"] = repr(k[side])
            entries.update(body(domain, "displacement", mesh, exact.elastic(k[side], 0.3, length), ["end"]))
    if gap:
        entries[SEAM + "Search radius"] = "0.5"
    return entries


def sizes(physics, ratio):
    """The finer side is refined towards the seam; its cells there are squares."""
    entries = squares(physics, n=(3, 3))
    if ratio != 1:
        domain, seam = ("right", "0") if ratio > 1 else ("left", "1")
        entries[f"Domain {domain}/Mesh/Refine at boundary ids"] = seam
        entries[f"Domain {domain}/Mesh/Local refinements"] = str(round(abs(math.log2(ratio))))
    return entries


def cubes(k=(1.0, 1.0)):
    entries = {}
    for side, domain in enumerate(("left", "right")):
        entries[f"Material of {domain}/Heat/Conductivity"] = repr(k[side])
        entries.update(body(domain, "temperature", None, exact.heat(k[side], 1.0, 3), ["end"]))
    return entries


def slivers(physics, part):
    """The right body is larger and its faces are those of the left one, moved by a part of their size."""
    n = 6
    h = 1.0 / n
    y0 = -h + part * h
    entries = squares(physics, n=(n, n))
    entries["Domain right/Mesh/Arguments"] = box(n, n + 2, 1.0, y0, 2.0, y0 + (n + 2) * h)
    field = "temperature" if physics == "heat" else "displacement"
    solution = exact.heat(1.0)[0] if physics == "heat" else exact.elastic(1.0)[0]
    condition = "Domain right/Boundary condition"
    if physics == "heat":
        flux = "-(1 + cos(pi*y))"
    else:
        flux = "-(0.1 + 0.1*cos(pi*y)); -0.05*sin(pi*y)"
        for entry, value in (("Boundary ids", "1"), ("Components", "x, y")):
            entries[f"{condition} rollers/{entry}"] = value
        entries[f"{condition} rollers/Expression"] = solution
        entries[f"{condition} rollers/Boundary ids"] = "2, 3"
    entries["Domain right/Boundary conditions"] = "end, outside" + (", rollers" if physics != "heat" else "")
    if physics == "heat":
        entries[f"{condition} end/Boundary ids"] = "1, 2, 3"
    entries.update({f"{condition} outside/Type": "flux", f"{condition} outside/Field": field,
                    f"{condition} outside/Boundary ids": "0", f"{condition} outside/Expression": flux})
    return entries


def layers(ratio, cells=(8, 12)):
    c = 1.0 / ratio
    entries = {}
    for domain, n, y0 in (("lower", cells[0], -c), ("upper", cells[1], 0.0)):
        entries.update(body(domain, "displacement", box(n, 1, 0.0, y0, 1.0, y0 + c), (exact.bending(c), None), ["ends"]))
    return entries


def both(field, solution, conditions):
    return {**body("left", field, None, solution, conditions[0]), **body("right", field, None, solution, conditions[1])}


def conductivity(decades):
    return {"Material of both/Heat/Conductivity": f"10^({decades!r}*T)",
            **both("temperature", exact.conductivity(decades), (["end"], ["end"]))}


def neo_hookean(strain):
    return both("displacement", exact.neo_hookean(strain), (["outer"], ["outer"]))


def rotation(degrees, steps):
    entries = both("displacement", (exact.rotation(degrees), None), (["end"], []))
    entries["Steps/Adaptive"] = "true"
    entries["Steps/Number of steps"] = str(steps)
    return entries


def decades(first, last, step=1):
    return [10.0 ** e for e in range(first, last + 1, step)]


CONTRASTS = [1e-10, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e10]

AXES = []
for physics, field in (("heat", "temperature"), ("elastic", "displacement")):
    words = {"heat": "conductivity", "elastic": "stiffness"}[physics]

    def add(name, title, values, benign, entries, **more):
        AXES.append(Axis(f"{name}_{physics}", title, physics, values, benign, entries, field=field, **more))

    for n in ((6, 9), (9, 6)):
        finer = "destination" if n[1] > n[0] else "source"
        add(f"contrast_{finer}_finer", f"Contrast of {words}, destination to source; {n[0]} faces of the source on {n[1]}",
            CONTRASTS, 1.0, lambda c, n=n, p=physics: squares(p, (1.0, c), n), small=(1e-10, 1.0, 1e10),
            label="k of the destination / k of the source")
    add("multigrid", f"Contrast of {words}, solved by multigrid; 32 faces of the source on 48", decades(-8, 8, 4), 1.0,
        lambda c, p=physics: {**squares(p, (1.0, c), (32, 48)), "Linear solver/Type": "multigrid"}, ties=FEW, spectrum=False,
        label="k of the destination / k of the source")
    add("size", "Size of the faces at the seam, source to destination; 3 faces on the coarse side",
        [1 / 64, 1 / 8, 1.0, 8.0, 64.0], 1.0, lambda r, p=physics: sizes(p, r), small=(1 / 64, 64.0),
        label="size of a face, source / destination", spectrum=False)
    add("slivers", "Slivers: part of a face that faces another one", [0.5, 1e-3, 1e-6, 1e-9], 0.5,
        lambda part, p=physics: slivers(p, part), small=(1e-9,), label="sliver / face")
    add("penalty", "Penalty, in units of the automatic one", [1e-3, 0.1, 0.4, 1.0, 10.0, 1e3, 1e6], 1.0,
        lambda f, p=physics: {**squares(p), SEAM + "Multiplier": repr(2 * f)}, small=(1e-3, 0.1, 1e6), ties=NITSCHE,
        label="γ / automatic γ")
    add("gap", "Sides that nearly touch (> 0) or overlap (< 0), in units of the body",
        [-1e-3, -1e-6, -1e-12, 0.0, 1e-12, 1e-6, 1e-3], 0.0, lambda g, p=physics: squares(p, gap=g),
        small=(-1e-3, 1e-9), label="gap", log=False, ties=FEW)
    add("units", "Unit of length: one body measures", decades(-9, 3, 3), 1.0,
        lambda L, p=physics: squares(p, (1.0, 1e3), length=L), small=(1e-9,), label="length", ties=FEW)

AXES += [
    Axis("contrast_heat_3d", "Contrast of conductivity in 3D, destination to source; 4 x 4 faces on 6 x 6", "heat_3d",
         decades(-10, 10, 5), 1.0, lambda c: cubes((1.0, c)), small=(1e10,), ties=FEW, spectrum=False,
         label="k of the destination / k of the source"),
    Axis("layers", "Two tied layers in bending: length to thickness of a layer", "layers", [10.0, 100.0, 1000.0], 10.0,
         layers, small=(1000.0,), label="length / thickness", field="displacement", allowed=10.0, with_flux=False),
    Axis("matching_layers", "The same on matching meshes", "layers", [10.0, 100.0, 1000.0], 10.0,
         lambda ratio: layers(ratio, (12, 12)), ties=FEW, label="length / thickness", field="displacement",
         allowed=10.0, with_flux=False),
    Axis("conductivity", "Conductivity k(T) over m decades, one step, halved if it does not converge", "conductivity",
         [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 0.0, conductivity, small=(6.0,), label="m", log=False, ties=FEW, spectrum=False),
    Axis("neo_hookean", "Neo-Hookean, one step: strain", "neo_hookean", [0.05, 0.25, 0.5], 0.05, neo_hookean,
         small=(0.5,), label="strain", log=False, field="displacement", spectrum=False),
    Axis("rotation", "Rigid rotation, held at one end, by 20 degrees a step", "rotation", [20, 60, 90, 120, 180], 20,
         lambda degrees: rotation(degrees, max(1, degrees // 20)), small=(180,), label="degrees", log=False, measure="H1",
         field="displacement", spectrum=False, ties=FEW),
    Axis("rotation_one_step", "Rigid rotation, held at one end, in one step that may be halved", "rotation", [20, 60, 90, 120, 180], 20,
         lambda degrees: rotation(degrees, 1), label="degrees", log=False, measure="H1", field="displacement", spectrum=False,
         ties=FEW),
]


def entries_of_tie(axis, name, value):
    """Full paths; the joint of a contact resistance follows the units of the axis."""
    entries = {SEAM + entry: str(text) for entry, text in ALL[name].items()}
    if name == "contact resistance":
        length = value if axis.name.startswith("units") else 1.0
        softer = min(1.0, value) if axis.name.startswith(("contrast", "multigrid")) else 1.0
        stiffness = repr(VERY_STIFF * softer / length)
        if axis.field == "temperature":
            entries[SEAM + "Conductance"] = stiffness
        else:
            entries[SEAM + "Joint stiffness"] = stiffness
    return entries
