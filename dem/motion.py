"""Leap-frog in a box that deforms: kick half, drift, kick half.

With the position x = L s in a box of edges L(t), the peculiar velocity v = L ds/dt obeys m dv/dt = F - m (L'/L) v (the SLLOD equations;
for L linear in time they are Newton's equations in the laboratory). So L v is constant in the drift, whose displacement is taken with L at
half the step: the scheme is symplectic and of second order, and keeps the total momentum to round-off. The motion of the box is affine:
every particle is carried along with it at once, and no wave starts from a moving face. The energy that the boundary gives is the change of
kinetic energy in the drift and the trapezium of -(virial/L) dL.

With a drag, velocities relative to the box fade at a constant rate, before the first and after the second kick. Frictionless elastic
spheres would turn every rearrangement into heat that never leaves, and the slower the loading, the hotter they would end.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contactlaws.compiled import kernel
from dem.forces import BOUNDARY_WORK, DAMPED_ENERGY, pair_forces


class Deformation(NamedTuple):
    """One stage: edges that go from `start` to `end` linearly in `steps` time steps."""

    start: np.ndarray  # m, shape (3,)
    end: np.ndarray  # m, shape (3,)
    steps: int
    dt: float  # s
    drag: float = 0.0  # 1/s; at which velocities relative to the box fade


@kernel
def lengths_at(deformation, step):  # type: ignore[no-untyped-def]
    """Edges in m after `step` steps of the stage."""
    if step == deformation.steps:
        return deformation.end.copy()
    return deformation.start + (deformation.end - deformation.start) * (step / deformation.steps)


@kernel
def kick(velocity, force, mass, dt):  # type: ignore[no-untyped-def]
    """Change the velocities by force/mass over `dt`."""
    for i in range(len(velocity)):
        factor = dt / mass[i]
        for axis in range(3):
            velocity[i, axis] += factor * force[i, axis]


@kernel
def drift(position, velocity, mass, before, after, dt):  # type: ignore[no-untyped-def]
    """Move particles along with a box whose edges go from `before` to `after`; return the kinetic energy in J that its motion gave."""
    middle = 0.5 * (before + after)
    stretch, slowing = after / before, before / after
    way = dt * before * after / (middle * middle)
    work = 0.0
    for i in range(len(position)):
        for axis in range(3):
            v = velocity[i, axis]
            position[i, axis] = position[i, axis] * stretch[axis] + way[axis] * v
            velocity[i, axis] = v * slowing[axis]
            work += 0.5 * mass[i] * v * v * (slowing[axis] * slowing[axis] - 1.0)
    return work


@kernel
def slow_down(velocity, mass, factor):  # type: ignore[no-untyped-def]
    """Multiply the velocities by `factor`; return the kinetic energy in J that this takes away."""
    taken = 0.0
    for i in range(len(velocity)):
        for axis in range(3):
            taken += 0.5 * mass[i] * velocity[i, axis] * velocity[i, axis] * (1.0 - factor * factor)
            velocity[i, axis] *= factor
    return taken


@kernel
def outrun(position, origin, lengths, old_lengths, skin, widest):  # type: ignore[no-untyped-def]
    """Whether a pair outside the list may touch by now: two particles have used up the skin, less what the box brought them closer."""
    stretch = lengths / old_lengths
    slack = skin - 2.0 * widest * (1.0 / min(stretch[0], stretch[1], stretch[2], 1.0) - 1.0)
    if slack <= 0.0:
        return True
    limit = 0.25 * slack * slack
    for i in range(len(position)):
        square = 0.0
        for axis in range(3):
            d = position[i, axis] / stretch[axis] - origin[i, axis]
            square += d * d
        if square > limit:
            return True
    return False


@kernel
def advance(  # type: ignore[no-untyped-def]
    law,
    deformation,
    step,
    steps,
    drifted,
    position,
    velocity,
    mass,
    radius,
    one_radius,
    widest,
    pairs,
    memory,
    magnitude,
    force,
    virial,
    tally,
):
    """Take `steps` steps from number `step` of a stage, or fewer if the pair list no longer holds.

    Returns the number of the step reached and whether it stands in the middle, with positions moved and the forces still to come; then the
    caller makes a new list and calls again with `drifted`.
    """
    dt, fading = deformation.dt, math.exp(-0.5 * deformation.drag * deformation.dt)
    for now in range(step, step + steps):
        before, after = lengths_at(deformation, now), lengths_at(deformation, now + 1)
        if not drifted:
            if deformation.drag > 0.0:
                tally[DAMPED_ENERGY] += slow_down(velocity, mass, fading)
            kick(velocity, force, mass, 0.5 * dt)
            tally[BOUNDARY_WORK] += drift(position, velocity, mass, before, after, dt)
            if outrun(position, pairs.position, after, pairs.lengths, pairs.skin, widest):
                return now, True
        drifted = False
        change = after - before
        for axis in range(3):
            tally[BOUNDARY_WORK] -= 0.5 * virial[axis] / before[axis] * change[axis]
        strain_rate = change / (dt * 0.5 * (before + after))
        pair_forces(
            law, position, velocity, radius, one_radius, after, strain_rate, dt,
            pairs.start, pairs.partner, pairs.image, pairs.images, memory, magnitude, force, virial, tally,
        )  # fmt: skip
        for axis in range(3):
            tally[BOUNDARY_WORK] -= 0.5 * virial[axis] / after[axis] * change[axis]
        kick(velocity, force, mass, 0.5 * dt)
        if deformation.drag > 0.0:
            tally[DAMPED_ENERGY] += slow_down(velocity, mass, fading)
    return step + steps, False
