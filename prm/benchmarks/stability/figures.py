# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
"""Tables (Markdown) and pictures (gnuplot) of the stability map."""

import collections
import math
import os
import re
import shutil
import subprocess

import axes as map_axes
import judge

PANELS = (("error", "relative error in energy", True), ("flux", "relative error of the flux", True),
          ("oscillation", "oscillation of the flux", True), ("eigenvalue", "smallest eigenvalue, scaled", True),
          ("condition", "condition number", True), ("linear", "linear iterations", False), ("newton", "Newton iterations", False))
SHORT = {"not converged": "no convergence", "message": "message", "CRASH": "CRASH"}
MARKS = {"right": "", "flux lost": " flux lost", "warned": " (noted)", "WRONG": " WRONG", "CRASH": " CRASH"}


def number(value):
    if not judge.is_finite(value):
        return "–"
    return f"{value:.1e}" if value != 0 and not 1e-2 <= abs(value) < 1e3 else f"{value:.2g}"


def title_of(value):
    if value == 0 or 0.01 <= abs(value) <= 999:
        return f"1/{round(1 / value)}" if 0 < value < 0.13 and abs(1 / value - round(1 / value)) < 1e-9 and value > 0.011 \
            and round(1 / value) not in (10, 20) else f"{value:g}"
    return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")


def cell(case):
    if case is None:
        return ""
    if case["verdict"] in SHORT and "error" not in case or case["status"] != "converged":
        return SHORT.get(case["verdict"], case["verdict"])
    return f"{number(case['error'])} / {number(case['flux'])}{MARKS[case['verdict']]}"


def span(cases, name):
    found = [case[name] for case in cases if case and judge.is_finite(case.get(name))]
    if not found:
        return "–"
    low, high = number(min(found)), number(max(found))
    return low if low == high else f"{low}…{high}"


def range_cell(cases):
    cases = [case for case in cases if case]
    if not cases:
        return ""
    good = [case for case in cases if case["status"] == "converged"]
    words = collections.Counter(case["verdict"] for case in cases if case["verdict"] != "right")
    text = f"{span(good, 'error')} / {span(good, 'flux')}" if good else ""
    return text + "".join(f"; {count} of {len(cases)} {word}" for word, count in words.items())


def by_place(axis, cases):
    return {(case["tie"], case["value"]): case for case in cases if case["axis"] == axis.name}


def table(axis, cases):
    """Energy / flux for some ties one by one, and the range over the others."""
    found = by_place(axis, cases)
    values = [value for value in axis.values if any(place[1] == value for place in found)]
    lines = ["| " + axis.label + " | " + " | ".join(title_of(value) for value in values) + " |",
             "|---" * (len(values) + 1) + "|"]
    for tie in map_axes.FEW:
        if tie in axis.ties and any(place[0] == tie for place in found):
            lines.append(f"| {tie} | " + " | ".join(cell(found.get((tie, value))) for value in values) + " |")
    for quadrature in map_axes.QUADRATURES:
        rest = [tie for tie in axis.ties if tie.endswith(quadrature) and any(place[0] == tie for place in found)]
        if len(rest) > 3:
            lines.append(f"| all {len(rest)} of Nitsche, {quadrature} | "
                         + " | ".join(range_cell([found.get((tie, value)) for tie in rest]) for value in values) + " |")
    return "\n".join(lines)


def judged(axis):
    if axis.reference is not None:
        return "a probe"
    return axis.measure + (", flux" if axis.with_flux else "; the flux is not judged")


def verdicts(all_axes, cases):
    """How many runs of each axis ended how."""
    names = ["right", "flux lost", "warned", "not converged", "message", "WRONG", "CRASH"]
    lines = ["| axis | judged | runs | " + " | ".join(names) + " |", "|---" * (len(names) + 3) + "|"]
    for axis in all_axes:
        of_axis = [case["verdict"] for case in cases if case["axis"] == axis.name]
        if of_axis:
            lines.append(f"| {axis.name} | {judged(axis)} | {len(of_axis)} | " + " | ".join(str(of_axis.count(name) or "") for name in names) + " |")
    total = [case["verdict"] for case in cases]
    lines.append(f"| all | | {len(total)} | " + " | ".join(str(total.count(name) or "") for name in names) + " |")
    return "\n".join(lines)


def thetas(all_axes, cases):
    """What theta changes: medians and worst over all sides and quadratures of each axis."""
    lines = ["| axis | " + " | ".join(f"θ = {theta}: not right, worst energy / flux" for theta in (1, 0, -1)) + " |", "|---" * 4 + "|"]
    for axis in all_axes:
        row = []
        for theta in (1, 0, -1):
            of_theta = [case for case in cases if case["axis"] == axis.name and case["tie"].startswith(f"θ = {theta},")]
            if not of_theta:
                break
            good = [case for case in of_theta if case["status"] == "converged"]
            worst = [number(max((case[name] for case in good), default=math.nan)) for name in ("error", "flux")]
            bad = sum(case["verdict"] != "right" for case in of_theta)
            row.append(f"{bad} of {len(of_theta)}, {worst[0]} / {worst[1]}")
        if row:
            lines.append(f"| {axis.name} | " + " | ".join(row) + " |")
    return "\n".join(lines)


def points_of(found, tie, values, name, log):
    """(position, number) of a tie; of eigenvalues only positive ones, the others are not definite."""
    points = []
    for position, value in enumerate(values):
        case = found.get((tie, value), {})
        number_there = case.get(name)
        if case.get("status") == "converged" and judge.is_finite(number_there) and (number_there > 0 or not log):
            points.append((position, number_there))
    return points


def picture(axis, cases, directory, kind):
    """One panel for each number that varies, and one for the names. Whether there is a picture."""
    found = by_place(axis, cases)
    ties = [tie for tie in map_axes.FEW if tie in axis.ties and any(place[0] == tie for place in found)]
    values = [value for value in axis.values if any(place[1] == value for place in found)]
    panels = []
    for name, title, log in PANELS:
        lines = {tie: points_of(found, tie, values, name, log) for tie in ties}
        numbers = [y for points in lines.values() for _, y in points]
        if numbers and (log or max(numbers) > min(numbers)):
            panels.append((name, title, log, lines))
    panels = panels[:5]
    if not panels or len(values) < 2:
        return False
    rows = math.ceil((len(panels) + 1) / 3)
    script = [f"set terminal {'svg' if kind == 'svg' else 'pngcairo'} size 1080,{270 * rows + 40} font 'sans,9'",
              f"set output '{os.path.join(directory, axis.name)}.{kind}'",
              f"set multiplot layout {rows},3 title '{axis.title}' font 'sans,11'", "set key off", "set format y '%g'",
              "set xtics (" + ", ".join(f"'{title_of(value)}' {i}" for i, value in enumerate(values)) + ") font 'sans,8'",
              f"set xrange [-0.3:{len(values) - 0.7}]", f"set xlabel '{axis.label}'"]
    styles = {tie: f"linespoints lw 1.5 pt {i + 1} ps 0.8 lc {i + 1}" for i, tie in enumerate(ties)}
    for k, (name, title, log, lines) in enumerate(panels):
        plots = []
        for i, tie in enumerate(ties):
            if lines[tie]:
                script.append(f"$d{k}_{i} << EOD\n" + "\n".join(f"{x} {y!r}" for x, y in lines[tie]) + "\nEOD")
                plots.append(f"$d{k}_{i} with {styles[tie]}")
        script += [f"set title '{title}' font 'sans,10'", "set logscale y" if log else "unset logscale y",
                   "set yrange [*:*]" if log else "set yrange [0:*]", "plot " + ", ".join(plots)]
    script += ["unset title", "unset border", "unset tics", "unset xlabel", "unset logscale y", "set yrange [0:1]",
               "set key center center", "plot " + ", ".join(f"NaN with {styles[tie]} title '{tie}'" for tie in ties), "unset multiplot"]
    done = subprocess.run(["gnuplot"], input="\n".join(script), text=True, capture_output=True, check=False)
    if done.returncode != 0:
        print(f"gnuplot failed for {axis.name}: {done.stderr[-300:]}")
    return done.returncode == 0


def write(all_axes, cases, directory, page=None):
    """tables.md and pictures into the directory; with a page also the tables between its markers and pictures beside it."""
    tables = {axis.name: table(axis, cases) for axis in all_axes if any(case["axis"] == axis.name for case in cases)}
    tables["verdicts"] = verdicts(all_axes, cases)
    tables["thetas"] = thetas(all_axes, cases)
    titles = {axis.name: axis.title for axis in all_axes}
    with open(os.path.join(directory, "tables.md"), "w", encoding="utf-8") as file:
        for name, text in tables.items():
            file.write(f"## {titles.get(name, name)}\n\n{text}\n\n")
    has_gnuplot = shutil.which("gnuplot") is not None
    if not has_gnuplot:
        print("No pictures: gnuplot is not installed (Debian: apt-get install gnuplot-nox).")
    for axis in all_axes:
        if axis.name in tables and has_gnuplot:
            if not page:
                picture(axis, cases, directory, "svg")
            if page and f"pictures/{axis.name}.png" in open(page, encoding="utf-8").read():
                os.makedirs(os.path.join(os.path.dirname(page), "pictures"), exist_ok=True)
                picture(axis, cases, os.path.join(os.path.dirname(page), "pictures"), "png")
    if page:
        with open(page, encoding="utf-8") as file:
            text = file.read()
        text = re.sub(r"<!-- (\w+) -->\n.*?<!-- end -->",
                      lambda match: f"<!-- {match[1]} -->\n{tables[match[1]]}\n<!-- end -->" if match[1] in tables else match[0],
                      text, flags=re.S)
        with open(page, "w", encoding="utf-8") as file:
            file.write(text)
