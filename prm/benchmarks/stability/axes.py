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
    small: values of the small map; measure: the error of the bodies that counts; with_flux: whether the flux is judged; interfaces: those
    that the tie is given to; reference(value): where no solution is known in closed form, (probe, component, its value), of which the
    error may be 1 %; rounding(value): relative errors below it count as none; cancellation(value): how much larger the flux in the
    bodies is than that through the seam, against the benign end."""

    def __init__(self, name, title, scene, values, benign, entries, small=(), ties=None, label="", log=True,
                 measure="energy", spectrum=True, field="temperature", with_flux=True, interfaces=("seam",), reference=None,
                 rounding=lambda value: 1e-6, cancellation=lambda value: 1.0):
        self.name, self.title, self.scene, self.values, self.benign = name, title, scene, values, benign
        self.entries, self.small, self.ties, self.label, self.log = entries, small, ties or list(ALL), label, log
        self.measure, self.spectrum, self.field = measure, spectrum, field
        self.with_flux, self.interfaces, self.reference = with_flux, interfaces, reference
        self.rounding, self.cancellation = rounding, cancellation


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


def skewed(s):
    """Whirling one way on the left and the other way on the right; the skew part lets heat through free sides, so they are prescribed."""
    entries = {}
    for domain, sign in (("left", 1.0), ("right", -1.0)):
        entries[f"Material of {domain}/Heat/Conductivity"] = f"1; {sign * s!r}; {-sign * s!r}; 1"
        entries.update(body(domain, "temperature", None, exact.heat(1.0, skew=sign * s), ["end"]))
        entries[f"Domain {domain}/Boundary condition end/Boundary ids"] = "0, 2, 3" if domain == "left" else "1, 2, 3"
    return entries


def coat(physics, ratio, degree):
    """The right body is one cell thick, and its cells are `ratio` times as long as thick. The flux through its outer side is given: a
    prescribed value would be an equation for the flux of a thin body with the rounding and the interpolation of the other one."""
    end = 1.0 + 1.0 / 9 / ratio
    entries = squares(physics)
    entries["Domain right/Mesh/Arguments"] = box(1, 9, 1.0, 0.0, end, 1.0)
    for domain in ("left", "right"):
        entries[f"Domain {domain}/Degree"] = str(degree)
    entries["Domain right/Boundary condition end/Type"] = "flux"
    entries["Domain right/Boundary condition end/Expression"] = (
        "1 + cos(pi*y)" if physics == "heat" else exact.elastic_traction(end))
    return entries


def three(thickness, k):
    entries = {"Domain middle/Mesh/Arguments": box(1, 9, 1.0, 0.0, 1.0 + thickness, 1.0),
               "Domain right/Mesh/Arguments": box(7, 7, 1.0 + thickness, 0.0, 2.0 + thickness, 1.0)}
    for domain, k_i, solution in zip(("left", "middle", "right"), k, exact.three(thickness, k)):
        entries[f"Material of {domain}/Heat/Conductivity"] = repr(k_i)
        entries.update(body(domain, "temperature", None, solution, [] if domain == "middle" else ["end"]))
    return entries


def chain(n):
    """Bodies 0 … n-1; the scene has the first two of them, of which the second becomes the last."""
    entries = {"Domains": ", ".join(f"body {i}" for i in range(n)),
               "Interfaces": ", ".join(["seam"] + [f"seam {i}" for i in range(1, n - 1)])}
    solution = "0.01*x; -0.01*0.3/0.7*y"
    for i in range(1, n):
        own = f"Domain body {i}/"
        entries[own + "Mesh/Generator"] = "subdivided_hyper_rectangle"
        cells = 2 + i % 2
        entries[own + "Mesh/Arguments"] = box(cells, cells, float(i), 0.0, i + 1.0, 1.0)
        entries[own + "Material"] = "of all"
        entries[own + "Exact/displacement"] = solution
        # the scene has a second body that is pulled; where it is not the last one, nothing acts on its free side
        conditions = {"floor": ("value", "2", "0")}
        if i in (1, n - 1):
            conditions["pulled"] = ("flux", "1", "0.01; 0") if i == n - 1 else ("flux", "3", "0; 0")
        entries[own + "Boundary conditions"] = ", ".join(conditions)
        for name, (kind, ids, expression) in conditions.items():
            condition = own + f"Boundary condition {name}/"
            entries.update({condition + "Type": kind, condition + "Field": "displacement", condition + "Boundary ids": ids,
                            condition + "Expression": expression})
        entries[own + "Boundary condition floor/Components"] = "y"
        if i > 1:
            seam = f"Interface seam {i - 1}/"
            entries.update({seam + "Type": "Nitsche", seam + "Source": f"body {i - 1} : 1", seam + "Destination": f"body {i} : 0"})
    return entries


def pull(load, course="t", steps=1):
    """course: of the load in time, with its value at t = 1."""
    text, at_end = {"t": ("t", 1), "held": ("if(t < 0.5, 2*t, 1)", 1), "unloaded": ("if(t < 0.5, 2*t, 2 - 2*t)", 0)}[course]
    a, b = exact.pull(load * at_end)
    entries = {"Domain right/Boundary condition pull/Expression": f"{load!r}*{text}; 0", "Steps/Number of steps": str(steps)}
    for domain in ("left", "right"):
        entries[f"Domain {domain}/Exact/displacement"] = f"{a!r}*x; {b!r}*y"
    return entries


# Force on the top of the rubber alone, of the same mesh, whose faces are held and moved: seal.prm without its plates [N/mm]
FORCE_OF_RUBBER = {0.1: -29.03974721, 0.3: -115.27256427, 0.5: -273.93594149}


def seal(strain, steps):
    return {"Domain lid/Boundary condition press/Expression": f"0; {-8 * strain!r}*t", "Steps/Number of steps": str(steps)}


def decades(first, last, step=1):
    return [10.0 ** e for e in range(first, last + 1, step)]


def bending_rounding(ratio):
    """The condition number of a thin beam grows like the fourth power of length over thickness."""
    return max(1e-6, 2e-15 * ratio ** 4)


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
         layers, small=(1000.0,), label="length / thickness", field="displacement", rounding=bending_rounding),
    Axis("matching_layers", "The same on matching meshes", "layers", [10.0, 100.0, 1000.0], 10.0,
         lambda ratio: layers(ratio, (12, 12)), ties=FEW, label="length / thickness", field="displacement", rounding=bending_rounding),
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

TEMPERATURES = [-7.0, -1.0, 0.0, 0.5, 1.0, 7.0]
AXES += [
    Axis("skew", "Skew part of the conductivity, of opposite sign on the two sides", "heat", [0.0, 0.1, 1.0, 3.0, 10.0], 0.0, skewed,
         small=(3.0,), label="s / k", log=False, cancellation=lambda s: math.sqrt(1 + s * s)),
    Axis("first_guess", "First guess of the temperature, k(T) over three decades", "conductivity", TEMPERATURES, 0.5,
         lambda T: {f"Domain {domain}/Initial/temperature": repr(T) for domain in ("left", "right")}, small=(7.0,),
         label="first guess; the solution lies between 0 and 1", log=False, ties=FEW, spectrum=False),
    Axis("middle", "One cell between two ties: its thickness", "three", [1.0, 0.1, 1e-2, 1e-4, 1e-6], 0.1,
         lambda d: three(d, (1.0, 10.0, 0.1)), small=(1e-6,), label="thickness", ties=FEW, spectrum=False,
         interfaces=("seam", "second seam")),
    Axis("middle_contrast", "One cell between two ties: its conductivity", "three", decades(-6, 6, 3), 1.0,
         lambda k: three(0.1, (1.0, k, 1.0)), small=(1e-6,), label="k of the middle", ties=FEW, spectrum=False,
         interfaces=("seam", "second seam")),
    Axis("corner", "Partly covered sides with prescribed corners: the right body is moved by", "corner",
         [0.5, 0.3, 0.1, 1e-2, 1e-4, 1e-6], 0.5, lambda shift: {"Domain right/Mesh/Shift": f"0; {shift!r}"}, small=(1e-4,),
         label="shift", log=False, spectrum=False, measure="H1"),
    Axis("rim", "An edge that is curved within the interface: degree", "rim", [1, 2, 3], 1,
         lambda p: {f"Domain {domain}/Degree": str(p) for domain in ("block", "plate")}, small=(2,), label="degree", log=False,
         ties=FEW, spectrum=False),
    Axis("chain", "Bodies in a chain", "chain", [2, 5, 20, 50, 200], 2, chain, small=(20,), label="bodies", ties=FEW, spectrum=False,
         field="displacement"),
    Axis("load", "Load over Young modulus, Saint Venant-Kirchhoff", "pull", decades(-12, 0, 2), 1e-2, pull, small=(1e-12,),
         label="load / E", ties=FEW, spectrum=False, field="displacement"),
    Axis("load_neo_hookean", "Neo-Hookean, plane wave: strain", "neo_hookean", [1e-6, 1e-4, 1e-2, 0.05, 0.5], 0.05, neo_hookean,
         small=(1e-6,), label="strain", ties=FEW, spectrum=False, field="displacement"),
]
for name, words, n_steps in (("seal", "10 steps", 10), ("seal_one_step", "one step that may be halved", 1)):
    AXES.append(Axis(name, f"A rubber seal between steel plates in {words}: it is squeezed by", "seal", [0.1, 0.3, 0.5], 0.1,
                     lambda strain, n=n_steps: seal(strain, n), small=(0.3,), label="part of its height", log=False, ties=FEW,
                     spectrum=False, field="displacement", interfaces=("lower bond", "upper bond"),
                     reference=lambda strain: ("force", 1, FORCE_OF_RUBBER[strain])))
for course in ("t", "held", "unloaded"):
    AXES.append(Axis("steps_" + {"t": "growing"}.get(course, course), f"Number of steps; the load is {'growing' if course == 't' else course}",
                     "pull", [2, 10, 100, 1000], 2, lambda n, c=course: pull(1e-2, c, n), small=(10,), label="steps", ties=FEW,
                     spectrum=False, field="displacement"))
for physics, field in (("heat", "temperature"), ("elastic", "displacement")):
    for degree in (1, 2, 3, 4):
        AXES.append(Axis(f"aspect_{physics}_degree_{degree}", f"Length over thickness of the interface cells of one side, degree {degree}", physics,
                         decades(0, 8, 2), 1.0, lambda r, p=physics, d=degree: coat(p, r, d), small=(1e8,), ties=FEW, spectrum=False,
                         label="length / thickness", field=field))


def joint_stiffness(axis, value):
    """As good as tied, in units of the softer body and of the cells."""
    length = value if axis.name.startswith("units") else 1.0
    softer = min(1.0, value) if axis.name.startswith(("contrast", "multigrid", "middle_contrast")) else 1.0
    return repr(VERY_STIFF * softer / length)


def entries_of_tie(axis, name, value):
    """Full paths; the joint of a contact resistance follows the units of the axis."""
    interfaces = axis.interfaces
    if axis.name == "chain":
        interfaces = ["seam"] + [f"seam {i}" for i in range(1, value - 1)]
    entries = {f"Interface {interface}/{entry}": str(text) for interface in interfaces for entry, text in ALL[name].items()}
    if name == "contact resistance":
        joint = "Conductance" if axis.field == "temperature" else "Joint stiffness"
        entries.update({f"Interface {interface}/{joint}": joint_stiffness(axis, value) for interface in interfaces})
    return entries
