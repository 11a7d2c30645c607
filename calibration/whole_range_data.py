"""What the whole-range law is fitted to and judged by: every unloading of a folder of curves, in the law's own units.

Lengths over the radius R, forces over pi R^2 Y, energies over pi R^3 Y; depth is the overlap over the radius.
"""

from __future__ import annotations

import hashlib
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from calibration.unloadings import equal_force_steps, unloading
from contactlaws.compiled import kernel
from contactlaws.curve import Curve
from contactlaws.curve_files import read_curve
from contactlaws.errors import InputError, Problem
from contactlaws.material import Material
from contactlaws.whole_range import unloading as law_unloading
from contactlaws.whole_range_record import Constants, WholeRange, coefficients
from contactlaws.whole_range_unloading import area_left, shape, shape_work

FloatArray = npt.NDArray[np.float64]

#: shares of the recovery at which the shape of an unloading is compared: at equal steps of the curve's force, as its exponent is read
SHAPE_STEPS = 5


class Targets(NamedTuple):
    """One row per unloading of the curves."""

    modulus: FloatArray  # E/Y
    poissons_ratio: FloatArray
    depth: FloatArray
    plastic: npt.NDArray[np.bool_]  # it starts beyond first yield
    yield_depth: FloatArray  # infinite: no yield on the curve
    load: FloatArray
    contact_radius: FloatArray
    recovered: FloatArray  # 1/rho
    exponent: FloatArray  # alpha
    energy: FloatArray  # recovered
    s: FloatArray  # shape (rows, steps): shares of the recovery that are left
    shape: FloatArray  # the force there over its largest
    area: FloatArray  # the contact area there over its largest
    hash: str  # of all curves


class Found(NamedTuple):
    """The law's counterpart of `Targets`."""

    yield_depth: FloatArray
    load: FloatArray
    contact_radius: FloatArray
    recovered: FloatArray
    energy: FloatArray
    shape: FloatArray
    area: FloatArray


def read_folder(folder: str | Path) -> list[Curve]:
    """All curves of spheres that yield in a folder, in the order of their names; raises `InputError` if there are none."""
    curves = [read_curve(path) for path in sorted(Path(folder).glob("*.parquet"))]
    usable = [curve for curve in curves if curve.material is not None and curve.material.yield_stress is not None and curve.aspect == 1.0]
    if not usable:
        raise InputError(Problem("folder", str(folder), "holds no curve (.parquet) of a sphere that yields", "compute some with a study"))
    return usable


def targets(curves: list[Curve]) -> Targets:
    """The unloadings of `curves`; those that do not end in separation are left out."""
    rows = [row for curve in curves for branch in curve.unloadings if (row := _row(curve, branch)) is not None]
    digest = hashlib.sha256("".join(sorted(curve.content_hash for curve in curves)).encode()).hexdigest()[:16]
    columns: list[Any] = [np.array(column) for column in zip(*rows, strict=True)]
    return Targets._make((*columns, digest))


def _row(curve: Curve, branch: int) -> tuple[float | bool | FloatArray, ...] | None:
    found, material = unloading(curve, branch), curve.material
    if found is None or found.contact_radius is None or material is None or material.yield_stress is None or curve.contact_radius is None:
        return None
    rows, radius = curve.rows(branch), curve.radius
    unit = math.pi * radius**2 * material.yield_stress
    s, f = equal_force_steps(curve.overlap[rows], curve.force[rows])
    overlap = found.separation_overlap + s * (found.overlap - found.separation_overlap)
    order = np.argsort(curve.overlap[rows])
    area = (np.interp(overlap, curve.overlap[rows][order], curve.contact_radius[rows][order]) / found.contact_radius) ** 2
    steps = slice(SHAPE_STEPS, 100, SHAPE_STEPS)
    return (
        material.youngs_modulus / material.yield_stress,
        material.poissons_ratio,
        found.overlap / radius,
        bool(found.plastic),
        math.inf if curve.yield_overlap is None else curve.yield_overlap / radius,
        found.force / unit,
        found.contact_radius / radius,
        1.0 / found.stiffness,
        found.exponent,
        found.recovered_energy / (unit * radius),
        s[steps],
        f[steps],
        area[steps],
    )


@kernel
def _evaluate(constants, modulus, poissons_ratio, depth, s):  # type: ignore[no-untyped-def]
    rows, steps = s.shape
    single = np.empty((5, rows))
    shapes = np.empty((2, rows, steps))
    law = WholeRange(*coefficients(constants, 1.0, modulus[0], poissons_ratio[0], 1.0))
    for i in range(rows):
        if i > 0 and (modulus[i] != modulus[i - 1] or poissons_ratio[i] != poissons_ratio[i - 1]):
            law = WholeRange(*coefficients(constants, 1.0, modulus[i], poissons_ratio[i], 1.0))
        load, phi, area, recovered, terms = law_unloading(law, depth[i])
        single[0, i] = law.yield_depth
        single[1, i] = load
        single[2, i] = math.sqrt(area)
        single[3, i] = recovered
        single[4, i] = load * recovered * shape_work(terms, 1.0)
        for j in range(steps):
            shapes[0, i, j] = shape(terms, s[i, j])
            shapes[1, i, j] = area_left(law, depth[i], load, phi, area, recovered, terms, s[i, j])
    return single, shapes


def evaluate(constants: Constants, modulus: FloatArray, poissons_ratio: FloatArray, depth: FloatArray, s: FloatArray) -> Found:
    """The law with these constants at many states, by the kernels that a simulation runs. Arrays as in `Targets`."""
    single, shapes = _evaluate(constants, modulus, poissons_ratio, depth, s)
    return Found(*single, *shapes)


def law_at(constants: dict[str, float], modulus: float, poissons_ratio: float) -> WholeRange:
    """The record of a body of radius 1 and yield stress 1."""
    material = Material(float(modulus), float(poissons_ratio), 1.0)
    return WholeRange(*coefficients(Constants(**constants), 1.0, material.youngs_modulus, material.poissons_ratio, 1.0))
