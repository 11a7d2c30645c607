"""From a curve to the tables of `contactlaws.tabulated`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PchipInterpolator

from contactlaws.curve import Curve
from contactlaws.errors import Problem, require
from contactlaws.path import trace
from contactlaws.tabulated import steepest
from contactlaws.tabulated_record import AREA, FORCE, Tabulated, integral

FloatArray = npt.NDArray[np.float64]


def from_curve(curve: Curve) -> Tabulated:
    """The tabulated law of a loading with unloadings; purely elastic (the loading alone) if the material has no yield stress.

    Rows before the first positive force are left out. Raises `InputError` for a curve of a body that yields without unloadings, or with an
    unloading that does not run down to separation or turns back on its way. Unloadings from before first yield follow the loading.
    """
    elastic = curve.material is not None and curve.material.yield_stress is None
    require(_problems(curve, elastic))
    rows = curve.rows(0)
    keep = _pressed(curve)
    overlap, force = curve.overlap[rows][keep], curve.force[rows][keep]
    slope = _slopes(overlap, force)
    # below the first row the force is a power of the overlap; a measured first row may suggest any, Hertz's is 1.5
    power = np.clip(slope[0] * overlap[0] / force[0], 1.0, 3.0)
    slope[0] = power * force[0] / overlap[0]
    work = integral(overlap, force, slope) + force[0] * overlap[0] / (power + 1.0)
    area = None if curve.contact_radius is None else curve.contact_radius[rows][keep] ** 2
    loading = _frozen([overlap, force, slope, work, *([] if area is None else [area, _slopes(overlap, area)])])
    none = Tabulated(float(curve.radius), float(overlap[0]), loading, _frozen(np.zeros((5, 0))), _frozen(np.zeros((loading.shape[0], 0))))
    if elastic:
        return none
    branches = sorted(curve.unloadings, key=lambda branch: curve.overlap[curve.rows(branch)][0])
    yield_overlap = float(overlap[0] if curve.yield_overlap is None else curve.yield_overlap)
    # an unloading from before first yield follows the loading; its rows could only add their own small error
    branches = [branch for branch in branches if curve.overlap[curve.rows(branch)][0] > yield_overlap]
    if not branches:
        return none
    tables = [_elastic_shape(none, yield_overlap), *(_unloading(curve, branch) for branch in branches)]
    ends = np.cumsum([0, *(table.shape[1] for table in tables)])
    states = [(yield_overlap, 0.0), *(_state(curve, branch) for branch in branches)]
    stored = [(*state, _steepest(table), *ends[k : k + 2]) for k, (state, table) in enumerate(zip(states, tables, strict=True))]
    return none._replace(yield_overlap=yield_overlap, stored=_frozen(np.array(stored).T), unloading=_frozen(np.concatenate(tables, axis=1)))


def _pressed(curve: Curve) -> npt.NDArray[np.bool_]:
    """The rows of the loading from which on the force stays positive."""
    rows = curve.rows(0)
    return (curve.overlap[rows] > 0.0) & (np.minimum.accumulate(curve.force[rows][::-1])[::-1] > 0.0)


def _elastic_shape(elastic: Tabulated, yield_overlap: float) -> FloatArray:
    """The loading up to first yield, normalised as the unloadings are; it matters between first yield and the first stored unloading
    only.
    """
    left = np.linspace(0.0, 1.0, 33) ** 2
    found = trace(elastic, left * yield_overlap)
    return _normalised(left, found.force / found.force[-1], None if elastic.loading.shape[0] <= AREA else found.contact_radius)


def _unloading(curve: Curve, branch: int) -> FloatArray:
    """The normalised rows of one unloading, from separation up."""
    rows = curve.rows(branch)
    overlap, force = curve.overlap[rows][::-1], curve.force[rows][::-1]
    ratio = force / force[-1]
    ratio[0] = 0.0  # a measured separation may keep a small force; the shape starts at exactly 0
    radius = None if curve.contact_radius is None else curve.contact_radius[rows][::-1]
    return _normalised((overlap - overlap[0]) / (overlap[-1] - overlap[0]), ratio, radius)


def _normalised(left: FloatArray, ratio: FloatArray, radius: FloatArray | None) -> FloatArray:
    """The rows of `Tabulated.unloading`."""
    columns = [ratio] if radius is None else [ratio, (radius / radius[-1]) ** 2]
    slope, *others = _slopes(left, np.array(columns).T).T
    return np.array([left, ratio, slope, integral(left, ratio, slope), *columns[1:], *others])


def _state(curve: Curve, branch: int) -> tuple[float, float]:
    """Largest overlap, and what plasticity adds to 1/(d_max - d_0)."""
    overlap = curve.overlap[curve.rows(branch)]
    # a body that has hardly yielded may seem to give back all of the overlap: at least 1e-6 of it is taken to stay
    return float(overlap[0]), float(max(1.0 / (overlap[0] - overlap[-1]) - 1.0 / overlap[0], 1e-6 / overlap[0]))


def _steepest(table: FloatArray) -> float:
    return max(steepest(table, FORCE, i) for i in range(table.shape[1] - 1))


def _slopes(x: FloatArray, y: FloatArray) -> FloatArray:
    """Slopes of the monotone cubic at its rows; y may have several columns."""
    return np.asarray(PchipInterpolator(x, y)(x, 1))


def _frozen(values: npt.ArrayLike) -> FloatArray:
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def _problems(curve: Curve, elastic: bool) -> Iterator[Problem]:
    rows = curve.rows(0)
    if np.count_nonzero(_pressed(curve)) < 3:
        bound = "must be positive in at least the last 3 rows of the loading, at a positive overlap"
        yield Problem("force", curve.force[rows].tolist()[-5:], bound, "press deeper")
    if curve.force[rows][-1] <= 0.0:
        yield Problem(
            "force", float(curve.force[rows][-1]), "must be positive at the end of the loading", "check its sign: compression is positive"
        )
    if elastic:
        return
    if not curve.unloadings:
        yield Problem(
            "unloadings", 0, "a tabulated law of a body that may yield needs at least one", "add one, or a material without yield stress"
        )
    starts = [float(curve.overlap[curve.rows(branch)][0]) for branch in curve.unloadings]
    for start in sorted(start for start in set(starts) if starts.count(start) > 1):
        yield Problem("unloadings", start, "only one may start from an overlap", "leave out the others from there")
    for branch in curve.unloadings:
        part = curve.rows(branch)
        overlap, force = curve.overlap[part], curve.force[part]
        if overlap.size < 3 or force[0] <= 0.0 or force[-1] > 0.01 * force[0]:
            yield Problem(
                f"branch {branch}", f"{overlap.size} rows, last force {force[-1]:.4g} N", "must run down to separation", "leave it out"
            )
        elif (np.diff(overlap) >= 0.0).any():
            row = int(np.flatnonzero(np.diff(overlap) >= 0.0)[0]) + 1
            yield Problem(
                f"branch {branch} row {row}: overlap", float(overlap[row]), "must decrease on an unloading", "smooth or thin the rows"
            )
        elif abs(np.interp(overlap[0], curve.overlap[rows], curve.force[rows]) / force[0] - 1.0) > 0.02:
            yield Problem(
                f"branch {branch}: force", float(force[0]), "must start within 2 % of the loading", "give the state it leaves from"
            )
