#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
#
# The pictures and numbers of README.md: runs the scenes, compares with the closed forms, and draws both with gnuplot.
#
#     prm/benchmarks/in_time/figures.py [PROGRAM]      from the top level of the sources; build/release/dovetail by default

import csv
import json
import math
import os
import subprocess
import sys
import tempfile

PROGRAM = sys.argv[1] if len(sys.argv) > 1 else "build/release/dovetail"
HERE = "prm/benchmarks/in_time"


def run(scene, *settings):
    """The rows of probes.csv, and the report."""
    with tempfile.TemporaryDirectory() as directory:
        command = [PROGRAM, "--quiet", "--set", "Output/Directory=" + directory]
        for setting in settings:
            command += ["--set", setting]
        subprocess.run(command + [scene], check=True, stdout=subprocess.DEVNULL)
        rows = []
        table = os.path.join(directory, "probes.csv")
        if os.path.exists(table):
            with open(table, encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
        with open(os.path.join(directory, "report.json"), encoding="utf-8") as file:
            return rows, json.load(file)


def root(function, low, high):
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if (function(low) > 0) == (function(middle) > 0) else (low, middle)
    return low


def bessel(order, x, n=128):
    """By its integral, whose rule of trapezoids converges like a power series."""
    return sum(math.cos(order * a - x * math.sin(a)) for a in (math.pi * (k + 0.5) / n for k in range(n))) / n


BIOT, N_TERMS = 2, 40
SLAB = [root(lambda b: b * math.sin(b) - BIOT * math.cos(b), n * math.pi, (n + 0.5) * math.pi) for n in range(N_TERMS)]
CYLINDER = [root(lambda b: b * bessel(1, b) - BIOT * bessel(0, b), n * math.pi + 1e-9, (n + 0.8) * math.pi)
            for n in range(N_TERMS)]


def slab(x, t):
    return sum(4 * math.sin(b) / (2 * b + math.sin(2 * b)) * math.exp(-b * b * t) * math.cos(b * x) for b in SLAB)


def cylinder(r, t):
    return sum(2 * bessel(1, b) / (b * (bessel(0, b) ** 2 + bessel(1, b) ** 2)) * math.exp(-b * b * t) * bessel(0, b * r)
               for b in CYLINDER)


def chain(x, t):
    r, s = 1 + 0.1 * math.pi ** 2, 3 + 0.2 * math.pi ** 2
    wave = math.cos(math.pi * x)
    return (math.exp(-t) + math.exp(-r * t) * wave,
            (math.exp(-t) - math.exp(-3 * t)) / 2 + (math.exp(-r * t) - math.exp(-s * t)) / (s - r) * wave)


def draw(name, x_label, y_label, curves, more=()):
    """@p curves: (title, points, computed or exact); lines for what is exact, in the colour of what follows."""
    script = ["set terminal pngcairo size 720,420 font 'sans,11'", f"set output '{HERE}/{name}.png'", "set grid lc rgb '#dddddd'",
              f"set xlabel '{x_label}'", f"set ylabel '{y_label}'", "set key outside right top Left reverse", *more]
    colours = ["#1f6fb4", "#c8502a", "#3a8f4a", "#7a4fa3"]
    plots = []
    for i, (title, exact, computed) in enumerate(curves):
        for kind, points in (("exact", exact), ("computed", computed)):
            script += [f"${kind}{i} << EOD"] + ["\n".join(f"{x} {y}" if x is not None else "" for x, y in points), "EOD"]
        plots += [f"$exact{i} with lines lw 1.5 lc rgb '{colours[i]}' notitle"] if exact else []
        plots += [f"$computed{i} with points pt 7 ps 0.7 lc rgb '{colours[i]}' title '{title}'"]
    script.append("plot " + ", ".join(plots))
    subprocess.run(["gnuplot"], input="\n".join(script), text=True, check=True)


def imbalance(row, bodies, field):
    """Of a step, the largest of the bodies over what flows through the one that most flows through."""
    def of(what):
        return max(abs(float(row[f"balance {body} {field} {what}"])) for body in bodies)
    return of("imbalance") / max(of("in"), of("out"), of("stored"))


def largest(exact, computed):
    return max(abs(a - b) for (_, a), (_, b) in zip(exact, computed))


def column(rows, name):
    return [(float(row["time"]), float(row[name])) for row in rows]


def quench(name, series, end):
    rows, _ = run(f"tests/scenes/thermal/{name}.prm")
    curves, worst = [], 0
    for probe, place in (("middle", 0), ("seam", 0.6), ("surface", 1)):
        computed = column(rows, probe)
        curves.append((probe, [(t, series(place, t)) for t in (end * 10 ** (-k / 80) for k in range(201))],
                       [(t, T) for t, T in computed if t > end / 320][::3]))
        worst = max(worst, largest([(t, series(place, t)) for t, _ in computed if t > 0.1 * end],
                                   [(t, T) for t, T in computed if t > 0.1 * end]))
    draw(name, "time", "temperature", curves, ("set logscale x", f"set xrange [{end / 320}:{end}]"))
    print(name, len(rows), "steps, largest difference after a tenth of the time", worst,
          "imbalance", max(imbalance(row, ("core", "shell"), "temperature") for row in rows))


def self_similar():
    curves = []
    for steps in (5, 10, 20):
        rows, report = run(f"{HERE}/self_similar.prm", f"Steps/Number of steps={steps}")
        print("self-similar", steps, [report["domains"][d]["errors"]["temperature"]["L2"] for d in ("left", "right")])
        for row in rows if steps == 20 else ():
            t = float(row["time"])
            if min(abs(t - 0.25), abs(t - 1)) < 1e-9:
                curves.append((f"t = {1 + t:g}", [(x / 100, math.sqrt(1 - x / 100 / math.sqrt(1 + t))) for x in range(91)],
                               [(int(name[1:]) / 100, float(value)) for name, value in row.items() if name[0] == "x"]))
    draw("self_similar", "x", "temperature", curves)


def laminate():
    curves = []
    for title, resistance, settings in (("tied", 0, ()),
                                        ("with resistance", 0.25, ("Interface seam/Type=contact resistance",
                                                                   "Interface seam/Conductance=4"))):
        _, report = run(f"{HERE}/laminate.prm", *settings)
        flux = 1 / (0.5 / 2 + 3 * 0.5 / 5 + resistance)
        exact = [(0, 1), (0.5, 1 - flux * 0.25), (None, None), (0.5, flux * 0.1), (1, 0)]
        values = report["probes"]
        computed = [((0.1 if n[0] == "l" else 0.1) * int(n[1]) + (0.5 if n[0] == "r" else 0), values[n])
                    for n in values if n[0] in "lr" and n[1:].isdigit()]
        curves.append((title, exact, computed))
        exact_at = [1 - flux * x / 2 if name == "l" else flux * (1 - x) / 5
                    for name, x in ((n[0], x) for n, (x, _) in zip([m for m in values if m[1:].isdigit()], computed))]
        print("laminate", title, "flux", values["in"] / flux - 1, "largest error",
              max(abs(a - b) for a, (_, b) in zip(exact_at, computed)))
    draw("laminate", "x", "concentration", curves)


def chain_reaction():
    errors = []
    for steps in (20, 40, 80):
        rows, report = run(f"{HERE}/chain_reaction.prm", f"Steps/Number of steps={steps}")
        errors.append([report["domains"][d]["errors"][f]["L2"] for d in ("left", "right") for f in ("a", "b")])
        if steps == 20:
            curves = []
            for side, x in (("left", 0.2), ("right", 0.8)):
                for i, species in enumerate(("a", "b")):
                    curves.append((f"{species}, x = {x}", [(k / 100, chain(x, k / 100)[i]) for k in range(101)],
                                   column(rows, f"{species} {side}")))
            draw("chain_reaction", "time", "concentration", curves)
    print("chain reaction", errors)


DYNAMICS = "tests/scenes/dynamics"


def oscillating_bar():
    rows, _ = run(f"{DYNAMICS}/oscillation_base.prm")
    total = [sum(float(row[f"energy {part}"]) for part in ("kinetic", "elastic", "ties")) for row in rows]
    print("oscillating bar", max(abs(energy / total[0] - 1) for energy in total))
    exact = [k / 25 for k in range(201)]
    energy = 3 * 0.2 * (math.pi / 2) ** 2 / 4
    draw("oscillating_bar", "time", "energy",
         [("kinetic", [(t, energy * math.sin(math.pi * t / 2) ** 2) for t in exact], column(rows, "energy kinetic")[:40]),
          ("elastic", [(t, energy * math.cos(math.pi * t / 2) ** 2) for t in exact], column(rows, "energy elastic")[:40]),
          ("kinetic + elastic + ties", [(0, energy), (8, energy)],
           [(float(row["time"]), sum_) for row, sum_ in zip(rows, total)][:40])])


def impact():
    rows, _ = run(f"{DYNAMICS}/impact.prm")
    draw("impact", "time", "mean velocity",
         [("first bar", [(0, 1), (2, 0), (3, 0)], column(rows, "first x")[4::10]),
          ("second bar", [(0, 0), (2, 1), (3, 1)], column(rows, "second x")[4::10])])
    print("impact", rows[-1]["first x"], rows[-1]["second x"])


def stefan():
    curves = []
    for cells, steps, width, name in ((9, 50, 0.01, "cells of 0.02"), (18, 100, 0.005, "cells of 0.01")):
        conductivity = f"Material ice/Heat/Conductivity=2 - min(1, max(0, (T + {width})/{2 * width}))"
        rows, _ = run("tests/scenes/thermal/stefan.prm", f"Steps/Number of steps={steps}", conductivity,
                      f"Material ice/Heat/Solidus={-width}", f"Material ice/Heat/Liquidus={width}",
                      f"Domain left/Mesh/Arguments={cells}, 2 : 0, 0 : 0.18, 0.1 : true")
        front = [(float(row["time"]), 10 * (float(row["melt left"]) + float(row["melt right"]))) for row in rows]
        end = front[-1][0]
        curves.append((name, [(end * k / 100, 2 * 0.4419891645 * math.sqrt(end * k / 100)) for k in range(101)],
                       front[1::len(front) // 25]))
        print("Stefan", name, "front", front[-1][1] / (2 * 0.4419891645 * math.sqrt(end)))
    draw("stefan", "time", "place of the front", curves)


def brake():
    rows, _ = run("tests/scenes/thermal/brake.prm", "Interface outer/Type=contact resistance", "Interface outer/Conductance=5e3")
    names = ("disc", "inner pad", "outer pad")
    heats = {name: [(t, 2e6 * T) for t, T in column(rows, name)] for name in names}
    total = [(t, sum(heats[name][i][1] for name in names)) for i, (t, _) in enumerate(heats["disc"])]
    exact = [(t, 12e6 * 1.45196e-4 * (t - t * t / 8)) for t in (k / 25 for k in range(101))]
    draw("brake", "time [s]", "heat [J]", [("all bodies", exact, total[3::4]), ("disc", [], heats["disc"][3::4]),
                                           ("one pad", [], heats["inner pad"][3::4])])
    print("brake", total[-1][1], "of", exact[-1][1])


def arch():
    """Crown and load of doc/theory/arc_length.md, formula (2)."""
    H, h, E = 0.05, 0.015, 1e4
    path = []
    for i in range(50, 6000):  # sums cancel at smaller k
        k = 6 * i / 6000
        cot, share = 1 / math.tan(k), k * math.sin(k)
        I1 = 2 / 3 - 2 / k ** 2 + 2 * cot / k
        I2 = 2 / 3 - 4 / k ** 2 + 4 * cot / k + (1 - math.sin(2 * k) / (2 * k)) / math.sin(k) ** 2
        root_of = (H * I1) ** 2 - I2 * k * k * h * h / 12
        for sign in (-1, 1) if root_of >= 0 else ():
            beta = 2 * (H * I1 + sign * math.sqrt(root_of)) / I2
            crown = beta * (1 / share - cot / k - 0.5)
            if -0.09 < crown < 0:
                path.append((-crown, k * k * E * h ** 3 / 12 * (2 * H - beta)))
    rows, _ = run("tests/scenes/arc_length/arch.prm")
    computed = [(-float(row["crown y"]), float(row["time"])) for row in rows]
    draw("snap_through", "the crown sinks by", "load t", [("arch of two tied parts", sorted(path), computed)])
    print("snap through, limit point", max(t for _, t in computed), max(t for crown, t in path if crown < 0.03))


os.makedirs("output", exist_ok=True)
quench("quenched_slab", slab, 0.4)
quench("quenched_cylinder", cylinder, 0.2)
self_similar()
laminate()
chain_reaction()
stefan()
oscillating_bar()
impact()
brake()
arch()
