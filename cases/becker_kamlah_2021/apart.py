"""Where the law's error comes from, each cause apart: finite bodies (elastic), loading, unloading, the size of the contact.

Differences of forces are means over the overlap that is travelled, relative to the largest force of the path: where points stand does not
count.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases.becker_kamlah_2021.data import REACH, Body
from cases.becker_kamlah_2021.own import Follow, own_law
from cases.report.judgement import Lacking
from contactlaws.curve import Curve, FloatArray
from contactlaws.path import trace
from contactlaws.rivals.becker_kamlah import BeckerKamlah, becker_kamlah_energy, becker_kamlah_loading, becker_kamlah_recovered


class Loaded(NamedTuple):
    """Of one body, along the loading up to 15 % of the mean radius."""

    name: str
    relative: float  # R_e/(r_I + r_J)
    first_yield: float  # overlap at first yield by finite elements, over the paper's delta_Y
    elastic_excess: float  # F/F_Hertz at the paper's delta_Y
    error: float  # mean difference of the published law
    signed: float  # the same with its sign
    elastic_right: float  # mean difference where up to delta_Y the force is the body's own, and beyond it what that adds stays
    refitted: float  # with lambda_max, epsilon_max read from this body
    area: float  # contact area at 15 % over that of Eq. 9
    gain: float  # work that the published law gives back over work put in, at worst
    own: float | None


class Unloaded(NamedTuple):
    """One unloading of one body beyond its first yield."""

    name: str
    relative: float
    depth: float  # largest overlap over the mean radius
    residual: float  # delta_p/delta_* by finite elements
    published: float  # by Eqs. 34 and 44
    error: float  # mean difference of the force, over the largest
    shape_error: float  # the same with the law's largest force set right
    start: float  # force of the law over that of finite elements at the start, less 1
    beta: float  # jump of the law's contact radius
    area: float  # contact area of the law just after the start over that of finite elements
    own: float | None
    own_residual: float | None


def mean_over(overlap: FloatArray, values: FloatArray) -> float:
    """Mean of `values` over the overlap that is travelled."""
    travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(overlap)))])
    return float(np.trapezoid(values, travelled) / travelled[-1])


def loading_of(law: BeckerKamlah, overlap: FloatArray) -> FloatArray:
    """Forces in N of the first loading."""
    return np.array([becker_kamlah_loading(law, float(value)) for value in overlap])


def up_to_reach(body: Body, reach: float = REACH) -> tuple[FloatArray, FloatArray]:
    """Overlap (m) and force (N) of the loading from zero to `reach` mean radii, the last row interpolated."""
    end = reach * body.mean_radius
    keep = body.overlap < end * (1.0 - 1e-9)
    overlap = np.concatenate([[0.0], body.overlap[keep], [end]])
    return overlap, np.concatenate([[0.0], body.force[keep], [np.interp(end, body.overlap, body.force)]])


def at(body: Body, overlap: float, values: FloatArray) -> float:
    """A column of the loading at an overlap (m)."""
    return float(np.interp(overlap, body.overlap, values))


def elastic_excess(body: Body, overlap: float) -> float:
    """F/F_Hertz on the loading."""
    return at(body, overlap, body.force / body.hertz(body.overlap))


def loaded(body: Body, read_from_it: BeckerKamlah) -> Loaded:
    """`read_from_it`: the law with the constants of this body."""
    overlap, force = up_to_reach(body)
    difference = (loading_of(body.law, overlap) - force) / force[-1]
    refitted = (loading_of(read_from_it, overlap) - force) / force[-1]
    end = overlap[-1]
    below = np.minimum(overlap, body.yield_overlap)
    added = np.interp(below, body.overlap, body.force, left=0.0) - loading_of(body.law, below)
    assert body.curve.yield_overlap is not None
    own = own_law(body.curve)
    return Loaded(
        name=body.name,
        relative=body.relative,
        first_yield=body.curve.yield_overlap / body.yield_overlap,
        elastic_excess=elastic_excess(body, body.yield_overlap),
        error=mean_over(overlap, np.abs(difference)),
        signed=mean_over(overlap, difference),
        elastic_right=mean_over(overlap, np.abs(difference + added / force[-1])),
        refitted=mean_over(overlap, np.abs(refitted)),
        area=at(body, end, body.contact_radius**2) / (body.radius * end),
        gain=largest_gain(body.law, body.yield_overlap),
        own=None if own is None else mean_over(overlap, np.abs(own(overlap) - force)) / force[-1],
    )


def largest_gain(law: BeckerKamlah, limit: float) -> float:
    """Work back over work in, the worst of turning back between once and eight times the overlap of first yield, in m."""
    found = [becker_kamlah_energy(law, limit * w, (limit * w,)) for w in np.geomspace(1.0 + 1e-6, 8.0, 200)]
    return max(stored / (stored + lost) for stored, lost in found)


def unloaded(body: Body, reach: float = REACH) -> list[Unloaded]:
    """Every unloading from beyond first yield, up to `reach` mean radii."""
    assert body.curve.yield_overlap is not None
    starts = {branch: float(body.curve.overlap[body.curve.rows(branch)][0]) for branch in body.curve.unloadings}
    first, last = max(body.curve.yield_overlap, body.yield_overlap), reach * body.mean_radius * (1.0 + 1e-9)
    return [_unloaded(body, branch) for branch, start in starts.items() if first < start <= last]


def _unloaded(body: Body, branch: int) -> Unloaded:
    curve, rows = body.curve, body.curve.rows(branch)
    overlap, force = curve.overlap[rows], curve.force[rows]
    top, law = float(overlap[0]), body.law
    recovered = becker_kamlah_recovered(law, top)
    path, finite = _down_to(overlap, force, top - recovered)
    published = trace(law, path).force
    largest = float(force[0])
    scaled = published * largest / float(published[0])
    limit = body.yield_overlap
    beta = 0.75 * published[0] / (law.reduced_modulus * recovered * np.sqrt(law.radius * top))
    assert curve.contact_radius is not None
    own = own_law(curve)
    left = None if own is None else _separation(own, top)
    assert top > limit
    return Unloaded(
        name=body.name,
        relative=body.relative,
        depth=top / body.mean_radius,
        residual=float(overlap[-1]) / top,
        published=1.0 - recovered / top,
        error=mean_over(path, np.abs(published - finite)) / largest,
        shape_error=mean_over(path, np.abs(scaled - finite)) / largest,
        start=float(published[0]) / largest - 1.0,
        beta=float(beta),
        area=float(beta**2 * law.radius * top / curve.contact_radius[rows][0] ** 2),
        own=None if own is None or left is None else _difference(own, overlap, force, left),
        own_residual=None if left is None else left / top,
    )


def _down_to(overlap: FloatArray, force: FloatArray, separation: float) -> tuple[FloatArray, FloatArray]:
    """An unloading by finite elements, its path (m) gone on without force to where a law separates, if that is later."""
    if separation >= overlap[-1]:
        return overlap, force
    more = np.linspace(overlap[-1], separation, 30)[1:]
    return np.concatenate([overlap, more]), np.concatenate([force, 0.0 * more])


def _difference(own: Follow, overlap: FloatArray, force: FloatArray, separation: float) -> float:
    """Mean difference of our law's force along an unloading, over the largest force."""
    path, finite = _down_to(overlap, force, separation)
    return mean_over(path, np.abs(own(path) - finite)) / float(force[0])


def _separation(own: Follow, top: float) -> float:
    """The overlap in m at which our law has no force left, unloaded from `top` (m): by halving, to a millionth."""
    low, high = 0.0, top
    while high - low > 1e-6 * top:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if own(np.array([top, middle]))[1] > 0.0 else (middle, high)
    return high


def of_shape(rows: Sequence[Unloaded], name: str) -> list[Unloaded]:
    """The unloadings of one shape; raises `Lacking`."""
    found = [row for row in rows if row.name == name]
    if not found:
        raise Lacking(f"an unloading of {name}")
    return found


def whole_path_error(curve: Curve, predicted: FloatArray, branches: Sequence[int]) -> float:
    """Mean difference of two forces (N) along loading, unloading from the first of `branches`, loading on, and so on, over the largest.

    On the way back up to where an unloading began both retrace it, the law by construction, finite elements within .1 % of the force.
    """
    length, area = 0.0, 0.0
    for branch in (0, *branches):
        rows = curve.rows(branch)
        overlap = curve.overlap[rows]
        if branch == 0:
            rows = slice(rows.start, rows.start + int(np.count_nonzero(overlap <= curve.overlap[curve.rows(branches[-1])][0] * (1 + 1e-9))))
            overlap = curve.overlap[rows]
        ways = 1 if branch in (0, branches[-1]) else 2
        way = ways * float(abs(overlap[-1] - overlap[0]))
        area += way * mean_over(overlap, np.abs(predicted[rows] - curve.force[rows]))
        length += way
    return area / length / float(curve.force[curve.rows(branches[-1])][0])
