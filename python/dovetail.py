# SPDX-License-Identifier: LGPL-2.1-or-later
# Copyright (C) 2026 by the Dovetail authors
"""Scenes of Dovetail from Python: compose or load them, run them, read what they found.

    import dovetail

    scene = dovetail.Scene.load("prm/quick_start.prm")
    for theta in (1, 0, -1):
        result = scene.set("Interface left flank/Theta", theta).run(ranks=2)
        print(theta, result.report["probes"])

A scene composed in Python is a nested dictionary with the names of a .prm or .json file:

    bar = dovetail.Scene({"Dimension": 2, "Materials": "steel", "Domains": "bar",
                          "Material steel": {"Heat": {"Type": "Fourier", "Conductivity": 50}}})

The module needs nothing but Python 3.7; where numpy is installed, histories are its arrays.
"""

import copy
import csv
import json
import math
import os
import re
import shutil
import subprocess
import tempfile
import uuid

__all__ = ["Scene", "Result", "InputError", "find_program"]

# Of `dovetail`
DONE, WRONG_INPUT, NOT_CONVERGED = 0, 1, 2


class InputError(ValueError):
    """The scene is wrong; the text says what, where, and what to do."""


def find_program():
    """The path of the program: $DOVETAIL, the build or the installed program beside this file, or `dovetail` on the
    PATH."""
    here = os.path.dirname(os.path.abspath(__file__))
    beside = os.path.normpath(os.path.join(here, "..", "build", "release", "dovetail"))
    installed = os.path.normpath(os.path.join(here, "..", "..", "..", "bin", "dovetail"))
    for candidate in (os.environ.get("DOVETAIL"), beside, installed, shutil.which("dovetail")):
        if candidate and os.access(candidate, os.X_OK):
            return candidate
    raise FileNotFoundError("The program dovetail was not found. Build it with ./run, put it on the PATH, or set "
                            "the environment variable DOVETAIL to it.")


def text_of(value):
    """As a scene writes it: True as true, a list or an array of numpy as its elements with commas, a vector (tuple)
    with semicolons, None as nothing."""
    if value is None:
        return ""
    if hasattr(value, "tolist"):  # of numpy: an array, or a number, whose repr is not that of Python
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, list):
        return ", ".join(text_of(element) for element in value)
    if isinstance(value, tuple):
        return "; ".join(text_of(element) for element in value)
    return str(value)


def with_texts(entries):
    return {name: with_texts(value) if isinstance(value, dict) else text_of(value)
            for name, value in entries.items() if value is not None}


class Scene:
    """A scene, from a file or from a nested dictionary, and entries that override it. It never changes: set() returns
    another one, so that a loop over variants starts from the same scene each time."""

    def __init__(self, entries=None, _file=None, _overrides=()):
        self._entries = copy.deepcopy(entries or {})
        self._file = _file
        self._overrides = tuple(_overrides)

    @classmethod
    def load(cls, file):
        """The scene of a .prm or .json file. Relative paths in it mean what they mean for the program."""
        if not os.path.isfile(file):
            raise FileNotFoundError("The scene '%s' does not exist." % file)
        return cls(_file=os.fspath(file))

    def set(self, path, value):
        """The same scene but for one entry, for instance set("Interface seam/Theta", -1). None takes the entry away."""
        if "=" in path:
            raise ValueError("'%s' is no path of an entry: it contains '='." % path)
        return Scene(self._entries, self._file, self._overrides + ("%s=%s" % (path, text_of(value)),))

    def run(self, ranks=1, directory=None, program=None, timeout=None):
        """Run the program.

        ranks      number of processes of MPI
        directory  for the results; by default that of the scene
        timeout    in seconds

        Returns a Result, also where a step did not converge. Raises InputError where the input is wrong, and
        RuntimeError where the program failed, or another run has replaced the results.
        """
        return self._call([], ranks, directory, program, timeout)

    def check(self, program=None):
        """Read the scene, make meshes and pairings, solve nothing. Returns the text that the program prints."""
        return self._call(["--check"], 1, None, program, None).log

    def _call(self, options, ranks, directory, program, timeout):
        overrides = list(self._overrides)
        if directory is not None:
            overrides.append("Output/Directory=%s" % os.fspath(directory))
        command = _launcher(ranks) + [program or find_program()] + options
        for override in overrides:
            command += ["--set", override]
        if self._file is not None:
            return _run(command + [self._file], timeout)
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "scene.json")
            with open(file, "w") as stream:
                json.dump(with_texts(self._entries), stream)
            return _run(command + [file], timeout)


class Result:
    """What a run has found.

    report     the dictionary of report.json (doc/theory/output.md)
    converged  whether all steps converged; if not, the report is that of the last good one
    directory  of the results, which the next run into it replaces; report and history stay
    log        what the program printed
    """

    def __init__(self, status, log, runs):
        self.converged = status == DONE
        self.log = log
        found = re.findall(r"^ *results: (.*)$", log, re.MULTILINE)
        self.directory = found[-1].strip() if found else None
        self.report = None
        self._history = None
        if self.directory is not None:
            self._history = _read_columns(os.path.join(self.directory, "probes.csv"))
            with open(os.path.join(self.directory, "report.json")) as stream:  # that a run replaces first
                self.report = json.load(stream)
            if self.report.get("run") not in runs:
                raise RuntimeError("Another run has replaced the results in %s before they were read, or the program did not "
                                   "get the variable DOVETAIL_RUN, which the report repeats. Give runs at the same time "
                                   "directories of their own." % self.directory)

    @property
    def probes(self):
        return self.report["probes"]

    @property
    def notes(self):
        """What a user should know of the run."""
        return self.report["notes"]

    @property
    def history(self):
        """The columns of probes.csv by name without the unit, one number per step, as they were at the end of this run: NaN where there
        is none, as of a probe that came with --resume. Scenes with several steps write that file."""
        if self._history is None:
            raise FileNotFoundError("The run has no history: only scenes with several steps write %s."
                                    % os.path.join(self.directory or "", "probes.csv"))
        try:
            import numpy
        except ImportError:
            return self._history
        return {name: numpy.array(numbers) for name, numbers in self._history.items()}


def _read_columns(file):
    if not os.path.exists(file):
        return None
    with open(file, newline="") as stream:
        rows = list(csv.reader(stream))
    number = lambda row, i: float(row[i]) if i < len(row) and row[i].strip() else math.nan
    without_unit = lambda name: re.sub(r" \[[^]]*\]$", "", name)
    return {without_unit(name): [number(row, i) for row in rows[1:]] for i, name in enumerate(rows[0])} if rows else None


def _launcher(ranks):
    if ranks == 1:
        return []
    if shutil.which("mpirun") is None:
        raise FileNotFoundError("mpirun was not found, which starts %d ranks." % ranks)
    return ["mpirun", "-np", str(ranks)]


def _environment():
    """That of ./run: ranks may outnumber the cores, and are the only parallelism."""
    environment = dict(os.environ)
    for name, value in (("OMPI_ALLOW_RUN_AS_ROOT", "1"), ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
                        ("OMPI_MCA_rmaps_base_oversubscribe", "1"), ("OMPI_MCA_hwloc_base_binding_policy", "none"),
                        ("OMPI_MCA_mpi_yield_when_idle", "1"),
                        ("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe"),
                        ("PRTE_MCA_hwloc_default_binding_policy", "none"), ("OMP_NUM_THREADS", "1"),
                        ("OPENBLAS_NUM_THREADS", "1")):
        environment.setdefault(name, value)
    return environment


def _run(command, timeout):
    run = uuid.uuid4().hex
    done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          env=dict(_environment(), DOVETAIL_RUN=run), universal_newlines=True, timeout=timeout)
    if done.returncode in (DONE, NOT_CONVERGED):
        # mpirun may start the first rank on another machine, without this environment
        return Result(done.returncode, done.stdout, {run, None} if command[0] == "mpirun" else {run})
    errors = [line for line in done.stderr.splitlines() if line.startswith("Error: ")]
    message = errors[0][len("Error: "):] if errors else done.stderr.strip()
    raise (InputError if done.returncode == WRONG_INPUT else RuntimeError)(message)
