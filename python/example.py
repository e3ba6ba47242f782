#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors

# %% [markdown]
# # How good must the joint between two bars be?
#
# Heat flows through a bar of copper and a bar of steel (prm/tutorials/01_two_blocks.prm). We put a contact resistance
# between them, in place of the perfect tie, and ask which conductance loses less than 5 % of the heat.
#
# Editors that know the marks `# %%` run this file cell by cell, and `jupytext --to ipynb` makes a notebook of it.
# `python3 example.py` runs all cells; DOVETAIL names the program, if it is neither built nor installed beside this file.

# %%
from pathlib import Path

import dovetail

beside = Path(dovetail.__file__).resolve().parent.parent  # the sources, or share/dovetail
tutorials = next(folder for folder in (beside / "prm" / "tutorials", beside / "tutorials") if folder.exists())
perfect = dovetail.Scene.load(tutorials / "01_two_blocks.prm").set("Output/Paraview", False)
heat = -perfect.run(directory="output/example/perfect").probes["heat out"]
print(f"perfect tie: {heat:.2f} W")

# %% [markdown]
# `set(path, value)` returns another scene, so the first one stays as it is. `None` takes entries away that a contact
# resistance does not have.

# %%
joint = perfect.set("Interface seam/Type", "contact resistance")
for entry in ("Weights", "Penalty", "Multiplier"):
    joint = joint.set(f"Interface seam/{entry}", None)


def loss(conductance):
    """Share of the heat that the joint costs."""
    result = joint.set("Interface seam/Conductance", conductance).run(directory="output/example/joint")
    return 1 + result.probes["heat out"] / heat


# %% [markdown]
# ## A sweep

# %%
losses = {conductance: loss(conductance) for conductance in (100, 300, 1000, 3000, 10000)}
print("W/(m^2 K)   loss")
for conductance, share in losses.items():
    print(f"{conductance:9}  {share:5.1%}")

# %% [markdown]
# ## The conductance that loses 5 %
#
# Bisection of its logarithm.

# %%
low, high = 1e2, 1e4
while high / low > 1.001:
    middle = (low * high) ** 0.5
    low, high = (middle, high) if loss(middle) > 0.05 else (low, middle)
needed = (low * high) ** 0.5
print(f"{needed:.0f} W/(m^2 K) lose 5 %")

# %% [markdown]
# ## How exact is this?
#
# The meshes are coarse. With a Tolerance of the probe the run estimates its own error, as a share of the heat; without
# unknowns to spend it refines nothing.

# %%
checked = joint.set("Interface seam/Conductance", needed).set("Probe heat out/Tolerance", 1e-3)
report = checked.set("Adaptive unknowns", 1).run(directory="output/example/checked").report
estimate = report["probe estimates"]["heat out"]
print(f"estimated relative error: {estimate['relative error']:.1e}")

# %% [markdown]
# A picture, where matplotlib is installed.

# %%
try:
    import matplotlib.pyplot as plt
except ImportError:
    print("no picture: matplotlib is not installed")
else:
    plt.semilogx(list(losses), [100 * share for share in losses.values()], "o-")
    plt.axvline(needed, linestyle=":")
    plt.xlabel("conductance of the joint [W/(m² K)]")
    plt.ylabel("heat that is lost [%]")
    plt.savefig("output/example/loss.png", dpi=150)
