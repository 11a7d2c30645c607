"""One run on one mesh through the rows of a programme; lengths over the half height, stresses over the material's unit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from contactlaws.prony import PronyViscoelastic
from fem.assembly import Discretisation
from fem.branch import contact_edge
from fem.march import extrapolated
from fem.mesh import FloatArray, IntArray
from fem.newton import BoolArray, ByOverlap, Equilibrium, Guess, Moduli, NoEquilibrium, State, Statistics
from fem.programme import Row
from fem.relaxing import Relaxing
from fem.release import Release

HALVINGS = 6  # of a step that finds no equilibrium
FORCE_TOLERANCE = 1e-5  # of the largest force, where the force is prescribed
SECANTS = 25


class TimeWalk(NamedTuple):
    """A run; one row per step taken, those into which a difficult one was cut included."""

    time: FloatArray  # s
    overlap: FloatArray
    force: FloatArray
    edge: FloatArray  # contact radius, to half an element
    segment: IntArray
    by_force: BoolArray  # the force was prescribed, not the overlap
    control: FloatArray  # what was prescribed
    elastic: FloatArray  # force that the shape reached would have on a body without a past
    stopped: str | None
    statistics: Statistics


class _Walker:
    """Where a run stands."""

    def __init__(self, body: Discretisation, moduli: Moduli, material: PronyViscoelastic):
        self.solver = Equilibrium(body, moduli)
        self.relaxing = Relaxing(self.solver, material)
        self.state, self.before = self.solver.start(), None  # type: State, State | None
        self.release: Release | None = None
        self.deepest = self.largest = 0.0
        self.force = 0.0

    def to(self, step: float, control: float, by_force: bool) -> None:
        """Take one step of `step` s; raises `NoEquilibrium` and stays where it is."""
        self.relaxing.begin(step)
        state = self._with_force(control / self.relaxing.scale) if by_force else self._at(control, self._ahead(control))
        self.relaxing.end(state.displacement)
        self.before, self.state = self.state, state
        self.force = max(0.0, state.force * self.relaxing.scale)
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

    def _at(self, overlap: float, guess: Guess | None = None) -> State:
        """The state at an overlap: by the factors at hand where the contact does not grow beyond what it was, else by Newton's method."""
        largest = self.largest / self.relaxing.scale
        if overlap > self.deepest:
            self.release = None
        else:
            self.release = self.release or Release(self.solver, self.state)
            try:
                state = self.release.step(self.state, overlap, largest, guess)
                if self.release.tired:
                    self.release = None
                return state
            except NoEquilibrium:
                self.release = None
        return self.solver.step(self.state, ByOverlap(overlap), largest, guess)

    def _with_force(self, target: float) -> State:
        """The state that carries the force `target`; with none, the body just touches."""
        if target <= 0.0:
            return self.solver.free_shape(self.state)
        scale = max(target, self.largest / self.relaxing.scale)
        low, state = self.state.overlap, self.state
        try:
            now = self._at(low)
            stiffness = self._stiffness(now)
        except NoEquilibrium:
            raise
        for _ in range(SECANTS):
            missing = target - now.force
            if abs(missing) <= FORCE_TOLERANCE * scale:
                return now
            step = missing / stiffness
            limit = 0.5 * max(abs(now.overlap), 1e-3 * self.solver.height * 0.02)
            wanted = now.overlap + float(np.clip(step, -limit, limit))
            state, now = now, self._at(wanted)
            if now.force > 0.0 and now.overlap != state.overlap and (now.force - state.force) / (now.overlap - state.overlap) > 0.0:
                stiffness = (now.force - state.force) / (now.overlap - state.overlap)
        raise NoEquilibrium("the force asked for is not met")

    def _stiffness(self, state: State) -> float:
        """About dF/dd."""
        if self.before is not None and self.before.overlap != self.state.overlap:
            secant = (self.state.force - self.before.force) / (self.state.overlap - self.before.overlap)
            if secant > 0.0:
                return secant
        if state.overlap > 0.0 and state.force > 0.0:
            return 1.5 * state.force / state.overlap
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
