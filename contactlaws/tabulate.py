"""From a curve to the tables of `contactlaws.tabulated`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PchipInterpolator

from contactlaws.curve import Curve
from contactlaws.errors import Problem, require
from contactlaws.tabulated import Tabulated, steepest

FloatArray = npt.NDArray[np.float64]


def from_curve(curve: Curve) -> Tabulated:
    """The tabulated law of a loading with unloadings; purely elastic (the loading alone) if the material has no yield stress.

    Rows before the first positive force are left out. Raises `InputError` for a curve of a body that yields without unloadings, or with an
    unloading that does not run down to separation or turns back on its way.
    """
    elastic = curve.material is not None and curve.material.yield_stress is None
    require(_problems(curve, elastic))
    rows = curve.rows(0)
    keep = (curve.overlap[rows] > 0.0) & (np.minimum.accumulate(curve.force[rows][::-1])[::-1] > 0.0)
    overlap, force = curve.overlap[rows][keep], curve.force[rows][keep]
    slope = _slopes(overlap, force)
    # below the first row the force is a power of the overlap; a measured first row may suggest any, Hertz's is 1.5
    slope[0] = np.clip(slope[0] * overlap[0] / force[0], 1.0, 3.0) * force[0] / overlap[0]
    work = _integral(overlap, force, slope) + force[0] * overlap[0] / (slope[0] * overlap[0] / force[0] + 1.0)
    area = np.zeros(0) if curve.contact_radius is None else curve.contact_radius[rows][keep] ** 2
    tables = [] if elastic else sorted((_unloading(curve, branch) for branch in curve.unloadings), key=lambda table: table[0])
    columns = [np.concatenate(parts) if parts else np.zeros(0) for parts in zip(*(table[2] for table in tables), strict=True)] or [np.zeros(0)] * 6
    sizes = [table[2][0].size for table in tables]
    yield_overlap = overlap[0] if curve.yield_overlap is None else curve.yield_overlap
    largest = np.array([table[0] for table in tables])
    return Tabulated(
        radius=float(curve.radius),
        yield_overlap=float(min([yield_overlap, *(0.999 * largest)])),
        overlap=_frozen(overlap),
        force=_frozen(force),
        slope=_frozen(slope),
        work=_frozen(work),
        area=_frozen(area),
        area_slope=_frozen(_slopes(overlap, area) if area.size else area),
        largest=_frozen(largest),
        stiffening=_frozen([table[1] for table in tables]),
        start=_frozen(np.concatenate(([0], np.cumsum(sizes))) if sizes else np.zeros(0)),
        unload_left=_frozen(columns[0]),
        unload_force=_frozen(columns[1]),
        unload_slope=_frozen(columns[2]),
        unload_steepest=_frozen([_steepest(*table[2][:3]) for table in tables]),
        unload_work=_frozen(columns[3]),
        unload_area=_frozen(columns[4]),
        unload_area_slope=_frozen(columns[5]),
        last_work=float(work[-1]),
    )


def _unloading(curve: Curve, branch: int) -> tuple[float, float, tuple[FloatArray, ...]]:
    """Largest overlap, what plasticity adds to 1/(d_max - d_0), and the six normalised columns of one unloading, from separation up."""
    rows = curve.rows(branch)
    overlap, force = curve.overlap[rows][::-1], curve.force[rows][::-1]
    # a recorded separation may lie a round-off or the last row's small force away from zero: the shape itself starts at exactly 0
    left = (overlap - overlap[0]) / (overlap[-1] - overlap[0])
    ratio = force / force[-1]
    ratio[0] = 0.0
    slope = _slopes(left, ratio)
    area = np.zeros(0) if curve.contact_radius is None else (curve.contact_radius[rows][::-1] / curve.contact_radius[rows][0]) ** 2
    area_slope = _slopes(left, area) if area.size else area
    # an unloading of a body that has hardly yielded may seem to give back all of the overlap: at least 1e-6 of it is taken to stay
    stiffening = max(1.0 / (overlap[-1] - overlap[0]) - 1.0 / overlap[-1], 1e-6 / overlap[-1])
    return float(overlap[-1]), float(stiffening), (left, ratio, slope, _integral(left, ratio, slope), area, area_slope)


def _steepest(x: FloatArray, y: FloatArray, slope: FloatArray) -> float:
    return max(steepest(x, y, slope, i) for i in range(x.size - 1))


def _slopes(x: FloatArray, y: FloatArray) -> FloatArray:
    """Slopes of the monotone cubic at its rows."""
    return np.asarray(PchipInterpolator(x, y).derivative()(x))


def _integral(x: FloatArray, y: FloatArray, slope: FloatArray) -> FloatArray:
    """Integral of the cubic from the first row to each."""
    h = np.diff(x)
    return np.concatenate(([0.0], np.cumsum(0.5 * h * (y[1:] + y[:-1]) + h * h / 12.0 * (slope[:-1] - slope[1:]))))


def _frozen(values: npt.ArrayLike) -> FloatArray:
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def _problems(curve: Curve, elastic: bool) -> Iterator[Problem]:
    rows = curve.rows(0)
    if np.count_nonzero(curve.force[rows] > 0.0) < 3:
        yield Problem("force", curve.force[rows].tolist()[:5], "must be positive in at least 3 rows of the loading", "press deeper")
    if curve.force[rows][-1] <= 0.0:
        yield Problem("force", float(curve.force[rows][-1]), "must be positive at the end of the loading", "check its sign: compression is positive")
    if elastic:
        return
    if not curve.unloadings:
        yield Problem("unloadings", 0, "a tabulated law of a body that may yield needs at least one", "add one, or a material without yield stress")
    for branch in curve.unloadings:
        part = curve.rows(branch)
        overlap, force = curve.overlap[part], curve.force[part]
        if overlap.size < 3 or force[0] <= 0.0 or force[-1] > 0.01 * force[0]:
            yield Problem(f"branch {branch}", f"{overlap.size} rows, last force {force[-1]:.4g} N", "must run down to separation", "leave it out")
        elif (np.diff(overlap) >= 0.0).any():
            row = int(np.flatnonzero(np.diff(overlap) >= 0.0)[0]) + 1
            yield Problem(f"branch {branch} row {row}: overlap", float(overlap[row]), "must decrease on an unloading", "smooth or thin the rows")
        elif abs(np.interp(overlap[0], curve.overlap[rows], curve.force[rows]) / force[0] - 1.0) > 0.02:
            yield Problem(f"branch {branch}: force", float(force[0]), "must start within 2 % of the loading", "give the state it leaves from")
