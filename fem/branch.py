"""Unloadings of one mesh, computed from instants of landing and carried to the overlaps asked for.

As nodes land and leave one by one, the force between two landings is a sawtooth, and what an unloading recovers depends by up to 2 % on
where between two landings it starts. At the instants of landing the contact edge always stands in the same place of the mesh, so what is
recovered from there has no ripple at all: over the logarithm of the overlap it is a smooth curve, on which a polynomial through the four
nearest instants finds any overlap within .1 % (measured against unloadings from every landing, E/Y 10 to 1000).

A body that has not yielded anywhere goes back the way it came: nothing is computed for it here, `fem.readout` reads its loading backwards.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator

from fem.assembly import Discretisation
from fem.march import Steps, between, unload
from fem.mesh import FloatArray
from fem.newton import Equilibrium, NoEquilibrium, State

#: rows of a branch: overlap above the separation, over the recovered one; even steps, and two more where the contact is small
SHARES = np.concatenate([np.linspace(1.0, 0.04, 25), [0.02, 0.01, 0.0]])
NEAREST = 4  # branches that make the polynomial
#: overlap over the half height beyond which an overlap asked for is given the two landings around it, and a third if there is no other near
DEEP = 0.07
#: below it, what is recovered is so nearly a power of the overlap that two branches may be this far apart (ratio of overlaps)
WIDEST_GAP = 1.6
#: while the edge passes from one surface node to the next, by a share x, the pressure on the node over that on its neighbour is
#: x/(1 + EDGE_PRESSURE x): of elastic spheres between landings, within a tenth of an element (tests/fem/test_march.py)
EDGE_PRESSURE = 0.57
HERTZ = 2.0 / 3.0  # in this power the force of an elastic unloading is straight: points are interpolated so


class Branch(NamedTuple):
    """An unloading at `SHARES`, from the state it leaves from to the separation. Lengths over the half height."""

    start: float  # overlap it leaves from
    recovered: float  # overlap from there to the separation
    raw_force: float  # at the start, with the ripple of landing nodes
    shape: FloatArray  # force over that at the start
    dissipated: FloatArray  # since the start
    retreat: FloatArray  # contact radius over its value at the start

    @property
    def overlap(self) -> FloatArray:
        """Overlap of each row."""
        return np.asarray(self.start - self.recovered * (1.0 - SHARES))

    @property
    def force(self) -> FloatArray:
        """Force of each row, with the ripple."""
        return self.raw_force * self.shape


def contact_edge(body: Discretisation, state: State) -> tuple[int, float]:
    """Number of the outermost resting surface node and the deformed radius of the contact's edge, between it and the next; (-1, 0) if none
    rests.

    The edge is at the node when that bears nothing, and at the next when that is about to land. In between it goes with the pressure on the
    outermost node over that on its neighbour, as in an elastic contact, whose pressure goes with the root of the distance from the edge.
    Just after a plastic contact begins to be let go its pressure ends more abruptly, and the edge is read up to an element too far out.
    """
    resting = np.flatnonzero(state.active)
    if resting.size == 0:
        return -1, 0.0
    last, radius = int(resting[-1]), _surface_radius(body, state)
    if last + 1 == radius.size:
        return last, float(radius[last])
    share = 0.5 if last == 0 else _share_of_element(radius, state.reaction, last)
    return last, float(radius[last] + share * (radius[last + 1] - radius[last]))


def _share_of_element(radius: FloatArray, reaction: FloatArray, last: int) -> float:
    """How far the edge is on its way from the outermost node to the next."""
    outer, inner = (reaction[node] / _tributary(radius, node) for node in (last, last - 1))
    ratio = max(0.0, outer / inner) if inner != 0.0 else 1.0
    return ratio / (1.0 - EDGE_PRESSURE * ratio) if (1.0 + EDGE_PRESSURE) * ratio < 1.0 else 1.0


def _tributary(radius: FloatArray, node: int) -> float:
    """Area over 2 pi that bears on a surface node, by its linear shape functions."""
    here, outside = radius[node], radius[node + 1]
    inside = radius[node - 1] if node > 0 else here
    return float((here - inside) * (2.0 * here + inside) + (outside - here) * (2.0 * here + outside)) / 6.0


def _surface_radius(body: Discretisation, state: State) -> FloatArray:
    surface = body.section.surface
    return np.asarray(body.section.mesh.p[0, surface] + state.displacement[surface, 0])


def _retreat(share: FloatArray, radius: FloatArray) -> FloatArray:
    """Contact radius at `SHARES` over that at the start, from those of the states; noise makes it grow on no way back."""
    values = np.minimum.accumulate(radius)
    return np.asarray(PchipInterpolator(share[::-1], values[::-1])(SHARES) / values[0])


def from_states(body: Discretisation, states: Sequence[State]) -> Branch:
    """The branch that these states make; the first is the instant at which the outermost resting node landed, the last the separation."""
    overlap, force, dissipated = (np.array([getattr(s, name) for s in states]) for name in ("overlap", "force", "dissipated"))
    recovered = float(overlap[0] - overlap[-1])
    share = (overlap - overlap[-1]) / recovered
    radii = np.array([contact_edge(body, state)[1] for state in states])
    rows = np.stack([(force / force[0]) ** HERTZ, dissipated - dissipated[0]], axis=1)
    straight, since = PchipInterpolator(share[::-1], rows[::-1])(SHARES).T
    return Branch(
        start=float(overlap[0]),
        recovered=recovered,
        raw_force=float(force[0]),
        shape=straight ** (1.0 / HERTZ),
        dissipated=since,
        retreat=_retreat(share, radii),
    )


def _weights(places: FloatArray, at: float) -> FloatArray:
    """Of the values at `places` in the polynomial through them, at `at` (Lagrange)."""
    rows = [[(at - other) / (one - other) for other in places if other != one] for one in places]
    return np.array([math.prod(row) for row in rows])


def carried(branches: Sequence[Branch], overlap: float) -> Branch:
    """The branch from `overlap`, by the polynomial in its logarithm through the nearest of `branches`."""
    near = sorted(branches, key=lambda b: abs(math.log(b.start / overlap)))[:NEAREST]
    weights = _weights(np.log([b.start for b in near]), math.log(overlap))

    def through(name: str) -> FloatArray:
        return np.asarray(weights @ np.array([getattr(b, name) for b in near]))

    return Branch(
        start=overlap,
        recovered=float(np.exp(weights @ np.log([b.recovered for b in near]))),
        raw_force=float(np.exp(weights @ np.log([b.raw_force for b in near]))),
        shape=through("shape"),
        dissipated=np.maximum.accumulate(through("dissipated")),
        retreat=np.minimum.accumulate(through("retreat")),
    )


class Unloader:
    """Chooses the landings to unload from, as they pass by, for given overlaps (ascending)."""

    def __init__(self, solver: Equilibrium, steps: Steps, unload_from: Sequence[float]):
        self.solver, self.steps, self.asked = solver, steps, tuple(unload_from)
        self.computed: list[Branch] = []
        self.failed: dict[float, str] = {}  # overlaps asked for whose unloading the solver gave up, and why
        self.elastic: tuple[float, ...] = ()  # overlaps asked for at which the body had not yielded
        self.bracketed = 0  # of the overlaps asked for
        self.before: State | None = None  # the last landing but one
        self.passed, self.newest = 0, -9  # numbers of landings: the last one, and the last one in `computed`

    def interval(self, states: Sequence[State], place: int, yield_overlap: float) -> None:
        """Do what starts between two landings (first and last of `states`); surface node `place` lands at the end.

        yield_overlap: of first yield, infinite if there was none up to now.
        """
        below, above = states[0], states[-1]
        waiting = [a for a in self.asked[self.bracketed :] if a < above.overlap]
        self.bracketed += len(waiting)
        self.passed += 1
        self.elastic += tuple(a for a in waiting if a <= yield_overlap)
        waiting = [a for a in waiting if a > yield_overlap]
        try:
            if waiting and below.overlap <= 0.0:
                # before the first landing there is no ripple, and nothing to interpolate with
                self.computed += [from_states(self.solver.body, self.states(states, place, overlap)) for overlap in waiting]
            elif waiting:
                self._around(below, above, waiting[-1] > DEEP)
        except NoEquilibrium as reason:  # the loading goes on without it
            self.failed |= dict.fromkeys(waiting, str(reason))
        self.before = below if below.overlap > 0.0 else None

    def _around(self, below: State, above: State, deep: bool) -> None:
        """Unload from the landing before an overlap asked for, and where need be from the one after it and the one before that."""
        if deep and self.newest < self.passed - 3 and self.before is not None:
            self._unload(self.before, self.passed - 2)
        self._unload(below, self.passed - 1)
        if deep or self._next_asked() > below.overlap * WIDEST_GAP:
            self._unload(above, self.passed)

    def _next_asked(self) -> float:
        return self.asked[self.bracketed] if self.bracketed < len(self.asked) else math.inf

    def _unload(self, landing: State, number: int) -> None:
        if number > self.newest:
            self.computed.append(from_states(self.solver.body, unload(self.solver, landing, self.steps)))
            self.newest = number

    def branches(self) -> list[Branch]:
        """One for each overlap asked for, as far as there are landings around it."""
        if not self.computed:
            return []
        without = {*self.failed, *self.elastic}
        found = (a for a in self.asked[: self.bracketed] if a not in without and a <= self.computed[-1].start)
        return [carried(self.computed, a) for a in found]

    def states(self, states: Sequence[State], place: int, overlap: float) -> list[State]:
        """Those of the unloading from exactly `overlap`, between two landings (first and last of `states`; `place` lands at the end)."""
        k = max(i for i, s in enumerate(states[:-1]) if s.overlap <= overlap)
        return unload(self.solver, between(self.solver, states[k], states[k + 1], overlap, place), self.steps)
