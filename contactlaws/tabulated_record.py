"""The tables of the tabulated law, and what they must keep to: compiled code does not look where it reads."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.errors import Problem

FloatArray = npt.NDArray[np.float64]


class Tabulated(NamedTuple):
    """The tables; made by `contactlaws.tabulate.from_curve`, which says what each curve must have.

    One column per row of the curve. The first stored unloading is the elastic response at first yield; with none the body is elastic. The
    last two rows of `loading` and `unloading` are left out where the contact radius is not known, which is NaN then. Few arrays of two
    dimensions instead of many of one keep compiling short.
    """

    radius: float  # m
    yield_overlap: float  # m; up to here unloading follows the loading
    loading: FloatArray  # overlap (m), force (N), its slope, its integral from 0 (J), contact radius squared (m2), its slope
    stored: FloatArray  # for each unloading: d_max (m), 1/(d_max - d_0) - 1/d_max (1/m), largest slope, first column and end in `unloading`
    unloading: (
        FloatArray  # s, force over force at the start, its slope, its integral from s = 0, contact area over area at the start, its slope
    )


# rows of the tables; the slope of a quantity stands below it
OVERLAP, FORCE, WORK, AREA = 0, 1, 3, 4
LARGEST, STIFFENING, STEEPEST, FIRST, END = 0, 1, 2, 3, 4

REMEDY = "make the table from its curve again"


def problems_with(law: Tabulated) -> Iterator[Problem]:
    """What kernels must be able to rely on: shapes, finite numbers, increasing abscissae, columns that exist."""
    broken = tuple(_problems_with_shapes(law))
    yield from broken
    if broken:
        return
    with np.errstate(all="ignore"):  # what overflows fails the comparison that it is made for
        found = [*_problems_with_loading(law), *(_problems_with_stored(law) if law.stored.shape[1] else ())]
    yield from found


def _problems_with_shapes(law: Tabulated) -> Iterator[Problem]:
    for name in ("loading", "stored", "unloading"):
        table = getattr(law, name)
        if not (isinstance(table, np.ndarray) and table.ndim == 2 and table.dtype == np.float64):
            yield Problem(name, getattr(table, "shape", type(table).__name__), "must be rows of numbers of one length", REMEDY)
        elif not np.isfinite(table).all():
            yield Problem(name, "not finite", "must hold finite numbers only", REMEDY)
    if all(isinstance(table, np.ndarray) and table.ndim == 2 for table in law[2:]):
        (rows, columns), (facts, branches), (quantities, points) = (table.shape for table in law[2:])
        if rows not in (AREA, AREA + 2) or columns < 2:
            yield Problem("loading", (rows, columns), f"must have {AREA} or {AREA + 2} rows of 2 or more columns", REMEDY)
        if facts != END + 1 or branches == 1:
            yield Problem("stored", (facts, branches), f"must have {END + 1} rows of none, or 2 or more columns", REMEDY)
        if quantities != rows or (points == 0) != (branches == 0):
            yield Problem("unloading", (quantities, points), "must have the rows of loading, and columns if there are in stored", REMEDY)
    if not (math.isfinite(law.yield_overlap) and law.yield_overlap > 0.0):
        yield Problem("yield_overlap", law.yield_overlap, "must be positive", "give it in m")


def _problems_with_loading(law: Tabulated) -> Iterator[Problem]:
    overlap, force, slope, work = law.loading[:AREA]
    if not (overlap[0] > 0.0 and (np.diff(overlap) > 0.0).all()):
        yield Problem("loading: overlap", overlap[:5].tolist(), "must be positive and increase", REMEDY)
        return
    if not ((force > 0.0).all() and slope[0] > 0.0):
        yield Problem("loading: force", force[:5].tolist(), "must be positive, and rise at first", REMEDY)
        return
    before = force[0] * overlap[0] / (slope[0] * overlap[0] / force[0] + 1.0)
    if not _is_integral(overlap, force, slope, work, before):
        yield Problem("loading: work", work[:5].tolist(), "must be the integral of the force", REMEDY)
    if law.loading.shape[0] > AREA and (law.loading[AREA] < 0.0).any():
        yield Problem("loading: contact radius squared", float(law.loading[AREA].min()), "must not be negative", REMEDY)


def _problems_with_stored(law: Tabulated) -> Iterator[Problem]:
    largest, stiffening, largest_slope, first, end = law.stored
    if largest[0] != law.yield_overlap or not (np.diff(largest) > 0.0).all():
        yield Problem("stored: d_max", largest.tolist()[:5], "must start at yield_overlap and increase", REMEDY)
    if stiffening[0] < 0.0 or not (stiffening[1:] > 0.0).all():
        yield Problem("stored: 1/(d_max - d_0) - 1/d_max", stiffening.tolist()[:5], "must be positive, 0 or more in the first", REMEDY)
    edges = np.append(first, end[-1])
    columns = law.unloading.shape[1]
    if edges[0] != 0.0 or edges[-1] != columns or (end[:-1] != first[1:]).any() or (edges % 1.0).any() or (np.diff(edges) < 2.0).any():
        bound = f"must be whole numbers that divide the {columns} columns of unloading into parts of 2 or more"
        yield Problem("stored: first column and end", np.array([first, end]).T.tolist()[:5], bound, REMEDY)
        return
    for number, (start, stop) in enumerate(zip(first.astype(int), end.astype(int), strict=True)):
        yield from _problems_with_shape(number, law.unloading[:, start:stop], float(largest_slope[number]))


def _problems_with_shape(number: int, table: FloatArray, largest_slope: float) -> Iterator[Problem]:
    """One unloading: from (0, 0) to (1, 1)."""
    left, force, slope, work = table[:AREA]
    name = f"unloading {number}"
    if left[0] != 0.0 or left[-1] != 1.0 or not (np.diff(left) > 0.0).all():
        yield Problem(f"{name}: s", left[[0, -1]].tolist(), "must increase from 0 to 1", REMEDY)
        return
    if force[0] != 0.0 or abs(force[-1] - 1.0) > 1e-12:
        yield Problem(f"{name}: force", force[[0, -1]].tolist(), "must go from 0 to 1", REMEDY)
    if not _is_integral(left, force, slope, work, 0.0):
        yield Problem(f"{name}: work", work[:5].tolist(), "must be the integral of the force", REMEDY)
    if largest_slope < abs(slope).max() * (1.0 - 1e-12):
        yield Problem(f"{name}: largest slope", largest_slope, f"must be at least {abs(slope).max():.6g}, that of its force", REMEDY)


def integral(x: FloatArray, y: FloatArray, slope: FloatArray) -> FloatArray:
    """Integral of the piecewise cubic from the first row to each."""
    h = np.diff(x)
    return np.concatenate(([0.0], np.cumsum(0.5 * h * (y[1:] + y[:-1]) + h * h / 12.0 * (slope[:-1] - slope[1:]))))


def _is_integral(x: FloatArray, y: FloatArray, slope: FloatArray, work: FloatArray, before: float) -> bool:
    """Within 1e-9 of its largest value so far: the round-off of a sum is far below that, a wrong entry above."""
    expected = before + integral(x, y, slope)
    return bool(np.isfinite(expected).all() and (abs(work - expected) <= 1e-9 * np.maximum.accumulate(abs(expected))).all())
