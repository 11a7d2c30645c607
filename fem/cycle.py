"""Partial unloading and reloading: cycles from one overlap, and the loading that follows, to hold a law's reloading against.

All legs visit the same overlaps, so that two of them are compared at equal overlap without interpolation, and the ripple of landing nodes
is the same in both. The cycles start at an instant of landing, where an unloading has no ripple at all. One mesh, no extrapolation: what
counts here are differences between legs of one run, which are far smaller than the error of the mean force.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from contactlaws.errors import InputError, Problem, require
from contactlaws.material import Material
from contactlaws.version import code_version
from fem.assembly import discretise
from fem.compose import Scales
from fem.march import Steps, landings, unload
from fem.mesh import FloatArray, spheroid
from fem.newton import ByOverlap, Equilibrium, Guess, NoEquilibrium, State
from fem.press import Programme, core_size, moduli_of, problems_with_run, resolution_for

#: share of the largest force that a step of a cycle takes off: short, because what a cycle dissipates is small
FORCE_DROP = 0.04


class Leg(NamedTuple):
    """States in the order of the path, the first shared with the leg before. SI units."""

    overlap: FloatArray  # m
    force: FloatArray  # N; with the ripple of landing nodes
    stored_energy: FloatArray  # J
    dissipated_energy: FloatArray  # J


class Loop(NamedTuple):
    """One cycle."""

    share: float  # of the force at the start to which it unloads; 0: to separation
    down: Leg
    up: Leg  # the overlaps of `down` backwards


@dataclass(frozen=True)
class CycleCurve:
    """Cycles from one state of the first loading, one after the other, and the loading that goes on from there."""

    material: Material
    radius: float  # m
    aspect: float
    loops: tuple[Loop, ...]
    virgin: Leg  # first loading from the start of the cycles, never unloaded
    onward: Leg  # loading after the last cycle, at the overlaps of `virgin`
    provenance: Mapping[str, Any] = field(default_factory=dict)  # JSON types

    @property
    def start_overlap(self) -> float:
        """Overlap in m from which the cycles unload."""
        return float(self.virgin.overlap[0])

    @property
    def start_force(self) -> float:
        """Force in N there."""
        return float(self.virgin.force[0])


class Measures(NamedTuple):
    """What a cycle does that a law that reloads along its unloading curve does not."""

    hysteresis: float  # energy dissipated in the cycle over the work that its unloading gives back
    departure: float  # largest |force of reloading - force of unloading| at equal overlap, over the force at the start
    back: float  # force when it is back at the overlap it started from, over the force at the start, less 1


def measures(curve: CycleCurve, number: int) -> Measures:
    """Of cycle `number` (from 0)."""
    loop = curve.loops[number]
    given_back = -float(np.trapezoid(loop.down.force, loop.down.overlap))
    dissipated = loop.up.dissipated_energy[-1] - loop.down.dissipated_energy[0]
    return Measures(
        hysteresis=float(dissipated) / given_back,
        departure=float(np.abs(loop.up.force - loop.down.force[::-1]).max()) / curve.start_force,
        back=float(loop.up.force[-1]) / curve.start_force - 1.0,
    )


def onward_difference(curve: CycleCurve) -> float:
    """Largest relative difference of the force after the cycles from that of the virgin loading, beyond the overlap they started from."""
    return float(np.abs(curve.onward.force[1:] / curve.virgin.force[1:] - 1.0).max())


def press_cycle(
    material: Material,
    unload_from: float,
    shares: Sequence[float] = (0.5, 0.5, 0.0, 0.0),
    *,
    radius: float = 1.0,
    aspect: float = 1.0,
    beyond: float = 0.1,
    tolerance: float = 0.01,
) -> CycleCurve:
    """Press to `unload_from` (overlap over radius; the nearest instant of landing), cycle, and press on by the share `beyond` of it.

    shares: one cycle each: the share of the force to which it unloads, 0 for separation; the body is reloaded to the overlap it came from.
    Other arguments as in `fem.press`; the mesh is the finer one of that tolerance. Raises `InputError` for what cannot be computed, also if
    the solver gives up on the way.
    """
    require((*problems_with_run(material, radius, aspect, (unload_from,), None, tolerance), *_problems(unload_from, shares, beyond)))
    began = time.process_time()
    largest = unload_from * (1.0 + beyond)
    resolution = resolution_for(tolerance)
    asked = Programme((unload_from,), largest)
    body = discretise(spheroid(resolution.divisions, core_size(largest, unload_from), aspect, asked.along))
    solver = Equilibrium(body, moduli_of(material))
    legs: list[tuple[float, list[State], list[State]]] = []
    try:
        with threadpool_limits(1):
            virgin = _virgin(solver, resolution.steps, unload_from, largest)
            down = unload(solver, virgin[0], resolution.steps._replace(force_drop=FORCE_DROP))
            last = virgin[0]
            for share in shares:
                targets = _down_to(down, share)
                # the first unloading is known already
                there = _follow(solver, last, targets[1:], virgin[0].force) if legs or share > 0.0 else down
                back = _follow(solver, there[-1], targets[-2::-1], virgin[0].force)
                legs.append((share, there, back))
                last = back[-1]
            onward = _follow(solver, last, virgin[1:], virgin[0].force)
    except NoEquilibrium as reason:
        remedy = "ask for a smaller overlap, or for cycles that do not separate"
        raise InputError(Problem("unload_from", unload_from, f"the solver stops within the cycles: {reason}", remedy)) from None
    scale = Scales(radius, material.stress_unit)
    return CycleCurve(
        material,
        radius,
        aspect,
        tuple(Loop(share, _leg(there, scale), _leg(back, scale)) for share, there, back in legs),
        _leg(virgin, scale),
        _leg(onward, scale),
        {
            "code": code_version(),
            "mesh": body.section.recipe,
            "elements": int(body.cells.shape[0]),
            "statistics": vars(solver.statistics),
            "cpu_seconds": time.process_time() - began,
        },
    )


def _problems(unload_from: float, shares: Sequence[float], beyond: float) -> Iterator[Problem]:
    if not shares:
        yield Problem("shares", tuple(shares), "no cycle is asked for", "give the share of the force to which each one unloads")
    for share in shares:
        if not 0.0 <= share <= 0.98:
            yield Problem("shares", share, "must lie in [0, 0.98]", "0 unloads to separation")
    if not (math.isfinite(beyond) and beyond > 0.0 and unload_from * (1.0 + beyond) < 1.0):
        yield Problem("beyond", beyond, "must be positive and end before the body does", "0.1 presses on by a tenth of the overlap")


def _virgin(solver: Equilibrium, steps: Steps, unload_from: float, largest: float) -> list[State]:
    """First loading from the instant of landing nearest to `unload_from` to `largest` and at least one landing further."""
    before = solver.start()
    path: list[State] = []
    for _, states in landings(solver, steps):
        if path:
            path += states
        elif states[-1].overlap >= unload_from:
            nearest = before if before.overlap > 0.0 and unload_from / before.overlap < states[-1].overlap / unload_from else states[-1]
            path = [before, *states] if nearest is before else [nearest]
        before = states[-1]
        if len(path) > 1 and path[-1].overlap >= largest:
            return path
    raise NoEquilibrium("the contact reaches the end of the mesh")


def _down_to(down: Sequence[State], share: float) -> list[State]:
    """The states of an unloading with more than `share` of its first force, and one between two of them that has about this force."""
    if share == 0.0:
        return list(down)
    forces = np.array([state.force for state in down])
    last = int(np.flatnonzero(forces > share * forces[0])[-1])
    above, below = down[last], down[last + 1]
    part = (above.force - share * forces[0]) / (above.force - below.force)
    moved = above.displacement + part * (below.displacement - above.displacement)
    return [*down[: last + 1], replace(above, overlap=above.overlap + part * (below.overlap - above.overlap), displacement=moved)]


def _follow(solver: Equilibrium, start: State, targets: Sequence[State], force: float) -> list[State]:
    """From `start` (included) through the overlaps of `targets`, whose shapes are the first guesses."""
    path = [start]
    for target in targets:
        path.append(_reach(solver, path[-1], target, force))
    return path


def _reach(solver: Equilibrium, state: State, target: State, force: float, halvings: int = 10) -> State:
    """The state at the overlap of `target`: at once, or in steps halved up to `halvings` times; raises `NoEquilibrium`."""
    if target.force == 0.0:
        return solver.free_shape(state)
    try:
        like = replace(state, active=target.active.copy())
        return solver.step(like, ByOverlap(target.overlap), force, Guess(target.displacement, target.overlap))
    except NoEquilibrium:
        solver.statistics.rejected += 1
        if halvings == 0:
            raise
    half = 0.5 * (state.displacement + target.displacement)
    middle = replace(target, overlap=0.5 * (state.overlap + target.overlap), displacement=half)
    return _reach(solver, _reach(solver, state, middle, force, halvings - 1), target, force, halvings - 1)


def _leg(states: Sequence[State], scale: Scales) -> Leg:
    names = ("overlap", "force", "stored", "dissipated")
    overlap, force, stored, dissipated = (np.array([getattr(state, name) for state in states]) for name in names)
    return Leg(overlap * scale.length, force * scale.force, stored * scale.energy, dissipated * scale.energy)
