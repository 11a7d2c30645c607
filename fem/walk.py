"""One complete run on one mesh: loading, branches off it, first yield; only numbers are kept, lengths over the half height."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator

from fem.assembly import Discretisation
from fem.branch import Branch, Unloader
from fem.march import Steps, landings
from fem.mesh import FloatArray
from fem.newton import Equilibrium, Moduli, NoEquilibrium, State, Statistics

#: what to do with the states of an unloading, e.g. write the fields; arguments: overlap it leaves from, states
Visitor = Callable[[float, list[State]], None]
LANDINGS_BEYOND = 2  # the smooth readout needs data beyond the largest overlap


class Walk(NamedTuple):
    """A run. Landing rows hold the instants at which a node lands, path rows every converged loading state.

    If several nodes touch from the start (a flat top), all is smooth up to the first landing: its states are landing rows too.
    """

    landing_overlap: FloatArray
    landing_stored: FloatArray
    landing_dissipated: FloatArray
    landing_radius: FloatArray  # deformed radius of the node that lands
    landing_resting: FloatArray  # surface nodes that rest from then on
    touching: int  # surface nodes that rest from the start
    path_overlap: FloatArray
    path_force: FloatArray
    branches: tuple[Branch, ...]
    elastic: tuple[float, ...]  # overlaps asked for at which the body had not yielded: it unloads along its loading, without a branch
    yield_overlap: float | None
    yield_place: tuple[float, float] | None
    stopped: str | None
    statistics: Statistics


def _first_yield(body: Discretisation, before: State, after: State) -> tuple[float, tuple[float, float]] | None:
    """Overlap and undeformed place (r, z) at which the yield limit is first met between two states, the stress growing as a power law."""
    if before.dissipated > 0.0 or after.yield_ratio < 1.0:
        return None
    place = body.places[after.yield_place]
    if before.overlap <= 0.0 or before.yield_ratio <= 0.0:
        return after.overlap, (float(place[0]), float(place[1]))
    power = np.log(after.overlap / before.overlap) / np.log(after.yield_ratio / before.yield_ratio)
    return float(before.overlap * before.yield_ratio**-power), (float(place[0]), float(place[1]))


class _Recorder:
    """Collects the rows of a walk."""

    def __init__(self, body: Discretisation):
        self.body = body
        self.landing: list[tuple[float, float, float, float, float]] = []
        self.path: list[tuple[float, float]] = []
        self.yielded: tuple[float, tuple[float, float]] | None = None
        self.touching = 0

    def interval(self, place: int, states: Sequence[State]) -> None:
        """Take over the states from one landing (first, already known) to the next (last)."""
        for before, after in zip(states[:-1], states[1:], strict=True):
            self.path.append((after.overlap, after.force))
            self.yielded = self.yielded or _first_yield(self.body, before, after)
        if not self.landing:
            self.touching = place
            for state in states[1:-1] if place > 1 else ():
                self._row(place - 1, state, place)
        self._row(place, states[-1], place + 1)

    @property
    def yield_overlap(self) -> float:
        """Overlap at first yield, infinite if there was none up to now."""
        return self.yielded[0] if self.yielded else math.inf

    def _row(self, place: int, state: State, resting: int) -> None:
        node = self.body.section.surface[place]
        radius = float(self.body.section.mesh.p[0, node] + state.displacement[node, 0])
        self.landing.append((state.overlap, state.stored, state.dissipated, radius, float(resting)))

    def walk(self, unloader: Unloader, stopped: str | None, statistics: Statistics) -> Walk:
        """The finished record."""
        landing, path = np.array(self.landing).reshape(-1, 5).T, np.array(self.path).reshape(-1, 2).T
        yield_overlap, yield_place = self.yielded or (None, None)
        return Walk(
            landing_overlap=landing[0],
            landing_stored=landing[1],
            landing_dissipated=landing[2],
            landing_radius=landing[3],
            landing_resting=landing[4],
            touching=self.touching,
            path_overlap=path[0],
            path_force=path[1],
            branches=tuple(unloader.branches()),
            elastic=unloader.elastic,
            yield_overlap=yield_overlap,
            yield_place=yield_place,
            stopped=stopped,
            statistics=statistics,
        )


def balance(run: Walk) -> float:
    """Work of the raw force along the loading over stored plus dissipated energy, minus 1, at the last landing.

    Between landings the force is integrated by a monotone cubic: in stiff bodies it rises steeply and then bends, where others swing.
    """
    overlap, force = np.concatenate([[0.0], run.path_overlap]), np.concatenate([[0.0], run.path_force])
    landed = run.landing_overlap[run.landing_resting > run.touching]
    ends = np.concatenate([[0], np.searchsorted(overlap, landed)])
    work = 0.0
    for a, b in zip(ends[:-1], ends[1:], strict=True):
        x, y = overlap[a : b + 1], force[a : b + 1]
        work += float(PchipInterpolator(x, y).integrate(x[0], x[-1])) if x.size > 2 else float(np.trapezoid(y, x))
    return work / float(run.landing_stored[-1] + run.landing_dissipated[-1]) - 1.0


def walk(
    body: Discretisation,
    moduli: Moduli,
    max_overlap: float,
    unload_from: Sequence[float] = (),
    steps: Steps | None = None,
    progress: Callable[[float, str], None] | None = None,
    visit: Visitor | None = None,
    to_yield: bool = False,
) -> Walk:
    """Press the body to `max_overlap` (and two landings beyond), unloading on the way from each of `unload_from` (ascending).

    to_yield: end at the landing after first yield, if that comes before.

    When Newton's method fails for good the walk ends there: `stopped` says why, and all up to there is kept. An unloading that fails is
    left out, which `stopped` says too, and the loading goes on.
    """
    solver = Equilibrium(body, moduli)
    record, last, beyond, stopped = _Recorder(body), solver.start(), 0, None
    unloader = Unloader(solver, steps or Steps(), unload_from)
    seen = deque(unload_from if visit else ())
    try:
        for place, path in landings(solver, unloader.steps):
            states = [last, *path]
            record.interval(place, states)
            unloader.interval(states, place, record.yield_overlap)
            while visit and seen and seen[0] < path[-1].overlap:
                visit(seen[0], unloader.states(states, place, seen[0]))
                seen.popleft()
            last = path[-1]
            if progress:
                done = min(1.0, last.overlap / max_overlap)
                text = f"overlap {min(last.overlap, max_overlap):.4g} of {max_overlap:.4g}, {len(unloader.computed)} unloadings"
                progress(0.5 * done**0.25 + 0.5 * done, text)
            beyond += last.overlap >= max_overlap
            if beyond >= LANDINGS_BEYOND or (to_yield and record.yielded):
                break
        else:
            if last.overlap < max_overlap:
                stopped = f"one element of free surface is left at an overlap of {last.overlap:.4g}: the mesh ends"
    except NoEquilibrium as reason:
        unloaded = len(unloader.branches()) + len(unloader.elastic) + len(unloader.failed)
        if last.overlap < max_overlap or unloaded < len(unload_from):
            stopped = f"no equilibrium found beyond an overlap of {last.overlap:.4g}: {reason}"
    faults = [stopped] if stopped else []
    faults += [f"the unloading from {overlap:.4g} was given up: {reason}" for overlap, reason in unloader.failed.items()]
    stopped = "; ".join(faults) or None
    return record.walk(unloader, stopped, solver.statistics)
