"""CalculiX as another code to compare with, where `ccx` is installed: the rigid flat in its input, one run on one thread, its forces.

The flat is one unilateral gap per surface node. Its displacements are given both ways, by a step to each overlap in turn.
"""

from __future__ import annotations

import os
import re
import resource
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fem.mesh import FloatArray, IntArray

#: stiffness of a closed gap over that of the body's material (Young's modulus times a length), and its pull when wide open over (unit of
#: stress times the unit of length squared)
GAP_STIFFNESS, GAP_PULL = 1e5, 1e-10


class Result(NamedTuple):
    """What CalculiX found, rows in order and in the units of its input."""

    overlap: FloatArray
    force: FloatArray  # (3, rows): components along the axes of the input
    cpu_seconds: float
    finished: bool


def installed() -> str | None:
    """The path of `ccx`, or None."""
    return shutil.which("ccx")


def node_set(name: str, nodes: Iterable[int]) -> Iterator[str]:
    """Input lines of a set of nodes, which are counted from 0 here and from 1 there."""
    yield f"*NSET, NSET={name}"
    yield from (f"{node + 1}," for node in nodes)


def gaps(first: int, nodes: IntArray, partners: IntArray, clearance: FloatArray, normal: str, stiffness: float) -> Iterator[str]:
    """Input lines of the gaps between `nodes` and their `partners` on the flat, both counted from 0; elements from number `first` on.

    clearance: between the two. normal: of the flat, as "0., 1., 0.". stiffness: of the material, see `GAP_STIFFNESS`.
    """
    for k, (node, partner) in enumerate(zip(nodes, partners, strict=True)):
        yield f"*ELEMENT, TYPE=GAPUNI, ELSET=GAP{k}"
        yield f"{first + k}, {node + 1}, {partner + 1}"
        yield f"*GAP, ELSET=GAP{k}"
        yield f"{clearance[k]:.15g}, {normal}, , {GAP_STIFFNESS * stiffness:.6g}, {GAP_PULL}"


def total_forces(text: str) -> tuple[FloatArray, FloatArray]:
    """Moments and total forces, shape (3, rows), from the text of CalculiX's .dat file, where one set's totals are printed."""
    number = r"([-+]?\d\.\d+E[-+]\d+)"
    rows = re.findall(rf"total force.*?time\s+{number}\s+{number}\s+{number}\s+{number}", text, flags=re.DOTALL)
    moment, *force = np.array(rows, dtype=np.float64).reshape(-1, 4).T
    return moment, np.array(force)


def run(deck: str, stops: Sequence[float], timeout: float | None = None) -> Result:
    """Run `ccx` on an input with a step of one unit of time to each overlap of `stops`, on one thread.

    What it has found when `timeout` (s) is over or when it gives up is returned too.
    """
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "press.inp").write_text(deck)
        finished = _finished(folder, timeout)
        after, data = resource.getrusage(resource.RUSAGE_CHILDREN), folder / "press.dat"
        moment, force = total_forces(data.read_text() if data.exists() else "")
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Result(np.interp(moment, np.arange(len(stops) + 1.0), [0.0, *stops]), force, seconds, finished)


def _finished(folder: Path, timeout: float | None) -> bool:
    alone = os.environ | {"OMP_NUM_THREADS": "1", "CCX_NPROC_EQUATION_SOLVER": "1", "CCX_NPROC_STIFFNESS": "1"}
    command = [installed() or "ccx", "press"]
    with open(folder / "log", "w") as log:
        try:
            return subprocess.run(command, cwd=folder, env=alone, stdout=log, stderr=subprocess.STDOUT, timeout=timeout).returncode == 0
        except subprocess.TimeoutExpired:
            return False
