"""One run on one mesh through the rows of a programme; lengths over the half height, stresses over the material's unit."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from contactlaws.prony import PronyViscoelastic
from fem.assembly import Discretisation
from fem.branch import contact_edge
from fem.march import extrapolated
from fem.mesh import FloatArray, IntArray
from fem.newton import PENETRATION, BoolArray, ByOverlap, Equilibrium, Guess, Moduli, NoEquilibrium, State, Statistics
from fem.programme import Row
from fem.relaxing import Relaxing
from fem.release import Release

HALVINGS = 10  # of a step that finds no equilibrium
FORCE_TOLERANCE = 1e-5  # of the largest force, where the force is prescribed
SECANTS = 40
FIRST_OVERLAP = 2e-5  # over the half height: how far a force is sought at first from where the body just touches


class TimeWalk(NamedTuple):
    """A run; one row per step taken, those into which a difficult one was cut included."""

    time: FloatArray  # s
    overlap: FloatArray
    force: FloatArray
    edge: FloatArray  # contact radius, see `fem.branch.contact_edge`
    segment: IntArray
    by_force: BoolArray  # the force was prescribed, not the overlap
    control: FloatArray  # what was prescribed
    elastic: FloatArray  # force that the shape reached would have on a body without a past
    stopped: str | None
    statistics: Statistics

    def up_to(self, time: float, stopped: str | None) -> TimeWalk:
        """Without the rows after `time` (s), where it is said to have `stopped`."""
        rows = int(np.searchsorted(self.time, time, side="right"))
        kept: dict[str, Any] = {name: value[:rows] for name, value in self._asdict().items() if isinstance(value, np.ndarray)}
        return self._replace(stopped=stopped, **kept)


class _Walker:
    """Where a run stands."""

    def __init__(self, body: Discretisation, moduli: Moduli, material: PronyViscoelastic):
        self.solver = Equilibrium(body, moduli)
        self.relaxing = Relaxing(self.solver, material)
        self.state, self.before = self.solver.start(), None  # type: State, State | None
        self.release: Release | None = None
        self.rested = self.state.active  # surface nodes that have ever been on the flat
        self.deepest = self.largest = 0.0
        self.force = 0.0

    def to(self, step: float, control: float, by_force: bool) -> None:
        """Take one step of `step` s; raises `NoEquilibrium` and stays where it is."""
        self.relaxing.begin(step)
        state = self._with_force(control / self.relaxing.scale) if by_force else self._at(control, self.state, self._ahead(control))
        self.relaxing.end(state.displacement)
        self.before, self.state, self.rested = self.state, state, self.rested | state.active
        self.force = max(0.0, state.force * self.relaxing.scale) if state.active.any() else 0.0  # not what the residuals sum up to
        self.largest, self.deepest = max(self.largest, self.force), max(self.deepest, state.overlap)

    @property
    def elastic_force(self) -> float:
        """Of the last shape, on the mid-plane."""
        return float(self.relaxing.elastic.sum(axis=0)[self.solver.midplane_dofs].sum())

    def _ahead(self, overlap: float) -> Guess | None:
        """The body moved on as in the last step, if it goes on in the same way."""
        if self.before is None:
            return None
        walked, wanted = self.state.overlap - self.before.overlap, overlap - self.state.overlap
        if walked == 0.0 or not 0.0 < wanted / walked < 4.0:
            return None
        return extrapolated(self.solver, self.before, self.state, wanted / walked)

    def _at(self, overlap: float, start: State, guess: Guess | None = None) -> State:
        """The state at an overlap, sought from `start`: by factors where the contact does not grow beyond what it was, else by Newton's
        method."""
        if overlap > self.deepest:
            self.release = None
        else:
            for _ in range(1 if self.release is None else 2):  # with the factors at hand, then with new ones
                try:
                    return self._by_factors(overlap, start, guess)
                except NoEquilibrium:
                    self.release = None
        return self.solver.step(start, ByOverlap(overlap), self.largest / self.relaxing.scale, guess)

    def _by_factors(self, overlap: float, start: State, guess: Guess | None) -> State:
        """The same by `Release`, where no node rests that never did; raises `NoEquilibrium`."""
        release = self.release or Release(self.solver, replace(start, active=self.rested))
        state = release.step(start, overlap, self.largest / self.relaxing.scale, guess)
        if self.solver.gaps(state.displacement).min() < -max(PENETRATION * abs(overlap), 1e-14):
            raise NoEquilibrium("a node lands that did not rest before")  # `Release` does not look while none rests
        self.release = None if release.tired else release
        return state

    def _with_force(self, target: float) -> State:
        """The state that carries the force `target`, by secants kept between what is too little and what too much; with none, the body
        just touches."""
        if target <= 0.0:
            return self.solver.free_shape(self.state)
        accuracy = max(FORCE_TOLERANCE * max(target, self.largest / self.relaxing.scale), self.solver.round_off)
        now, stiffness = self._near(), self._stiffness()
        low, high = -math.inf, math.inf
        limit = 0.5 * max(abs(now.overlap), FIRST_OVERLAP * self.solver.height)
        for _ in range(SECANTS):
            missing = target - now.force
            if abs(missing) <= accuracy:
                return now
            low, high = (now.overlap, high) if missing > 0.0 else (low, now.overlap)
            ahead = now.overlap + missing / stiffness
            ahead = ahead if low < ahead < high else 0.5 * (low + high)
            ahead = now.overlap + float(np.clip(ahead - now.overlap, -limit, limit))
            try:
                last, now, limit = now, self._at(ahead, now), 2.0 * limit
            except NoEquilibrium:
                limit = 0.25 * abs(ahead - now.overlap)
                continue
            slope = (now.force - last.force) / (now.overlap - last.overlap)
            stiffness = slope if slope > 0.0 else stiffness
        raise NoEquilibrium("the force asked for is not met")

    def _near(self) -> State:
        """The body with the flat where it was, or where it touches if the body has left it."""
        now = self._at(self.state.overlap, self.state)
        return now if now.active.any() else self.solver.free_shape(self.state)

    def _stiffness(self) -> float:
        """About dF/dd: of the last step, or of a contact that carries a little."""
        if self.before is not None and self.before.overlap != self.state.overlap:
            secant = (self.state.force - self.before.force) / (self.state.overlap - self.before.overlap)
            if secant > 0.0:
                return secant
        bulk, shear, _ = self.solver.moduli
        return 2.0 * shear * (3.0 * bulk + shear) / (3.0 * bulk + 4.0 * shear) * 0.02 * self.solver.height


def walk_in_time(
    body: Discretisation,
    moduli: Moduli,
    material: PronyViscoelastic,
    rows: Sequence[Row],
    progress: Callable[[float, str], None] | None = None,
) -> TimeWalk:
    """Take the body through `rows` (overlap over the half height, force in the unit of the moduli times its square).

    Where a step fails at last, the run ends: `stopped` says why, and all up to there is kept.
    """
    walker = _Walker(body, moduli, material)
    found: list[tuple[float, ...]] = [(0.0,) * 8]
    stopped, segment, start = None, 0, 0.0
    try:
        for row in rows:
            if row.segment != segment:
                reached = walker.force if row.by_force else walker.state.overlap
                segment, start = row.segment, reached if row.start is None else row.start
                control = start
            before, control = control, start + row.share * (row.target - start)
            _advance(walker, found[-1][0], row.time, before, control, row, found, HALVINGS)
            if progress:
                progress(row.time / max(rows[-1].time, 1e-300), f"time {row.time:.4g} s of {rows[-1].time:.4g}")
    except NoEquilibrium as reason:
        stopped = f"no equilibrium found beyond {found[-1][0]:.6g} s: {reason}"
    time, overlap, force, edge, numbers, by_force, controls, elastic = np.array(found).T
    return TimeWalk(
        time, overlap, force, edge, numbers.astype(np.int64), by_force > 0.0, controls, elastic, stopped, walker.solver.statistics
    )


def _advance(
    walker: _Walker, begin: float, end: float, before: float, control: float, row: Row, found: list[tuple[float, ...]], halvings: int
) -> None:
    """From `begin` to `end` (s), the control going from `before` to `control`; in halves where that fails."""
    try:
        walker.to(end - begin, control, row.by_force)
    except NoEquilibrium:
        walker.solver.statistics.rejected += 1
        if halvings == 0:
            raise
        middle, between = 0.5 * (begin + end), 0.5 * (before + control)
        _advance(walker, begin, middle, before, between, row, found, halvings - 1)
        _advance(walker, middle, end, between, control, row, found, halvings - 1)
        return
    _, edge = contact_edge(walker.solver.body, walker.state)
    where = (float(row.segment), float(row.by_force), control, walker.elastic_force)
    found.append((end, walker.state.overlap, walker.force, edge, *where))
