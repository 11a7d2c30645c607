"""Paths to put a law through: random ones, with as many rows as the work done on them needs."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws import dispatch
from contactlaws.path import Scan, scan, trace

FloatArray = npt.NDArray[np.float64]

#: work along a path is integrated until the trapezoids' error is below this part of it, and compared to ten times that
INTEGRATION = 1e-6


class Trip(NamedTuple):
    """A path with everything the law does on it, and the work done on the body up to each row."""

    overlap: FloatArray
    time: FloatArray
    scan: Scan
    work: FloatArray


def random_turns(random: np.random.Generator, max_overlap: float, turns: int = 8) -> FloatArray:
    """Overlaps at which a path turns: large, small, and now and then with the contact open; from 0 to 0."""
    depths = np.where(random.random(turns) < 0.5, random.random(turns), 10.0 ** random.uniform(-4.0, 0.0, turns)) * max_overlap
    depths[random.random(turns) < 0.1] = -0.01 * max_overlap
    return np.concatenate(([0.0], depths, [0.0]))


def random_lasting(random: np.random.Generator, legs: int, duration: float) -> FloatArray:
    """Times in s from turn to turn: from a thousandth of `duration` to a thousand times of it."""
    return np.asarray(10.0 ** random.uniform(-3.0, 3.0, legs) * duration)


def random_trip(law: Any, turns: FloatArray, random: np.random.Generator, duration: float) -> Trip:
    """Through the turns at constant speed; if time counts, in random times, and every third turn is waited at."""
    if not dispatch.law_of(law).in_time:
        return travel(law, turns)
    turns = np.repeat(turns, np.where(random.random(turns.size) < 0.3, 2, 1))
    return travel(law, turns, random_lasting(random, turns.size - 1, duration))


def travel(law: Any, turns: npt.ArrayLike, lasting: npt.ArrayLike | None = None) -> Trip:
    """Follow the law from turn to turn, with rows put in until the work is known to `INTEGRATION`.

    lasting: time in s from each turn to the next, straight in between, so that rows put in do not change the rates; None: one speed.
    """
    turns = np.asarray(turns, dtype=np.float64)
    legs = abs(np.diff(turns)) / law.radius if lasting is None else np.asarray(lasting, dtype=np.float64)
    corners = np.column_stack((turns, np.concatenate(([0.0], np.cumsum(legs)))))
    path = np.concatenate([np.linspace(a, b, 33)[:-1] for a, b in zip(corners[:-1], corners[1:], strict=True)] + [corners[-1:]])
    for _ in range(40):
        finer = np.empty((2 * len(path) - 1, 2))
        finer[::2], finer[1::2] = path, 0.5 * (path[1:] + path[:-1])
        force = trace(law, *finer.T).force
        steps = np.diff(path[:, 0])
        error = abs(steps * (0.5 * (force[:-2:2] + force[2::2]) - force[1::2]))
        work = np.sum(abs(steps * force[1::2]))
        if error.sum() <= INTEGRATION * work or len(finer) > 100_000:
            break
        keep = np.ones(len(finer), dtype=bool)
        keep[1::2] = error > 0.1 * INTEGRATION * work / error.size
        path = finer[keep]
    overlap, time = np.ascontiguousarray(finer.T)
    found = scan(law, overlap, time)
    steps = np.diff(overlap)
    return Trip(overlap, time, found, np.concatenate(([0.0], np.cumsum(0.5 * steps * (found.force[1:] + found.force[:-1])))))


def at_once(law: Any, path: npt.ArrayLike) -> FloatArray:
    """Force in N along overlaps (m) that follow each other in no time."""
    return trace(law, path, np.zeros(np.shape(path))).force
