"""Loading from landing to landing, and unloading from any state to separation.

Between two landings the set of resting nodes is fixed and all is smooth; at the instant of a landing the contact edge is exactly at a node
and its force is zero. Each interval is crossed by a short first step (the node that has just landed begins to carry), growing ones after
it, each predicted from the last, and one onto the next landing itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fem.newton import ByGap, ByOverlap, Equilibrium, Guess, NoEquilibrium, State
from fem.release import Release

SMALLEST = 1e-4  # a step is not cut below this share of the first one tried


class Steps(NamedTuple):
    """How finely a path is walked."""

    first: float = 0.1  # first step after a landing, as a share of the expected interval
    growth: float = 2.0  # of the following ones, at most
    force_drop: float = 0.25  # share of the largest force that an unloading step takes off
    tail: float = 0.6  # and of the force that is left, at most


def extrapolated(solver: Equilibrium, before: State, state: State, factor: float) -> Guess:
    """The state reached by going on as from `before` to `state`, `factor` times as far."""
    change = state.displacement - before.displacement
    change[solver.body.section.surface[state.active], 1] = 0.0
    return Guess(state.displacement + factor * change, state.overlap + factor * (state.overlap - before.overlap))


def _next_step(solver: Equilibrium, before: State | None, state: State, place: int, step: float) -> tuple[ByGap | ByOverlap, Guess | None]:
    """Onto the landing if the gap is about to close within `step`, else `step` further, with a first guess."""
    ahead = ByOverlap(state.overlap + step)
    if before is None:
        return ahead, None
    gap, last_gap = solver.gaps(state.displacement)[place], solver.gaps(before.displacement)[place]
    walked = state.overlap - before.overlap
    if 0.0 < gap <= (last_gap - gap) * step / walked:
        return ByGap(place, 0.0), extrapolated(solver, before, state, gap / (last_gap - gap))
    return ahead, extrapolated(solver, before, state, step / walked)


def interval(
    solver: Equilibrium, start: State, place: int, expected: float, largest_force: float, steps: Steps, before: State | None = None
) -> list[State]:
    """The states from `start` (not included) to the landing of surface node number `place`, about `expected` in overlap away.

    before: the state before `start`; the first step is predicted from how the body moved between them.
    Raises `NoEquilibrium` when no step, however small, succeeds.
    """
    path: list[State] = [start]
    step = steps.first * expected
    while True:
        control, guess = _next_step(solver, path[-2] if len(path) > 1 else before, path[-1], place, step)
        try:
            new = solver.step(path[-1], control, largest_force, guess, free=place)
        except NoEquilibrium:
            solver.statistics.rejected += 1
            step *= 0.25
            if step < SMALLEST * steps.first * expected:
                raise
            continue
        if isinstance(control, ByGap):
            active = new.active.copy()
            active[place] = True
            return [*path[1:], replace(new, active=active)]
        if solver.gaps(new.displacement)[place] <= 0.0:
            step *= 0.25  # gone beyond the landing
            if step < SMALLEST * steps.first * expected:
                raise NoEquilibrium("a surface node rests before its turn to land")
            continue
        step = min(steps.growth * (new.overlap - path[-1].overlap), expected)
        path.append(new)


def landings(solver: Equilibrium, steps: Steps) -> Iterator[tuple[int, list[State]]]:
    """Walk outwards over the surface nodes: for each, its place and the states since the landing before it, the last its own landing.

    Ends when one element of free surface is left; raises `NoEquilibrium` when the solver gives up.
    """
    state, before, just_before, largest = solver.start(), None, None, 0.0
    radius = solver.body.section.mesh.p[0, solver.body.section.surface]
    # the free surface cannot fold within its last element: the node above the mid-plane lands when next to nothing is left of the body
    for place in range(int(np.count_nonzero(state.active)), radius.size - 2):
        if before is None or before.overlap <= 0.0:
            expected = max(float(solver.gaps(state.displacement)[place]), 1e-12)
        else:
            expected = (state.overlap - before.overlap) * min(1.5, state.overlap / before.overlap)
        path = interval(solver, state, place, expected, largest, steps, just_before)
        before, just_before, state = state, [state, *path][-2], path[-1]
        largest = max(largest, state.force)
        yield place, path


def between(solver: Equilibrium, below: State, above: State, overlap: float, free: int | None) -> State:
    """The state at `overlap` from the two neighbouring ones of a path; surface node `free` is the one about to land.

    It is a branch off the path, which it leaves as it is. Raises `NoEquilibrium`.
    """
    state, share = below, 1.0
    while state.overlap < overlap:
        target = state.overlap + share * (overlap - state.overlap) if share < 1.0 else overlap
        part = (target - state.overlap) / (above.overlap - state.overlap)
        guess = Guess(state.displacement + part * (above.displacement - state.displacement), target)
        try:
            state, share = solver.step(state, ByOverlap(target), above.force, guess, free=free), min(1.0, 2.0 * share)
        except NoEquilibrium:
            solver.statistics.rejected += 1
            share *= 0.25
            if share < SMALLEST:
                raise
    return state


def unload(solver: Equilibrium, start: State, steps: Steps, smallest: float = 0.006) -> list[State]:
    """From `start` (included) back to separation: the last state has no force and just touches; raises `NoEquilibrium`.

    Steps in overlap, each meant to take off the same share of the force, until less than `smallest` of it is left; then one solve without
    the flat gives the free shape, and its rigid position the separation.
    """
    path = [start]
    release = Release(solver, start)
    stiffness = release.stiffness(start)
    step = steps.force_drop * start.force / stiffness
    while path[-1].force > smallest * start.force:
        state, guess = path[-1], None
        if len(path) > 2:
            guess = extrapolated(solver, path[-2], state, -step / (state.overlap - path[-2].overlap))
        try:
            new, release = _back(solver, release, state, state.overlap - step, start.force, guess)
        except NoEquilibrium:
            solver.statistics.rejected += 1
            step *= 0.25
            if step < SMALLEST * steps.force_drop * start.force / stiffness:
                raise
            continue
        path.append(new)
        tangent = max((state.force - new.force) / step, 1e-3 * stiffness)
        wanted = min(steps.force_drop * start.force, max(steps.tail * new.force, 0.5 * smallest * start.force))
        step = min(wanted / tangent, 2.0 * step)
    try:
        free = solver.touching(release.step(path[-1], path[-1].overlap, start.force, contact=False))
    except NoEquilibrium:
        free = solver.free_shape(path[-1])
    return [*path, free]


def _back(
    solver: Equilibrium, release: Release, state: State, overlap: float, largest_force: float, guess: Guess | None
) -> tuple[State, Release]:
    """The state at a smaller overlap, and what to go on with: the factors at hand where they serve, else those of a new tangent."""
    try:
        new = release.step(state, overlap, largest_force, guess)
    except NoEquilibrium:
        new = solver.step(state, ByOverlap(overlap), largest_force, guess)
        return new, Release(solver, new)
    return new, Release(solver, new) if release.tired else release
