# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
"""What became of each case of the stability map.

right         error in energy at most twice, error of the flux at most ten times that of the same tie at the axis's benign
              end and at most a half, or both below 1e-6 (or the rounding that the axis or the condition number states); where there is only a reference
              value: within 1 %
warned        the answer is off, and a note of the report says so
flux lost     the bodies are right, but the flux through the seam is not, and nobody says so
not converged, message
WRONG         the answer is off, and nobody says so
CRASH         the program broke down, or a number is not finite"""

import collections
import math

ENERGY, FLUX, REFERENCE = 2.0, 10.0, 0.01
EPSILON = 2.2e-16
LARGEST_FLUX = 0.5  # whatever it is at the benign end
BAD = ("WRONG", "flux lost", "CRASH")
# of notes that say that the answer may be off
WORDS = ("coercive", "errs", "oscillates", "swap", "locks", "resolve", "tied in the mean", "sides differ")


def is_finite(number):
    return isinstance(number, (int, float)) and math.isfinite(number)


def judge(all_axes, cases):
    by_name = {axis.name: axis for axis in all_axes}
    benign = {(case["axis"], case["tie"]): case for case in cases if case["value"] == by_name[case["axis"]].benign}
    for case in cases:
        case["verdict"] = verdict(by_name[case["axis"]], case, benign.get((case["axis"], case["tie"])))


def verdict(axis, case, benign):
    if case["status"] != "converged":
        return case["status"]
    if not is_finite(case["error"]) or not is_finite(case["flux"]):
        return "CRASH"
    if benign is None or benign["status"] != "converged":
        return "right"

    rounding = max(axis.rounding(case["value"]), EPSILON * (case.get("scaled condition") or 0))

    def holds(name, factor):
        if axis.reference is not None:
            return case[name] <= REFERENCE
        return case[name] <= max(factor * benign[name], rounding)

    flux_holds = holds("flux", FLUX * axis.cancellation(case["value"])) and (axis.reference is not None or case["flux"] <= LARGEST_FLUX * axis.cancellation(case["value"]))
    if holds("error", ENERGY) and (not axis.with_flux or flux_holds):
        return "right"
    if (case["margin"] or 0) < 0 or any(word in note for word in WORDS for note in case["notes"]):
        return "warned"
    return "flux lost" if holds("error", ENERGY) else "WRONG"


def summary(cases):
    count = collections.Counter(case["verdict"] for case in cases)
    print(", ".join(f"{name}: {number}" for name, number in sorted(count.items())))
    for case in cases:
        if case["verdict"] in BAD:
            print(f"{case['verdict']}: {case['axis']} = {case['value']}, {case['tie']}: "
                  + (case.get("text") or f"error {case['error']:.3g}, flux {case['flux']:.3g}"))
    return 1 if any(case["verdict"] in BAD for case in cases) else 0
