"""What any contact law must satisfy, a user's own too: `check` puts a law through it and says what it found.

failed = [finding for finding in check(law, max_overlap=0.1 * law.radius) if not finding.passed]

A law whose force depends on time (`Law.in_time`) is taken along its random paths at speeds of many decades, and kept waiting; what compares
forces at one overlap (continuity, reloading, stiffness) is asked of steps that take no time, in which nothing relaxes and no damper acts.
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
from contactlaws.path import scan, trace
from contactlaws.travel import INTEGRATION, Trip, at_once, random_trip, random_turns

FloatArray = npt.NDArray[np.float64]


class Finding(NamedTuple):
    """One property: how far the law is from it at worst, and how far it may be."""

    name: str
    passed: bool
    worst: float
    bound: float
    meaning: str  # of `worst`


def check(law: Any, max_overlap: float, paths: int = 12, seed: int = 0, duration: float = 1.0) -> list[Finding]:
    """Put `law` through all checks at overlaps up to `max_overlap` (m), on `paths` random paths.

    duration: time in s that matters to a law in time, such as a relaxation time: a path goes from turn to turn in a thousandth to a
    thousand times of it. No other law is asked for time. Raises `InputError` for a law that is not registered, or a range or duration
    that is not positive.

    >>> from contactlaws.elastic import Hertz
    >>> all(finding.passed for finding in check(Hertz(5e-6, 151.47e9), 5e-7))
    True
    """
    dispatch.law_of(law)
    if not (np.isfinite(max_overlap) and max_overlap > 0.0):
        raise InputError(Problem("max_overlap", max_overlap, "must be positive", "give the largest overlap the law is meant for, in m"))
    if not (np.isfinite(duration) and duration > 0.0):
        raise InputError(Problem("duration", duration, "must be positive", "give a time that matters to the law, in s"))
    random = np.random.default_rng(seed)
    with np.errstate(divide="ignore", invalid="ignore"):  # a law without force where there should be one fails by comparison with NaN
        return _findings(law, max_overlap, paths, random, duration)


def _findings(law: Any, max_overlap: float, paths: int, random: np.random.Generator, duration: float) -> list[Finding]:
    trips = [random_trip(law, random_turns(random, max_overlap), random, duration) for _ in range(paths)]
    return [
        _no_force_without_overlap(law, max_overlap),
        _finite(trips),
        _no_tension(trips),
        _loading_is_continuous(law, max_overlap),
        _unloading_starts_on_the_loading(law, max_overlap),
        _reloading_returns_to_the_loading(law, max_overlap),
        _work_is_accounted_for(trips),
        _nothing_undissipated(law, trips),
        _no_energy_from_closed_paths(law, random, max_overlap, paths, duration),
        _stiffness_is_bounded(law, trips),
        _compiled_equals_interpreted(law, trips[0]),
        _pair_is_symmetric(law, max_overlap, duration),
        _pair_is_two_bodies(law, max_overlap, duration),
    ]


def _finding(name: str, worst: float, bound: float, meaning: str) -> Finding:
    return Finding(name, bool(worst <= bound), float(worst), bound, meaning)


def _largest(values: Iterator[Any]) -> float:
    return max((float(np.max(value, initial=0.0)) for value in values), default=0.0)


def _no_force_without_overlap(law: Any, max_overlap: float) -> Finding:
    path = np.array([0.0, -0.5, -1e-9, 1e-9, 1.0, 0.0, -1e-3]) * max_overlap
    found = trace(law, path, np.zeros(path.size))
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
    rise = np.diff(np.log(np.maximum(at_once(law, path), 1e-300)))
    worst = 0.0
    for i in np.argsort(-abs(rise))[:10]:
        low, high = path[i], path[i + 1]
        while high - low > 1e-12 * high:
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            below, at, above = at_once(law, [low, middle, high])
            low, high = (low, middle) if abs(at - below) > abs(above - at) else (middle, high)
        below, above = at_once(law, [low, high])
        worst = max(worst, abs(above - below) / max(abs(above), 1e-300))
    return _finding("loading is continuous", worst, 1e-9, "largest relative jump of the force, at yield or elsewhere")


def _unloading_starts_on_the_loading(law: Any, max_overlap: float) -> Finding:
    worst = 0.0
    for top in np.geomspace(1e-4, 1.0, 25) * max_overlap:
        step = 1e-9 * top
        at, after = at_once(law, [top, top - step])
        worst = max(worst, (at - after) / (dispatch.stiffness_bound(law, top) * step + 1e-14 * at), (after - at) / at / 1e-14)
    return _finding("unloading starts on the loading", worst, 1.0 + 1e-4, "drop of the force over what the stiffness bound allows")


def _reloading_returns_to_the_loading(law: Any, max_overlap: float) -> Finding:
    worst = 0.0
    for top in np.geomspace(1e-4, 0.8, 25) * max_overlap:
        virgin = at_once(law, [top, 1.2 * top])
        again = at_once(law, [top, 0.99 * top, 0.5 * top, 0.995 * top, top, 1.2 * top])[-2:]
        worst = max(worst, np.max(abs(again / virgin - 1.0)))
    return _finding(
        "reloading returns to the loading", worst, 1e-12, "relative difference of the force, at and beyond the overlap of unloading"
    )


def _work_is_accounted_for(trips: list[Trip]) -> Finding:
    differences = (abs(trip.work - trip.scan.stored_energy - trip.scan.dissipated_energy) / _scale(trip) for trip in trips)
    return _finding("work is stored or dissipated", _largest(differences), 10.0 * INTEGRATION, "difference over all work on the path")


def _nothing_undissipated(law: Any, trips: list[Trip]) -> Finding:
    """A law in time knows its energy by the work that was done on it, which is known to `INTEGRATION`."""
    falls = (-np.diff(trip.scan.dissipated_energy) / _scale(trip) for trip in trips)
    bound = 10.0 * INTEGRATION if dispatch.law_of(law).in_time else 1e-12
    return _finding("dissipation never falls", _largest(falls), bound, "largest fall over all work on the path")


def _scale(trip: Trip) -> float:
    return max(float(np.sum(abs(np.diff(trip.work)))), 1e-300)


def _no_energy_from_closed_paths(law: Any, random: np.random.Generator, max_overlap: float, paths: int, duration: float) -> Finding:
    """Closed loops within a history: back at the overlap they started from, they may give back no more than the stored energy fell by;
    and nothing may give back more than was ever put in.
    """
    worst = 0.0
    for _ in range(paths):
        start = max_overlap * 10.0 ** random.uniform(-2.0, 0.0)
        loop = start * random.uniform(0.2, 1.5, 3).clip(max=max_overlap / start)
        turns = np.concatenate(([0.0, start * random.uniform(1.0, max_overlap / start)], [start], loop, [start]))
        trip = random_trip(law, turns, random, duration)
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
    if dispatch.law_of(law).in_time:
        return _finding("stiffness bound holds", _largest(_jumps(law, trip) for trip in trips), 1.0 + 1e-6, _STIFFNESS)
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
    return _finding("stiffness bound holds", worst, 1.0 + 1e-6, _STIFFNESS)


_STIFFNESS = "largest stiffness over the bound"


def _jumps(law: Any, trip: Trip) -> FloatArray:
    """What two sudden steps, a little apart, change in the force after some 50 rows of a trip, over the bound.

    Two steps and not one, since a damper's force ends with its rate.
    """
    rows = np.unique(np.linspace(1, trip.overlap.size - 1, 50).astype(int))
    largest = np.maximum.accumulate(trip.overlap)
    found = [0.0]
    for row in rows[trip.overlap[rows] > 0.0]:
        near, far = trip.overlap[row] * np.array([1.0, 1.0001 if row % 2 else 0.9999])
        forces = [_one_step(law, overlap, trip.scan.states[row]) for overlap in (near, far)]
        found.append((forces[1] - forces[0]) / (far - near) / dispatch.stiffness_bound(law, max(largest[row], far)))
    return np.array(found)


def _one_step(law: Any, overlap: float, state: FloatArray) -> float:
    """Force in N after a step from a state that is left as it is."""
    return float(trace(law, [overlap], [0.0], tuple(state)).force[0])


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


def _compiled_equals_interpreted(law: Any, trip: Trip) -> Finding:
    """On some 200 rows; the two may differ by the last digits of powers and exponentials, magnified where a small difference unloads."""
    rows = np.unique(np.linspace(0, trip.overlap.size - 1, 200).astype(int))
    path, time = trip.overlap[rows], trip.time[rows]
    found = scan(law, path, time)
    known = dispatch.law_of(law)
    force, radius, energy = interpreted(known.force), interpreted(known.contact_radius), interpreted(known.energy)
    state = dispatch.initial_state(law)
    worst, columns = 0.0, [np.nanmax(abs(column), initial=1e-300) for column in (found.force, found.contact_radius, found.stored_energy)]
    for i, overlap in enumerate(path.tolist()):
        dt = float(time[i] - time[i - 1]) if i else 0.0
        rate = (overlap - float(path[i - 1])) / dt if dt > 0.0 else 0.0
        push, state = force(law, overlap, rate, dt, state)
        values = (push, radius(law, overlap, state), energy(law, overlap, state)[0])
        differences = [
            abs(a - b[i]) / c for a, b, c in zip(values, (found.force, found.contact_radius, found.stored_energy), columns, strict=True)
        ]
        worst = max(worst, *(0.0 if np.isnan(difference) else difference for difference in differences))
    bound = dispatch.stiffness_bound(law, path.max())
    worst = max(worst, abs(interpreted(known.stiffness_bound)(law, float(path.max())) / bound - 1.0))
    note = "nothing is compiled here" if numba.config.DISABLE_JIT else "difference over the largest value"
    return _finding("compiled equals interpreted", worst, 1e-9, note)


def _pair_path(law: Any, scale: float, overlap: float, duration: float) -> tuple[float, float, float]:
    """Force, contact radius and dissipation of a pair at 0.9 `overlap`, `duration` after `overlap`."""
    state = dispatch.initial_state(law)
    functions = (pair.pair_force, pair.pair_contact_radius, pair.pair_energy)
    _, state = functions[0](law, scale, overlap, 0.0, 0.0, state)
    force, state = functions[0](law, scale, 0.9 * overlap, (0.9 * overlap - overlap) / duration, duration, state)
    return force, functions[1](law, scale, 0.9 * overlap, state), functions[2](law, scale, 0.9 * overlap, state)[1]


def _pair_is_symmetric(law: Any, max_overlap: float, duration: float) -> Finding:
    one, two = law.radius, 0.37 * law.radius
    values = [_pair_path(law, pair.pair_scale(law, *radii), max_overlap, duration) for radii in ((one, two), (two, one))]
    different = [a != b and not (np.isnan(a) and np.isnan(b)) for a, b in zip(*values, strict=True)]
    return _finding("pair is symmetric", sum(different), 0.0, "values that change when the two bodies are exchanged")


def _pair_is_two_bodies(law: Any, max_overlap: float, duration: float) -> Finding:
    """Two equal bodies at twice the overlap: the force and the contact radius of one on a flat, twice its energy."""
    scale = pair.pair_scale(law, law.radius, law.radius)
    together = np.array(_pair_path(law, scale, 2.0 * max_overlap, duration))
    alone = scan(law, np.array([max_overlap, 0.9 * max_overlap]), [0.0, duration])
    expected = np.array([alone.force[1], alone.contact_radius[1], 2.0 * alone.dissipated_energy[1]])
    known = np.isfinite(expected) & (expected != 0.0)
    worst = np.max(abs(together[known] / expected[known] - 1.0), initial=0.0)
    return _finding("pair is two bodies", worst, 1e-12, "relative difference of force, contact radius, dissipation")
