"""One unloading of one mesh; from a deep overlap, the mean of two whose contact edges lie half an element apart.

As nodes land and leave one by one, the force between two landings is a sawtooth. From deep overlaps, where the body is a barrel rather
than a ball, what an unloading recovers depends by up to 2 % on where between two landings it starts (from shallow ones by .3 %, which is
let be). Two unloadings that start a quarter of the interval before and after the overlap asked for see opposite phases of that sawtooth;
their mean belongs to the overlap itself.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator

from fem.assembly import Discretisation
from fem.march import Steps, between, unload
from fem.mesh import FloatArray
from fem.newton import Equilibrium, State

DEEP = 0.12  # overlap over the half height from which an unloading is the mean of two
QUARTER = 0.25  # of the interval between two landings, in the logarithm of the overlap


class Branch(NamedTuple):
    """An unloading, state by state: the first is the one it leaves from, the last the separation. Lengths over the half height."""

    overlap: FloatArray
    force: FloatArray
    dissipated: FloatArray  # since the start
    retreat: FloatArray  # contact radius over its value at the start

    @property
    def recovered(self) -> float:
        """Overlap from the start to the separation."""
        return float(self.overlap[0] - self.overlap[-1])

    @property
    def share(self) -> FloatArray:
        """Overlap above the separation, over the recovered one: from 1 to 0."""
        return np.asarray((self.overlap - self.overlap[-1]) / self.recovered)


def contact_edge(body: Discretisation, state: State) -> tuple[int, float]:
    """Number of the outermost resting surface node and the deformed radius half way to the next; (-1, 0) if none rests."""
    surface = body.section.surface
    radius = body.section.mesh.p[0, surface] + state.displacement[surface, 0]
    resting = np.flatnonzero(state.active)
    if resting.size == 0:
        return -1, 0.0
    last = int(resting[-1])
    return last, 0.5 * float(radius[last] + radius[min(last + 1, radius.size - 1)])


def _retreat(overlap: FloatArray, place: FloatArray, radius: FloatArray) -> FloatArray:
    """Contact radius over its value at the start: while the same node is the outermost, the edge passes half way to the next one midway."""
    starts = np.flatnonzero(np.diff(place, prepend=-2) != 0)
    ends = np.append(starts[1:], overlap.size)
    middle = np.array([0.5 * (overlap[a] + overlap[b - 1]) for a, b in zip(starts, ends, strict=True)])
    middle[0], middle[-1] = overlap[0], overlap[-1]
    edge = np.minimum.accumulate(radius[starts])
    return np.asarray(PchipInterpolator(middle[::-1], edge[::-1])(overlap) / edge[0])


def from_states(body: Discretisation, states: Sequence[State]) -> Branch:
    """The branch that these states make."""
    overlap = np.array([s.overlap for s in states])
    places, radii = np.array([contact_edge(body, s) for s in states]).T
    dissipated = np.array([s.dissipated for s in states])
    return Branch(overlap, np.array([s.force for s in states]), dissipated - dissipated[0], _retreat(overlap, places, radii))


def mean(overlap: float, before: Branch, after: Branch) -> Branch:
    """The branch from `overlap` between two that start at the same distance before and after it."""
    share = before.share

    def at(values: FloatArray) -> FloatArray:
        return np.asarray(PchipInterpolator(after.share[::-1], values[::-1])(share))

    recovered = np.sqrt(before.recovered * after.recovered)
    shape = 0.5 * (before.force / before.force[0] + at(after.force / after.force[0]))
    return Branch(
        overlap=overlap - recovered * (1.0 - share),
        force=np.sqrt(before.force[0] * after.force[0]) * shape,
        dissipated=0.5 * (before.dissipated + at(after.dissipated)),
        retreat=0.5 * (before.retreat + at(after.retreat)),
    )


class Unloader:
    """Unloads from given overlaps (ascending) as the intervals between landings pass by; keeps the branches in that order."""

    def __init__(self, solver: Equilibrium, steps: Steps, unload_from: Sequence[float]):
        self.solver, self.steps = solver, steps
        self.waiting = deque(unload_from)
        self.half_done: deque[tuple[float, float, Branch]] = deque()  # where the second one starts, the overlap asked for, the first one
        self.branches: list[Branch] = []

    def interval(self, states: Sequence[State], place: int) -> None:
        """Do what starts between two landings (first and last of `states`); surface node `place` lands at the end."""
        low, high = states[0].overlap, states[-1].overlap
        shift = np.exp(QUARTER * np.log(high / low)) if low > 0.0 else 1.0
        while self.half_done and self.half_done[0][0] <= high:
            start, overlap, first = self.half_done.popleft()
            self.branches.append(mean(overlap, first, self.branch(states, place, start)))
        while self.waiting and self.waiting[0] <= (high * shift if self.waiting[0] > DEEP else high):
            overlap = self.waiting.popleft()
            if overlap <= DEEP:
                self.branches.append(self.branch(states, place, overlap))
                continue
            start = max(overlap / shift, low)
            first, second = self.branch(states, place, start), overlap * overlap / start
            if second <= high:
                self.branches.append(mean(overlap, first, self.branch(states, place, second)))
            else:
                self.half_done.append((second, overlap, first))

    def branch(self, states: Sequence[State], place: int, overlap: float) -> Branch:
        """The unloading from exactly `overlap`."""
        return from_states(self.solver.body, self.states(states, place, overlap))

    def states(self, states: Sequence[State], place: int, overlap: float) -> list[State]:
        """Its states."""
        k = max(i for i, s in enumerate(states[:-1]) if s.overlap <= overlap)
        return unload(self.solver, between(self.solver, states[k], states[k + 1], overlap, place), self.steps)
