# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
"""Runs the cases of the stability map and reads their reports."""

import concurrent.futures
import json
import math
import os
import shutil
import subprocess

import axes as map_axes

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(os.path.dirname(os.path.dirname(HERE)))
SCENES = os.path.relpath(HERE, TOP)
TIMEOUT = 120  # seconds, of one run


def arguments(axis, tie, value, directory):
    entries = {**axis.entries(value), **map_axes.entries_of_tie(axis, tie, value), "Output/Directory": directory}
    if not axis.spectrum and "3d" not in axis.scene:
        entries["Output/Spectrum"] = "false"
    result = []
    for path, text in entries.items():
        result += ["--set", f"{path}={text}"]
    return result + [os.path.join(SCENES, axis.scene + ".prm")]


def relative(report, axis, name):
    """The largest relative error of the bodies."""
    result = 0.0
    for body in report["domains"].values():
        error, norm = body["errors"][axis.field][name], body["norms"][axis.field][name]
        result = max(result, math.nan if error is None else error / norm if norm else error)
        if error is None:
            return math.nan
    return result


def against_reference(report, reference):
    name, component, expected = reference
    value = report["probes"][name]
    return abs((value[component] if isinstance(value, list) else value) / expected - 1)


def worst_flux(report, axis, key):
    """Of the axis's interfaces, relative to the exact flux."""
    result = 0.0
    for name in axis.interfaces:
        seam = report["interfaces"][name]
        norm = seam["flux norm L2"][axis.field] if axis.measure == "energy" else 1.0
        value = seam[key][axis.field]
        result = max(result, math.nan if value is None else value / norm if norm else value)
    return result


def of_report(report, axis, value):
    if axis.reference is not None:
        numbers = {"error": against_reference(report, axis.reference(value)), "flux": 0.0}
    else:
        numbers = {"error": relative(report, axis, axis.measure), "flux": worst_flux(report, axis, "flux error L2"),
                   "oscillation": worst_flux(report, axis, "flux oscillation")}
    seam = report["interfaces"][axis.interfaces[0]]
    numbers["newton"] = sum(step["newton iterations"] for step in report["steps"])
    numbers["linear"] = sum(sum(step["linear iterations"]) for step in report["steps"])
    numbers["margin"] = seam.get("coercivity margin")
    for spectrum in report.get("spectrum", {}).values():
        numbers["eigenvalue"] = spectrum.get("scaled smallest eigenvalue")
        numbers["condition"] = spectrum.get("condition number")
        numbers["scaled condition"] = spectrum.get("scaled condition number")
        if "multipliers" in spectrum:
            numbers["wrong signs"] = abs(spectrum["multipliers"] - spectrum["negative eigenvalues"])
    numbers["notes"] = report.get("notes", [])
    return numbers


def run_case(dovetail, axis, tie, value, directory):
    """The numbers of one case; "status": converged, not converged, message or CRASH."""
    case = {"axis": axis.name, "tie": tie, "value": value}
    shutil.rmtree(directory, ignore_errors=True)
    command = [dovetail] + arguments(axis, tie, value, directory)
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = subprocess.run(command, cwd=TOP, env=environment, capture_output=True, text=True, timeout=TIMEOUT, check=False)
    except subprocess.TimeoutExpired:
        return {**case, "status": "CRASH", "text": f"no end after {TIMEOUT} s"}
    if done.returncode == 1:
        return {**case, "status": "message", "text": done.stderr.strip()}
    if done.returncode not in (0, 2):
        return {**case, "status": "CRASH", "text": f"status {done.returncode}: {done.stderr.strip()[-300:]}"}
    if done.returncode == 2:  # what is measured then, if anything, is the last good step
        return {**case, "status": "not converged"}
    case["status"] = "converged"
    try:
        with open(os.path.join(TOP, directory, "report.json"), encoding="utf-8") as file:
            report = json.load(file)
        case.update(of_report(report, axis, value))
        if done.returncode == 0 and not report["converged"]:
            return {**case, "status": "CRASH", "text": "status 0, but not converged"}
    except (OSError, ValueError, KeyError, TypeError) as problem:
        return {**case, "status": "CRASH", "text": f"no report: {problem!r}"}
    shutil.rmtree(os.path.join(TOP, directory), ignore_errors=True)
    return case


def run_all(dovetail, cases, file_name, n_processes, tell):
    """Run what the file does not have yet; one line for each case."""
    known = {}
    if os.path.exists(file_name):
        with open(file_name, encoding="utf-8") as file:
            for line in file:
                case = json.loads(line)
                known[case["axis"], case["tie"], case["value"]] = case
    wanted = [(axis, tie, value) for axis, tie, value in cases if (axis.name, tie, value) not in known]
    scratch = os.path.join(os.path.dirname(file_name), "runs")
    with open(file_name, "a", encoding="utf-8") as file, \
            concurrent.futures.ThreadPoolExecutor(n_processes) as pool:
        futures = [pool.submit(run_case, dovetail, axis, tie, value, os.path.join(scratch, str(i)))
                   for i, (axis, tie, value) in enumerate(wanted)]
        for i, future in enumerate(concurrent.futures.as_completed(futures)):
            case = future.result()
            known[case["axis"], case["tie"], case["value"]] = case
            file.write(json.dumps(case) + "\n")
            file.flush()
            tell(i + 1, len(wanted))
    return [known[axis.name, tie, value] for axis, tie, value in cases]
