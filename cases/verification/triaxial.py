"""Ellipsoids of three different axes pressed against a flat, by CalculiX where `ccx` is installed, beside the laws of ellipsoids.

    python -m cases.verification.triaxial [--out FOLDER] [--size .035] [BODY ...]      BODY as 1:1.25:1.5, the first axis is pressed

An eighth of the ellipsoid of lithium nickel manganese cobalt oxide (Becker & Kamlah 2021, table 1) in ten-node tetrahedra (gmsh), finite
strain, perfect plasticity, one unilateral gap per surface node for the rigid frictionless flat; to .15 of the mean radius, and released.
Our own solver takes bodies of revolution alone, and the law is fitted to these: this measures what it says of all others. The sphere, which
both can do, tells what the coarse mesh costs. Some ten CPU minutes a body. Written are a CSV per body,
and how far the laws are off: mean error of the force along load, unload and reload over the largest force.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from calibration.spheroid_curves import NMC
from cases import calculix
from contactlaws.ellipsoid_contact import on_flat
from contactlaws.errors import InputError, Problem
from fem.profile import load_gmsh

FloatArray = npt.NDArray[np.float64]

BODIES = ("1:1:1", "1:1.25:1.5", "1:0.5:0.8", "1:0.7071:1.4142", "1:0.5:2", "1:0.6:1", "1:1:2")
LARGEST = 0.15
#: increments of the loading, and of the release
STEPS, BACK = 30, 12
#: the release goes to that share of the largest overlap; from a contact that has opened before nothing more is learnt
LEAST = 0.35


def mesh(axes: tuple[float, float, float], size: float) -> tuple[FloatArray, npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Nodes (n, 3), tetrahedra (m, 10) in CalculiX's order and surface nodes of an eighth of the ellipsoid; the pressed axis is z."""
    gmsh = load_gmsh()
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.occ.addSphere(0, 0, 0, 1, angle1=0, angle2=math.pi / 2, angle3=math.pi / 2)
        gmsh.model.occ.synchronize()
        fields = gmsh.model.mesh.field
        fields.add("MathEval", 1)
        # fine where the contact grows, in the unit sphere, and coarser with the distance from the pole
        fields.setString(1, "F", f"{size} + 0.22 * Max(0, Sqrt(x*x + y*y + (z-1)*(z-1)) - {6 * size})")
        fields.setAsBackgroundMesh(1)
        for option in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
            gmsh.option.setNumber(f"Mesh.{option}", 0)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        tags, points, _ = gmsh.model.mesh.getNodes()
        number = {int(tag): k for k, tag in enumerate(tags)}
        _, connection = gmsh.model.mesh.getElementsByType(11)
        cells = np.array([number[int(tag)] for tag in connection]).reshape(-1, 10)
        cells[:, [8, 9]] = cells[:, [9, 8]]  # gmsh numbers the last two edges the other way round
        x = points.reshape(-1, 3)
        used = np.unique(cells)
        renumber = np.full(len(x), -1)
        renumber[used] = np.arange(len(used))
        x = x[used]
        surface = np.flatnonzero(abs(np.linalg.norm(x, axis=1) - 1.0) < 1e-6)
        height, *widths = axes
        return x * np.array([*widths, height]), renumber[cells], surface
    finally:
        gmsh.finalize()


def deck(axes: tuple[float, float, float], size: float) -> str:
    """CalculiX's input."""
    x, cells, surface = mesh(axes, size)
    height, mean = axes[0], math.prod(axes) ** (1.0 / 3.0)
    surface = surface[x[surface, 2] > 0.2 * height]
    flat = len(x) + np.arange(len(surface))
    lines = ["*NODE, NSET=BODY", *(f"{k + 1}, {p[0]:.15g}, {p[1]:.15g}, {p[2]:.15g}" for k, p in enumerate(x))]
    lines += ["*NODE, NSET=FLAT", *(f"{k + 1}, {x[s, 0]:.15g}, {x[s, 1]:.15g}, {height:.15g}" for k, s in zip(flat, surface, strict=True))]
    lines += ["*ELEMENT, TYPE=C3D10, ELSET=BODY"]
    lines += [", ".join(map(str, (e + 1, *(nodes + 1)))) for e, nodes in enumerate(cells)]
    lines += calculix.gaps(len(cells) + 1, surface, flat, height - x[surface, 2], "0., 0., 1.", NMC.youngs_modulus * size)
    for axis, name in enumerate(("X", "Y", "Z")):
        lines += calculix.node_set(name, np.flatnonzero(abs(x[:, axis]) < 1e-9))
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", f"{NMC.youngs_modulus:.15g}, {NMC.poissons_ratio:.15g}", "*PLASTIC", "1., 0."]
    lines += ["*SOLID SECTION, ELSET=BODY, MATERIAL=M", "*BOUNDARY", "FLAT, 1, 3", "X, 1, 1", "Y, 2, 2"]
    for overlap, count in ((LARGEST * mean, STEPS), (LEAST * LARGEST * mean, BACK)):
        lines += ["*STEP, NLGEOM, INC=2000", "*STATIC", f"{0.3 / count:.6g}, 1., 1e-8, {1.0 / count:.6g}"]
        lines += ["*BOUNDARY", f"Z, 3, 3, {overlap:.15g}"]
        lines += ["*NODE PRINT, NSET=Z, TOTALS=ONLY", "RF", "*END STEP"]
    return "\n".join(lines) + "\n"


def press(axes: tuple[float, float, float], size: float) -> FloatArray:
    """Overlap (of the height's unit) and force over Y; shape (2, increments), the release included."""
    mean = math.prod(axes) ** (1.0 / 3.0)
    found = calculix.run(deck(axes, size), [LARGEST * mean, LEAST * LARGEST * mean])
    return np.array([found.overlap, 4.0 * found.force[2]])


def mean_error(overlap: FloatArray, force: FloatArray, own: FloatArray) -> float:
    """Along load, unload and reload, in proportion to the way, over the largest force."""
    top = int(overlap.argmax())
    up, down = slice(0, top + 1), slice(top, None)
    way = np.concatenate([[overlap[0]], np.diff(overlap[up])]), 2.0 * abs(np.diff(overlap[down], prepend=overlap[top]))
    open_now = force[down] <= 0.0
    way[1][np.cumsum(open_now) > 1] = 0.0
    miss = abs(own - force) / force.max()
    return float((miss[up] @ way[0] + miss[down] @ way[1]) / (way[0].sum() + way[1].sum()))


def residual(overlap: FloatArray, force: FloatArray) -> float:
    """Overlap at which the release ends, over the largest: the force to the power of 2/3 goes there on a straight line."""
    top = int(overlap.argmax())
    depth, load = overlap[top:], force[top:]
    low = (load > 0.005 * force.max()) & (load < 0.15 * force.max())
    slope, intercept = np.polyfit(depth[low], load[low] ** (2.0 / 3.0), 1)
    return float(-intercept / slope / overlap[top])


def main(arguments: Sequence[str] | None = None) -> None:
    """See the module."""
    parser = argparse.ArgumentParser(prog="python -m cases.verification.triaxial", description=__doc__)
    parser.add_argument("body", nargs="*", default=BODIES)
    parser.add_argument("--out", type=Path, default=Path("results/triaxial"))
    parser.add_argument("--size", type=float, default=0.035, help="of the elements at the pole of the unit sphere")
    options = parser.parse_args(arguments)
    if calculix.installed() is None:
        raise InputError(Problem("ccx", None, "CalculiX is not installed", "install the package calculix-ccx"))
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.body:
        a, b, c = (float(part) for part in name.split(":"))
        path = options.out / f"{name.replace(':', '_')}_size{options.size:g}.csv"
        if not path.exists():
            np.savetxt(path, press((a, b, c), options.size).T, delimiter=",", header="overlap over a, force over Y a^2", fmt="%.9g")
        overlap, force = np.loadtxt(path, delimiter=",").T
        own = on_flat(NMC, (a, b, c)).along(overlap).force
        top = int(overlap.argmax())
        print(
            f"{name}: mean error of the force {100.0 * mean_error(overlap, force, own):.2f} % of the largest, "
            f"at the largest overlap {100.0 * (own[top] / force[top] - 1.0):+.2f} %, residual over largest overlap "
            f"{residual(overlap, own):.3f}, by CalculiX {residual(overlap, force):.3f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
