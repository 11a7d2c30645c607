"""How a law differs from a curve: the residuals that are made small, and the measures that are reported, each quantity apart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.curve import Curve
from contactlaws.path import Trace, scan, trace

FloatArray = npt.NDArray[np.float64]

#: what is fitted together, and its weight unless another is given
WEIGHTS: Mapping[str, float] = {"force": 1.0, "contact_radius": 1.0, "unloading": 1.0}
#: the error of a curve that does not state its own (an experiment), relative
UNSTATED = {"force": 0.01, "contact_radius": 0.02, "unloading_stiffness": 0.02}


class Block(NamedTuple):
    """One quantity along one branch of one curve. Its error is systematic, not one for each row: it counts as ONE datum."""

    quantity: str  # as in WEIGHTS
    curve: int
    branch: int
    measured: FloatArray
    scale: FloatArray  # one estimated error
    share: FloatArray  # of each row in the block; sums to the block's weight
    place: FloatArray  # position along the branch in lengths over which the error changes: e-folds of the overlap, or the whole unloading


class Measures(NamedTuple):
    """Relative differences between law and curves; None where the curves do not have the quantity, or the law does not give it."""

    force: float  # integral of the absolute difference along the loading over the integral of the force
    contact_radius: float | None  # the same for the contact radius
    unloading_stiffness: float | None  # root mean square over unloadings of the relative difference of 1/(d_max - d_0)
    residual_overlap: float | None  # root mean square over unloadings of the difference of d_0, over d_max
    unloading_force: float | None  # root mean square along the unloadings of the difference of F, over F at their start
    energy: float | None  # root mean square over unloadings of the relative difference of the energy given back


def follow(law: object, curve: Curve, branch: int) -> Trace:
    """The law along one branch of a curve, brought there along the loading; rows of the branch only."""
    rows = curve.rows(branch)
    path, time = curve.overlap[rows], curve.time[rows]
    before = (curve.branch == 0) & (curve.overlap < path[0]) if branch else np.zeros(curve.branch.size, dtype=bool)
    path, time = np.concatenate((curve.overlap[before], path)), np.concatenate((curve.time[before], time))
    whole = trace(law, path, time if np.all(np.diff(time) >= 0.0) else None)
    return Trace(*(column[np.count_nonzero(before) :] for column in whole))


def blocks(curves: Sequence[Curve], weights: Mapping[str, float]) -> list[Block]:
    """Everything that is fitted."""
    return [block for number, curve in enumerate(curves) for block in _blocks_of(number, curve, weights) if block.share.sum() > 0.0]


def _blocks_of(number: int, curve: Curve, weights: Mapping[str, float]) -> Iterator[Block]:
    error = {name: max(curve.errors.get(name, value), 1e-3) for name, value in UNSTATED.items()}
    for branch in (0, *curve.unloadings):
        rows = curve.rows(branch)
        overlap, force = curve.overlap[rows], curve.force[rows]
        radius = None if curve.contact_radius is None else curve.contact_radius[rows]
        if branch == 0:
            place = np.log(np.maximum(overlap, 1e-4 * overlap[-1]))
            share = _shares(place)
            yield Block("force", number, 0, force, error["force"] * (force.clip(0.0) + 0.01 * force[-1]), weights["force"] * share, place)
            if radius is not None:
                floor = radius + 0.01 * radius[-1]
                yield Block("contact_radius", number, 0, radius, error["contact_radius"] * floor, weights["contact_radius"] * share, place)
        elif overlap.size > 2 and force[0] > 0.0:
            place, one = (overlap[0] - overlap) / (overlap[0] - overlap[-1]), np.ones(overlap.size)
            share = _shares(place)
            yield Block(
                "unloading", number, branch, force / force[0], error["unloading_stiffness"] * one, weights["unloading"] * share, place
            )
            if radius is not None:
                measured = (radius / radius[0]) ** 2  # the area: the radius ends in a vertical tangent
                yield Block(
                    "contact_radius",
                    number,
                    branch,
                    measured,
                    2.0 * error["contact_radius"] * one,
                    weights["contact_radius"] * share,
                    place,
                )


def _shares(coordinate: FloatArray) -> FloatArray:
    """The part of the path that each row stands for (trapezoidal), so that where rows stand close they do not count for more."""
    step = np.diff(coordinate)
    share = np.zeros(coordinate.size)
    share[:-1] += 0.5 * step
    share[1:] += 0.5 * step
    share = np.maximum(share, 0.0)
    return share / share.sum()


def residual_vector(law: object, curves: Sequence[Curve], parts: Sequence[Block]) -> FloatArray:
    """Differences in units of the estimated error; squares sum to (number of blocks) where law and curves differ by that error
    everywhere.
    """
    followed: dict[tuple[int, int], Trace] = {}
    rows = []
    for part in parts:
        key = (part.curve, part.branch)
        if key not in followed:
            followed[key] = follow(law, curves[part.curve], part.branch)
        rows.append(np.sqrt(part.share) * (_predicted(part, followed[key]) - part.measured) / part.scale)
    return np.concatenate(rows) if rows else np.zeros(0)


def error_product(parts: Sequence[Block], jacobian: FloatArray) -> FloatArray:
    """J^T C J with C the covariance that the curves' own errors give the residuals of `residual_vector`.

    A mesh too coarse, or a force cell off by 1 %, shifts a whole curve: half the variance is common to a quantity of a curve, on all its
    branches. The other half is that of ripples, correlated as exp(-distance) along a branch with distances in `Block.place`. Neither half
    becomes smaller with more rows.
    """
    product = np.zeros((jacobian.shape[1],) * 2)
    common: dict[tuple[int, str], FloatArray] = {}
    row = 0
    for part in parts:
        weighted = np.sqrt(part.share)[:, None] * jacobian[row : row + part.share.size]
        row += part.share.size
        product += 0.5 * weighted.T @ np.exp(-abs(part.place[:, None] - part.place)) @ weighted
        key = (part.curve, part.quantity)
        common[key] = common.get(key, 0.0) + weighted.sum(axis=0)
    return product + 0.5 * sum(np.outer(total, total) for total in common.values())


def _predicted(part: Block, found: Trace) -> FloatArray:
    column = found.contact_radius if part.quantity == "contact_radius" else found.force
    if part.branch == 0:
        return column
    ratio = column / column[0] if column[0] > 0.0 else np.zeros_like(column)
    return ratio * ratio if part.quantity == "contact_radius" else ratio


def measures(law: object, curves: Sequence[Curve]) -> Measures:
    """All measures, over all curves."""
    loadings = [(curve, curve.rows(0), follow(law, curve, 0)) for curve in curves]
    force = _along([(curve.overlap[rows], curve.force[rows], found.force) for curve, rows, found in loadings])
    with_radius = [
        (curve.overlap[rows], curve.contact_radius[rows], found.contact_radius)
        for curve, rows, found in loadings
        if curve.contact_radius is not None and np.isfinite(found.contact_radius).all()
    ]
    unloadings = [
        difference
        for curve in curves
        for branch in curve.unloadings
        if (difference := _unloading_differences(law, curve, branch)) is not None
    ]
    roots = np.sqrt(np.mean(np.square(unloadings), axis=0)).tolist() if unloadings else [None] * 4
    return Measures(force, _along(with_radius) if with_radius else None, *roots)


def _along(triples: list[tuple[FloatArray, FloatArray, FloatArray]]) -> float:
    return float(
        sum(np.trapezoid(abs(law - curve), x) for x, curve, law in triples) / sum(np.trapezoid(abs(curve), x) for x, curve, _ in triples)
    )


def _unloading_differences(law: object, curve: Curve, branch: int) -> tuple[float, float, float, float] | None:
    """Differences of stiffness, residual overlap, force and energy; None for an unloading that does not end in separation."""
    rows = curve.rows(branch)
    overlap, force = curve.overlap[rows], curve.force[rows]
    if overlap.size < 3 or force[0] <= 0.0 or force[-1] > 0.01 * force[0]:
        return None
    largest, separation = float(overlap[0]), separation_overlap(law, float(overlap[0]))
    if not separation < largest or overlap[-1] >= largest:
        return None
    found = follow(law, curve, branch)
    difference = found.force / max(found.force[0], 1e-300) - force / force[0]
    given_back = float(-np.trapezoid(force, overlap))
    return (
        (largest - overlap[-1]) / (largest - separation) - 1.0,
        (separation - float(overlap[-1])) / largest,
        float(np.sqrt(np.sum(_shares(-overlap) * difference**2))),
        float(scan(law, overlap[:1]).stored_energy[0]) / given_back - 1.0,
    )


def separation_overlap(law: object, largest: float) -> float:
    """The overlap in m at which the body leaves the flat after unloading from `largest`: the force is down to 1e-9 of its start."""
    low, high = 0.0, largest
    for _ in range(60):
        middle = 0.5 * (low + high)
        force = trace(law, [largest, middle]).force
        low, high = (low, middle) if force[1] > 1e-9 * force[0] else (middle, high)
    return high
