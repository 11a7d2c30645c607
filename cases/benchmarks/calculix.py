"""The same press by CalculiX, where `ccx` is installed: its input deck from our mesh, one run, its force.

Eight-node axisymmetric elements with reduced integration (CAX8R), finite strain, perfect plasticity, and one unilateral gap per surface
node for the rigid frictionless flat; displacement control both ways.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from contactlaws.material import Material
from fem.mesh import FloatArray, IntArray, Section

#: stiffness of a closed gap over (Young's modulus times the half height), and its pull when wide open over (yield stress times its square)
GAP_STIFFNESS, GAP_PULL = 1e5, 1e-10
#: CalculiX computes a wedge of 2 degrees
WEDGES = 180.0


class Quadratic(NamedTuple):
    """Eight-node quadrilaterals: the corners of a section and the middles of its edges."""

    points: FloatArray  # (2, nodes)
    cells: IntArray  # (8, elements): corners, then middles of the edges between them
    axis: IntArray
    midplane: IntArray
    surface: IntArray  # from the pole outwards


class Result(NamedTuple):
    """What CalculiX found, rows in order; lengths over the half height, force over (stress unit times its square)."""

    overlap: FloatArray
    force: FloatArray
    cpu_seconds: float
    finished: bool


def installed() -> str | None:
    """The path of `ccx`, or None."""
    return shutil.which("ccx")


def quadratic(section: Section) -> Quadratic:
    """Put a node in the middle of every edge of a sphere's section, on the sphere where the edge is on the surface."""
    mesh, corners = section.mesh, section.mesh.p.shape[1]
    middles = mesh.p[:, mesh.facets].mean(axis=1)
    number = {frozenset(edge): corners + k for k, edge in enumerate(mesh.facets.T.tolist())}

    def between(nodes: IntArray) -> IntArray:
        chain = nodes.tolist()
        return np.array([number[frozenset(pair)] for pair in zip(chain[:-1], chain[1:], strict=True)])

    surface = between(section.surface)
    middles[:, surface - corners] /= np.hypot(*middles[:, surface - corners])
    points = np.concatenate([mesh.p, middles], axis=1)

    def line(nodes: IntArray, coordinate: int) -> IntArray:
        ordered = nodes[np.argsort(points[coordinate, nodes])]
        return np.concatenate([ordered, between(ordered)])

    along = np.empty(2 * section.surface.size - 1, dtype=np.int64)
    along[0::2], along[1::2] = section.surface, surface
    cells = np.concatenate([mesh.t, corners + mesh.t2f])
    return Quadratic(points, cells, line(section.axis, 1), line(section.midplane, 0), along)


def _set(name: str, nodes: Iterable[int]) -> Iterator[str]:
    yield f"*NSET, NSET={name}"
    yield from (f"{node + 1}," for node in nodes)


def deck(body: Quadratic, material: Material, stops: list[float], increments: int) -> str:
    """CalculiX's input: one step of about `increments` increments to each overlap (over the half height) of `stops` in turn."""
    modulus, size = material.youngs_modulus / material.stress_unit, body.points.shape[1]
    lines = ["*NODE, NSET=BODY", *(f"{k + 1}, {r:.15g}, {z:.15g}, 0." for k, (r, z) in enumerate(body.points.T))]
    flat = size + 1 + np.arange(body.surface.size)
    lines += ["*NODE, NSET=FLAT", *(f"{k}, {body.points[0, s]:.15g}, 1., 0." for k, s in zip(flat, body.surface, strict=True))]
    lines += ["*ELEMENT, TYPE=CAX8R, ELSET=BODY"]
    lines += [", ".join(map(str, (e + 1, *(nodes + 1)))) for e, nodes in enumerate(body.cells.T)]
    first = body.cells.shape[1] + 1
    for k, (node, partner) in enumerate(zip(body.surface, flat, strict=True)):
        lines += [f"*ELEMENT, TYPE=GAPUNI, ELSET=GAP{k}", f"{first + k}, {node + 1}, {partner}"]
        lines += [f"*GAP, ELSET=GAP{k}", f"{1.0 - body.points[1, node]:.15g}, 0., 1., 0., , {GAP_STIFFNESS * modulus:.6g}, {GAP_PULL}"]
    lines += [*_set("AXIS", body.axis), *_set("MIDPLANE", body.midplane)]
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", f"{modulus:.15g}, {material.poissons_ratio:.15g}"]
    if material.yield_stress is not None:
        lines += ["*PLASTIC", "1., 0."]
    lines += ["*SOLID SECTION, ELSET=BODY, MATERIAL=M", "*BOUNDARY", "FLAT, 1, 3", "AXIS, 1, 1"]
    for overlap in stops:
        lines += [f"*STEP, NLGEOM, INC={20 * increments}", "*STATIC", f"{0.2 / increments:.6g}, 1., 1e-8, {1.0 / increments:.6g}"]
        lines += ["*BOUNDARY", f"MIDPLANE, 2, 2, {overlap:.15g}"]
        lines += ["*NODE PRINT, NSET=MIDPLANE, TOTALS=ONLY", "RF", "*END STEP"]
    return "\n".join(lines) + "\n"


def _forces(text: str, stops: list[float]) -> tuple[FloatArray, FloatArray]:
    """Overlap and force of each increment from the text of CalculiX's .dat file."""
    number = r"([-+]?\d\.\d+E[-+]\d+)"
    rows = re.findall(rf"total force.*?time\s+{number}\s+{number}\s+{number}\s+{number}", text, flags=re.DOTALL)
    moment, _, force, _ = np.array(rows, dtype=np.float64).reshape(-1, 4).T
    return np.interp(moment, np.arange(len(stops) + 1.0), [0.0, *stops]), WEDGES * force


def run(body: Quadratic, material: Material, stops: list[float], increments: int, timeout: float) -> Result:
    """Run `ccx` on one thread; what it has found when `timeout` (s) is over is returned too."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "press.inp").write_text(deck(body, material, stops, increments))
        alone = os.environ | {"OMP_NUM_THREADS": "1", "CCX_NPROC_EQUATION_SOLVER": "1", "CCX_NPROC_STIFFNESS": "1"}
        began = time.monotonic()
        with open(Path(folder) / "log", "w") as log:
            process = subprocess.Popen([installed() or "ccx", "press"], cwd=folder, env=alone, stdout=log, stderr=subprocess.STDOUT)
            usage = None
            while usage is None:
                done, status, used = os.wait4(process.pid, os.WNOHANG)
                if done:
                    usage, process.returncode = used, os.waitstatus_to_exitcode(status)
                elif time.monotonic() - began > timeout:
                    process.kill()
                    timeout = np.inf
                else:
                    time.sleep(0.02)
        data = Path(folder) / "press.dat"
        overlap, force = _forces(data.read_text() if data.exists() else "", stops)
        return Result(overlap, force, usage.ru_utime + usage.ru_stime, process.returncode == 0 and timeout < np.inf)
