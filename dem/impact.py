"""Two equal spheres that collide head-on, through the same kernel as every scene."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws import dispatch
from contactlaws.errors import InputError, Problem, require
from dem.box import Box
from dem.forces import LARGEST
from dem.motion import Deformation
from dem.particles import Particles, spheres
from dem.scene import Contact, Scene, hold
from dem.timestep import collision_overlap, time_step
from dem.working import Working, arrays_of, follow, with_arrays, working

FloatArray = npt.NDArray[np.float64]

#: of the critical step: some 2000 steps in an elastic collision
FRACTION = 1e-3
#: steps between two looks at whether it is over
STRIDE = 200
#: steps after which a collision that isn't over is given up: a thousand times those of an elastic one, which has the fewest
LONGEST = 2_000_000
#: overlap over radius below which the round-off of positions shows in the result
SHALLOWEST = 1e-9


class Impact(NamedTuple):
    """One row per speed."""

    speed: FloatArray  # m/s; relative, of approach
    restitution: FloatArray  # relative speed after over before
    contact_time: FloatArray  # s; while there is force
    largest_overlap: FloatArray  # m; of the pair


def restitution(law: object, radius: float, density: float, speeds: Sequence[float] | FloatArray) -> Impact:
    """Collide two spheres of `radius` (m) and `density` (kg/m3) at each relative speed (m/s); raises `InputError` on impossible values.

    >>> from contactlaws.elastic import Hertz
    >>> round(float(restitution(Hertz(5e-6, 151.47e9), 5e-6, 4750.0, [1.0]).restitution[0]), 6)
    1.0
    """
    values = np.asarray(speeds, dtype=float).reshape(-1)
    named = [("radius", radius, "m"), ("density", density, "kg/m3"), *(("speed", float(speed), "m/s") for speed in values)]
    dispatch.law_of(law)
    require(Problem(n, v, "must be a positive finite number", f"give it in {u}") for n, v, u in named if not (math.isfinite(v) and v > 0.0))
    overlaps = [collision_overlap(law, _approaching(radius, density, float(speed)), float(speed)) for speed in values]
    require(problem for speed, overlap in zip(values, overlaps, strict=True) for problem in _speed_problems(float(speed), overlap, radius))
    rows = (_collide(law, radius, density, float(v), overlap) for v, overlap in zip(values, overlaps, strict=True))
    return Impact(values, *(np.array(column) for column in zip(*rows, strict=True)))


def _speed_problems(speed: float, overlap: float, radius: float) -> Iterator[Problem]:
    """Collisions that no body survives, and those that drown in round-off. `overlap` (m) is the pair's."""
    if overlap >= 2.0 * radius:
        bound = f"so fast that each sphere would be pressed by its whole radius, {radius:g} m, where the body ends"
        yield Problem("speed", speed, bound, "give a smaller speed in m/s")
    elif overlap < SHALLOWEST * radius:
        bound = f"so slow that the overlap of {overlap:.2g} m is lost in the round-off of positions"
        yield Problem("speed", speed, bound, f"give a speed in m/s whose overlap exceeds {SHALLOWEST:g} of the radius")


def _approaching(radius: float, density: float, speed: float) -> Particles:
    """Two equal spheres that just touch."""
    return spheres([[0.0, 0.0, 0.0], [2.0 * radius, 0.0, 0.0]], radius, density, [[0.5 * speed, 0.0, 0.0], [-0.5 * speed, 0.0, 0.0]])


def _collide(law: object, radius: float, density: float, speed: float, overlap: float) -> tuple[float, float, float]:
    bodies = _approaching(radius, density, speed)
    dt = time_step(law, bodies, overlap, FRACTION, contacts=1).dt
    box = Box((20.0 * radius,) * 3, (False, False, False))
    still = Deformation(box.cell, box.cell, 1, dt)
    work = working(Scene(bodies, box, Contact(law), (hold(1.0),), skin=0.5))
    steps = 0
    while True:
        kept = copied(work)
        work, _ = follow(work, still, 0, STRIDE)
        if not work.force.any() and closing_speed(work) < 0.0:
            break
        steps += STRIDE
        if steps >= LONGEST:
            raise InputError(Problem("speed", speed, f"the spheres are still in contact after {steps} steps", "check the law's parameters"))
    work = kept
    while True:  # the last stride again, step by step: when does the force end?
        before = work.bodies.position[1, 0] - work.bodies.position[0, 0] - 2.0 * radius
        work, _ = follow(work, still, 0, 1)
        steps += 1
        if not work.force.any():
            break
    gap = work.bodies.position[1, 0] - work.bodies.position[0, 0] - 2.0 * radius
    beyond = gap / (gap - before) if gap >= 0.0 else 0.5  # of the last step; without a gap nobody knows
    return -closing_speed(work) / speed, (steps - beyond) * dt, float(work.tally[0, LARGEST]) * 2.0 * radius


def closing_speed(work: Working) -> float:
    """Relative speed of approach in m/s of the first two particles along x."""
    return float(work.bodies.velocity[0, 0] - work.bodies.velocity[1, 0])


def copied(work: Working) -> Working:
    """A state of its own arrays."""
    return with_arrays(work, {name: array.copy() for name, array in arrays_of(work).items()})
