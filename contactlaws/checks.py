"""What any contact law must satisfy, a user's own too: `check` puts a law through it and says what it found.

failed = [finding for finding in check(law, max_overlap=0.1 * law.radius) if not finding.passed]
"""

from __future__ import annotations

import types
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numba
import numpy as np
import numpy.typing as npt

from contactlaws import dispatch, pair
from contactlaws.errors import InputError, Problem
from contactlaws.path import Scan, scan, trace

FloatArray = npt.NDArray[np.float64]

#: work along a path is integrated until the trapezoids' error is below this part of it, and compared to ten times that
INTEGRATION = 1e-6


class Finding(NamedTuple):
    """One property: how far the law is from it at worst, and how far it may be."""

    name: str
    passed: bool
    worst: float
    bound: float
    meaning: str  # of `worst`


class Trip(NamedTuple):
    """A path with everything the law does on it, and the work done on the body up to each row."""

    overlap: FloatArray
    scan: Scan
    work: FloatArray


def check(law: Any, max_overlap: float, paths: int = 12, seed: int = 0) -> list[Finding]:
    """Put `law` through all checks at overlaps up to `max_overlap` (m), on `paths` random paths.

    The law must be rate-independent for the continuity and reloading checks to make sense. Raises `InputError` for a law that is not
    registered or a range that is not positive.

    >>> from contactlaws.elastic import Hertz
    >>> all(finding.passed for finding in check(Hertz(5e-6, 151.47e9), 5e-7))
    True
    """
    dispatch.law_of(law)
    if not (np.isfinite(max_overlap) and max_overlap > 0.0):
        raise InputError(Problem("max_overlap", max_overlap, "must be positive", "give the largest overlap the law is meant for, in m"))
    random = np.random.default_rng(seed)
    with np.errstate(divide="ignore", invalid="ignore"):  # a law without force where there should be one fails by comparison with NaN
        return _findings(law, max_overlap, paths, random)


def _findings(law: Any, max_overlap: float, paths: int, random: np.random.Generator) -> list[Finding]:
    trips = [travel(law, random_turns(random, max_overlap)) for _ in range(paths)]
    return [
        _no_force_without_overlap(law, max_overlap),
        _finite(trips),
        _no_tension(trips),
        _loading_is_continuous(law, max_overlap),
        _unloading_starts_on_the_loading(law, max_overlap),
        _reloading_returns_to_the_loading(law, max_overlap),
        _work_is_accounted_for(trips),
        _nothing_undissipated(trips),
        _no_energy_from_closed_paths(law, random, max_overlap, paths),
        _stiffness_is_bounded(law, trips),
        _compiled_equals_interpreted(law, trips[0].overlap),
        _pair_is_symmetric(law, max_overlap),
        _pair_is_two_bodies(law, max_overlap),
    ]


def random_turns(random: np.random.Generator, max_overlap: float, turns: int = 8) -> FloatArray:
    """Overlaps at which a path turns: large, small, and now and then with the contact open; from 0 to 0."""
    depths = np.where(random.random(turns) < 0.5, random.random(turns), 10.0 ** random.uniform(-4.0, 0.0, turns)) * max_overlap
    depths[random.random(turns) < 0.1] = -0.01 * max_overlap
    return np.concatenate(([0.0], depths, [0.0]))


def travel(law: Any, turns: npt.ArrayLike) -> Trip:
    """Follow the law from turn to turn, with rows put in until the work is known to `INTEGRATION`."""
    turns = np.asarray(turns, dtype=np.float64)
    path = np.concatenate([np.linspace(a, b, 33)[:-1] for a, b in zip(turns[:-1], turns[1:], strict=True)] + [turns[-1:]])
    for _ in range(24):
        finer = np.empty(2 * path.size - 1)
        finer[::2], finer[1::2] = path, 0.5 * (path[1:] + path[:-1])
        force = trace(law, finer, _times(law, finer)).force
        steps = np.diff(path)
        error = abs(steps * (0.5 * (force[:-2:2] + force[2::2]) - force[1::2]))
        work = np.sum(abs(steps * force[1::2]))
        if error.sum() <= INTEGRATION * work or finer.size > 100_000:
            break
        keep = np.ones(finer.size, dtype=bool)
        keep[1::2] = error > 0.1 * INTEGRATION * work / error.size
        path = finer[keep]
    found = scan(law, finer, _times(law, finer))
    steps = np.diff(finer)
    return Trip(finer, found, np.concatenate(([0.0], np.cumsum(0.5 * steps * (found.force[1:] + found.force[:-1])))))


def _times(law: Any, path: FloatArray) -> FloatArray:
    """At constant speed, so that rows put in do not change the rates."""
    return np.concatenate(([0.0], np.cumsum(abs(np.diff(path))))) / law.radius


def _finding(name: str, worst: float, bound: float, meaning: str) -> Finding:
    return Finding(name, bool(worst <= bound), float(worst), bound, meaning)


def _largest(values: Iterator[Any]) -> float:
    return max((float(np.max(value, initial=0.0)) for value in values), default=0.0)


def _no_force_without_overlap(law: Any, max_overlap: float) -> Finding:
    found = trace(law, np.array([0.0, -0.5, -1e-9, 1e-9, 1.0, 0.0, -1e-3]) * max_overlap)
    open_rows = [0, 1, 2, 5, 6]
    worst = max(abs(found.force[open_rows]).max() / found.force[4], found.force[3] / found.force[4] / 1e-6)
    forgets = not found.states.size or not found.states[open_rows].any()
    return _finding(
        "no force without overlap", worst if forgets else np.inf, 1.0, "force at 0 and at 1e-9 of the overlap, over 1e-6 of the largest"
    )


def _finite(trips: list[Trip]) -> Finding:
    columns = [
        column for trip in trips for column in (trip.scan.force, trip.scan.stored_energy, trip.scan.dissipated_energy, trip.scan.states)
    ]
    radii = [trip.scan.contact_radius for trip in trips]
    closed = [radius[trip.overlap > 0.0] for radius, trip in zip(radii, trips, strict=True)]
    unknown = all(np.isnan(radius).all() for radius in closed)  # a law may say throughout that it does not know the contact radius
    bad = sum(int(np.count_nonzero(~np.isfinite(column))) for column in columns)
    bad += 0 if unknown else sum(int(np.count_nonzero(~(radius >= 0.0) | np.isinf(radius))) for radius in radii)
    return _finding("finite", bad, 0.0, "numbers that are not finite, or contact radii below zero")


def _no_tension(trips: list[Trip]) -> Finding:
    return _finding("no tension", _largest(-trip.scan.force for trip in trips), 0.0, "largest pull in N")


def _loading_is_continuous(law: Any, max_overlap: float) -> Finding:
    """Jumps hide between rows: halve the intervals of steepest rise until only a jump can be left."""
    path = np.geomspace(1e-6, 1.0, 2001) * max_overlap
    rise = np.diff(np.log(np.maximum(trace(law, path).force, 1e-300)))
    worst = 0.0
    for i in np.argsort(-abs(rise))[:10]:
        low, high = path[i], path[i + 1]
        while high - low > 1e-12 * high:
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            below, at, above = trace(law, np.array([low, middle, high])).force
            low, high = (low, middle) if abs(at - below) > abs(above - at) else (middle, high)
        below, above = trace(law, np.array([low, high])).force
        worst = max(worst, abs(above - below) / max(abs(above), 1e-300))
    return _finding("loading is continuous", worst, 1e-9, "largest relative jump of the force, at yield or elsewhere")


def _unloading_starts_on_the_loading(law: Any, max_overlap: float) -> Finding:
    worst = 0.0
    for top in np.geomspace(1e-4, 1.0, 25) * max_overlap:
        step = 1e-9 * top
        at, after = trace(law, np.array([top, top - step])).force
        worst = max(worst, (at - after) / (dispatch.stiffness_bound(law, top) * step + 1e-14 * at), (after - at) / at / 1e-14)
    return _finding("unloading starts on the loading", worst, 1.0 + 1e-4, "drop of the force over what the stiffness bound allows")


def _reloading_returns_to_the_loading(law: Any, max_overlap: float) -> Finding:
    worst = 0.0
    for top in np.geomspace(1e-4, 0.8, 25) * max_overlap:
        virgin = trace(law, np.array([top, 1.2 * top])).force
        again = trace(law, np.array([top, 0.99 * top, 0.5 * top, 0.995 * top, top, 1.2 * top])).force[-2:]
        worst = max(worst, np.max(abs(again / virgin - 1.0)))
    return _finding(
        "reloading returns to the loading", worst, 1e-12, "relative difference of the force, at and beyond the overlap of unloading"
    )


def _work_is_accounted_for(trips: list[Trip]) -> Finding:
    differences = (abs(trip.work - trip.scan.stored_energy - trip.scan.dissipated_energy) / _scale(trip) for trip in trips)
    return _finding("work is stored or dissipated", _largest(differences), 10.0 * INTEGRATION, "difference over all work on the path")


def _nothing_undissipated(trips: list[Trip]) -> Finding:
    falls = (-np.diff(trip.scan.dissipated_energy) / _scale(trip) for trip in trips)
    return _finding("dissipation never falls", _largest(falls), 1e-12, "largest fall over all work on the path")


def _scale(trip: Trip) -> float:
    return max(float(np.sum(abs(np.diff(trip.work)))), 1e-300)


def _no_energy_from_closed_paths(law: Any, random: np.random.Generator, max_overlap: float, paths: int) -> Finding:
    """Closed loops within a history: back at the overlap they started from, they may give back no more than the stored energy fell by."""
    worst = 0.0
    for _ in range(paths):
        start = max_overlap * 10.0 ** random.uniform(-2.0, 0.0)
        loop = start * random.uniform(0.2, 1.5, 3).clip(max=max_overlap / start)
        trip = travel(law, np.concatenate(([0.0, start * random.uniform(1.0, max_overlap / start)], [start], loop, [start])))
        last, first = trip.overlap.size - 1, _last_before(trip.overlap, start)
        gained = (trip.scan.stored_energy[last] - trip.scan.stored_energy[first]) - (trip.work[last] - trip.work[first])
        worst = max(worst, gained / _scale(trip), float(np.max(-trip.work)) / _scale(trip))
    return _finding("no energy from a closed path", worst, 10.0 * INTEGRATION, "energy gained over all work on the path")


def _last_before(path: FloatArray, start: float) -> int:
    """The first row at the start of the closed loop: the first turn down to `start`."""
    peak = int(np.argmax(path >= path.max())) if path.max() > start else 0
    rows = np.flatnonzero(path == start)
    return int(rows[rows >= peak][0]) if (rows >= peak).any() and peak < rows[-1] else int(rows[0])


def _stiffness_is_bounded(law: Any, trips: list[Trip]) -> Finding:
    """Secants between rows over the bound at the largest overlap so far; rows closer than round-off can tell are left out."""
    worst = 0.0
    for trip in trips:
        step, rise = np.diff(trip.overlap), np.diff(trip.scan.force)
        largest = np.maximum.accumulate(trip.overlap)[1:]
        keep = (abs(step) > 1e-6 * largest) & (largest > 0.0)
        tops, place = np.unique(largest[keep], return_inverse=True)
        rows = np.unique(np.linspace(0, tops.size - 1, 200).astype(int))
        bounds = np.array([dispatch.stiffness_bound(law, top) for top in tops[rows]])
        above = np.searchsorted(rows, place).clip(max=rows.size - 1)  # the next overlap with a known bound: not below the right one
        worst = max(worst, float(np.max(abs(rise[keep] / step[keep]) / np.maximum.accumulate(bounds)[above], initial=0.0)))
    return _finding("stiffness bound holds", worst, 1.0 + 1e-6, "largest stiffness over the bound")


def interpreted(function: Any) -> Callable[..., Any]:
    """The plain Python form of a compiled function, with every compiled function that it calls by name plain as well."""
    plain: dict[int, Any] = {}

    def convert(value: Any) -> Any:
        source = getattr(value, "py_func", None)
        if source is None:
            return value
        if id(value) not in plain:
            scope = dict(source.__globals__)
            cells = tuple(types.CellType(convert(cell.cell_contents)) for cell in source.__closure__ or ()) or None
            copy = types.FunctionType(source.__code__, scope, source.__name__, source.__defaults__, cells)
            plain[id(value)] = copy
            scope.update({name: convert(scope[name]) for name in source.__code__.co_names if name in scope})
        return plain[id(value)]

    return convert(function)


def _compiled_equals_interpreted(law: Any, path: FloatArray) -> Finding:
    """On some 200 rows; the two may differ by the last digits of powers and exponentials, magnified where a small difference unloads."""
    rows = np.unique(np.linspace(0, path.size - 1, 200).astype(int))
    found = scan(law, path[rows])
    known = dispatch.law_of(law)
    force, radius, energy = interpreted(known.force), interpreted(known.contact_radius), interpreted(known.energy)
    state = dispatch.initial_state(law)
    worst, columns = 0.0, [np.nanmax(abs(column), initial=1e-300) for column in (found.force, found.contact_radius, found.stored_energy)]
    for i, overlap in enumerate(path[rows].tolist()):
        rate = overlap - float(path[rows[i - 1]]) if i else 0.0
        push, state = force(law, overlap, rate, 1.0 if i else 0.0, state)
        values = (push, radius(law, overlap, state), energy(law, overlap, state)[0])
        differences = [
            abs(a - b[i]) / c for a, b, c in zip(values, (found.force, found.contact_radius, found.stored_energy), columns, strict=True)
        ]
        worst = max(worst, *(0.0 if np.isnan(difference) else difference for difference in differences))
    bound = dispatch.stiffness_bound(law, path.max())
    worst = max(worst, abs(interpreted(known.stiffness_bound)(law, float(path.max())) / bound - 1.0))
    note = "nothing is compiled here" if numba.config.DISABLE_JIT else "difference over the largest value"
    return _finding("compiled equals interpreted", worst, 1e-9, note)


def _pair_path(law: Any, scale: float, overlap: float) -> tuple[float, float, float]:
    """Force, contact radius and dissipation of a pair at 0.9 `overlap` after `overlap`."""
    state = dispatch.initial_state(law)
    functions = (pair.pair_force, pair.pair_contact_radius, pair.pair_energy)
    _, state = functions[0](law, scale, overlap, 0.0, 0.0, state)
    force, state = functions[0](law, scale, 0.9 * overlap, 0.0, 0.0, state)
    return force, functions[1](law, scale, 0.9 * overlap, state), functions[2](law, scale, 0.9 * overlap, state)[1]


def _pair_is_symmetric(law: Any, max_overlap: float) -> Finding:
    one, two = law.radius, 0.37 * law.radius
    values = [_pair_path(law, pair.pair_scale(law, *radii), max_overlap) for radii in ((one, two), (two, one))]
    different = [a != b and not (np.isnan(a) and np.isnan(b)) for a, b in zip(*values, strict=True)]
    return _finding("pair is symmetric", sum(different), 0.0, "values that change when the two bodies are exchanged")


def _pair_is_two_bodies(law: Any, max_overlap: float) -> Finding:
    """Two equal bodies at twice the overlap: the force and the contact radius of one on a flat, twice its energy."""
    scale = pair.pair_scale(law, law.radius, law.radius)
    together = np.array(_pair_path(law, scale, 2.0 * max_overlap))
    alone = scan(law, np.array([max_overlap, 0.9 * max_overlap]))
    expected = np.array([alone.force[1], alone.contact_radius[1], 2.0 * alone.dissipated_energy[1]])
    known = np.isfinite(expected) & (expected != 0.0)
    worst = np.max(abs(together[known] / expected[known] - 1.0), initial=0.0)
    return _finding("pair is two bodies", worst, 1e-12, "relative difference of force, contact radius, dissipation")
