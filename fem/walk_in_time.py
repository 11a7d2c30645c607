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
from fem.newton import ByOverlap, Equilibrium, Guess, Moduli, NoEquilibrium, State, Statistics
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
    by_force: FloatArray  # 1 where the force was prescribed
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
    found: list[tuple[float, ...]] = [(0.0,) * 7]
    stopped = None
    try:
        for before, row in zip(rows[:-1], rows[1:], strict=True):
            _advance(walker, before, row, found, HALVINGS)
            if progress:
                progress(row.time / max(rows[-1].time, 1e-300), f"time {row.time:.4g} s of {rows[-1].time:.4g}")
    except NoEquilibrium as reason:
        stopped = f"no equilibrium found beyond {found[-1][0]:.6g} s: {reason}"
    columns = np.array(found).T
    return TimeWalk(
        columns[0],
        columns[1],
        columns[2],
        columns[3],
        columns[4].astype(np.int64),
        columns[5],
        columns[6],
        stopped,
        walker.solver.statistics,
    )


def _advance(walker: _Walker, before: Row, row: Row, found: list[tuple[float, ...]], halvings: int) -> None:
    """One row, in halves where it fails."""
    try:
        walker.to(row.time - before.time, row.control, row.by_force)
    except NoEquilibrium:
        walker.solver.statistics.rejected += 1
        if halvings == 0 or before.by_force != row.by_force:
            raise
        middle = row._replace(time=0.5 * (before.time + row.time), control=0.5 * (before.control + row.control))
        _advance(walker, before, middle, found, halvings - 1)
        _advance(walker, middle, row, found, halvings - 1)
        return
    _, edge = contact_edge(walker.solver.body, walker.state)
    found.append((row.time, walker.state.overlap, walker.force, edge, row.segment, float(row.by_force), walker.elastic_force))
