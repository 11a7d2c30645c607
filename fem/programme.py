"""What is done to a body in time: knots between which the overlap, or the force, goes straight."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from contactlaws.errors import Problem


class Knot(NamedTuple):
    """The end of a segment; exactly one of overlap and force is given."""

    time: float  # s
    overlap: float | None = None  # m; negative: the flat stands off the undeformed body
    force: float | None = None  # N; 0: the flat just touches


Programme = tuple[Knot, ...]
START = Knot(0.0, 0.0)


def ramp_hold_release(overlap: float, ramp: float, hold: float = 0.0, release: float | None = None, end: float = 0.0) -> Programme:
    """To `overlap` (m) in `ramp` s, there for `hold` s, and (unless None) to the overlap `end` in `release` s.

    >>> [knot.time for knot in ramp_hold_release(1e-7, 1.0, 6.5, 0.5)]
    [0.0, 1.0, 7.5, 8.0]
    """
    knots = [START, Knot(ramp, overlap)]
    if hold > 0.0:
        knots.append(Knot(ramp + hold, overlap))
    if release is not None:
        knots.append(Knot(ramp + hold + release, end))
    return tuple(knots)


def creep(force: float, ramp: float, hold: float, recovery: float | None = None) -> Programme:
    """`force` (N) built up in `ramp` s and held for `hold` s; then (unless None) taken off as fast and nothing for `recovery` s."""
    knots = [START, Knot(ramp, force=force), Knot(ramp + hold, force=force)]
    if recovery is not None:
        knots += [Knot(2.0 * ramp + hold, force=0.0), Knot(2.0 * ramp + hold + recovery, force=0.0)]
    return tuple(knots)


def staircase(overlaps: Sequence[float], ramp: float, hold: float) -> Programme:
    """To each of `overlaps` (m) in `ramp` s, with `hold` s there."""
    knots = [START]
    for overlap in overlaps:
        knots.append(Knot(knots[-1].time + ramp, overlap))
        knots.append(Knot(knots[-1].time + hold, overlap))
    return tuple(knots)


def sine(mean: float, amplitude: float, period: float, cycles: float, knots_per_cycle: int = 24) -> Programme:
    """Overlap (m) `mean` + `amplitude` sin(2 pi t/period) after a ramp to `mean` in a quarter of a period; in straight pieces."""
    pieces = max(1, round(cycles * knots_per_cycle))
    start = 0.25 * period
    angles = [2.0 * math.pi * cycles * k / pieces for k in range(1, pieces + 1)]
    wave = [Knot(start + period * angle / (2.0 * math.pi), mean + amplitude * math.sin(angle)) for angle in angles]
    return (START, Knot(start, mean), *wave)


def problems_with_programme(programme: Programme, radius: float) -> Iterator[Problem]:
    """What is wrong with the knots, one `Problem` each."""
    if len(programme) < 2:
        yield Problem(
            "programme", f"{len(programme)} knots", "needs a knot after the start", "give at least two rows: time, and overlap or force"
        )
        return
    found = [problem for number, knot in enumerate(programme, 1) for problem in _problems_with_knot(f"programme[{number}]", knot, radius)]
    if programme[0] != START and not found:
        found.append(Problem("programme[1]", tuple(programme[0]), "must be time 0 and overlap 0", "let it begin where the flat touches"))
    for number, (before, knot) in enumerate(pairwise(programme), 2):
        if knot.time < before.time or (knot.time == before.time and knot == before):
            bound = f"must rise, and comes after {before.time:g} s"
            found.append(Problem(f"programme[{number}]: time", knot.time, bound, "order the rows in time"))
    if not found and all((knot.overlap or knot.force or 0.0) <= 0.0 for knot in programme):
        found.append(Problem("programme", f"{len(programme)} knots", "never touches the body", "let an overlap or a force be positive"))
    yield from found


def _problems_with_knot(name: str, knot: Knot, radius: float) -> Iterator[Problem]:
    """The first thing that is wrong with one knot by itself."""
    given = [value for value in (knot.overlap, knot.force) if value is not None]
    if len(given) != 1:
        yield Problem(name, tuple(knot), "must have exactly one of overlap and force", "leave the other one empty")
    elif not all(math.isfinite(value) for value in (knot.time, *given)):
        yield Problem(name, tuple(knot), "must be made of finite numbers", "repair the row")
    elif knot.overlap is not None and not abs(knot.overlap) < radius:
        yield Problem(name, knot.overlap, f"must be smaller than the radius, {radius:g} m", "give the overlap in m")
    elif knot.force is not None and knot.force < 0.0:
        yield Problem(name, knot.force, "must not be negative: the flat does not pull", "0 lets it just touch")


#: of more segments than `MANY` each is taken in fewer steps, but no fewer than `FEWEST`
MANY, FEWEST = 8, 3


class Row(NamedTuple):
    """One step of a run: where it ends, and how it is controlled."""

    time: float  # s
    by_force: bool
    target: float  # overlap in m, or force in N, at the end of the segment
    share: float  # of the segment, done at the end of this step
    segment: int  # number of the knot it leads to
    start: float | None  # control at the start of the segment; None: what the run has come to


def rows(programme: Programme, shortest: float, steps: int) -> list[Row]:
    """The steps of a programme: `steps` a segment (fewer where there are many), even in time where the control moves.

    Where it is held they grow in proportion to the time since it began, from a hundredth of the `shortest` relaxation time (s) on.
    """
    found: list[Row] = []
    steps = max(FEWEST, round(steps * min(1.0, MANY / (len(programme) - 1))))
    for number, (before, knot) in enumerate(pairwise(programme), 1):
        by_force = knot.force is not None
        target = knot.force if knot.force is not None else knot.overlap
        start = before.force if by_force else before.overlap
        if before == START:
            start = 0.0
        assert target is not None
        span = knot.time - before.time
        if start == target and span > 0.0:
            shares = np.geomspace(max(0.01 * min(1.0, shortest / span), 1e-300), 1.0, steps)
        else:
            shares = np.linspace(0.0, 1.0, steps + 1)[1:]
        found += [Row(before.time + span * share, by_force, target, share, number, start) for share in shares.tolist()]
    return found
