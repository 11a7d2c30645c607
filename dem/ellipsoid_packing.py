"""Random packings of ellipsoids: thrown loosely and turned at random, then pressed together by the engine itself."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.contact_ellipse import slender_problems
from contactlaws.errors import InputError, Problem, require
from contactlaws.hertz_ellipse import HertzEllipse
from dem.box import Box, wrapped
from dem.measure import largest_overlap
from dem.motion import Deformation
from dem.packing import problems_with_radii, random_close_packing
from dem.particles import Particles, ellipsoids
from dem.scene import Contact, Scene, hold
from dem.timestep import scene_time_step
from dem.working import Working, follow, working

FloatArray = npt.NDArray[np.float64]

#: packing fraction of the bounding spheres that are thrown
LOOSE = 0.45
#: what follows is in units of the mean radius, the density and the modulus. Strain rate, decay of velocities, largest overlap that the
#: time step is made for and its share of the critical one
PACE, DRAG, DEEPEST, FRACTION = 3e-4, 0.02, 0.03, 0.3
#: strain by which the box is made smaller than wanted, in order to grow back when all have found their places: closes what still overlaps
BEYOND = 5e-4
#: steps at a time while they find their places, and how often
PATIENCE, ROUNDS = 500, 60
#: densest that ellipsoids pack at random (1.25:1:.8, Donev et al. 2004), and then some
DENSEST = 0.76


class EllipsoidPacking(NamedTuple):
    """Ellipsoids in a periodic box."""

    position: FloatArray  # m, shape (n, 3)
    axes: FloatArray  # m, half axes, shape (n, 3)
    orientation: FloatArray  # unit quaternions (w, x, y, z), shape (n, 4)
    box: Box
    packing_fraction: float  # volume of the ellipsoids over that of the box
    worst_overlap: float  # over the sum of the two mean radii
    steps: int  # time steps of the engine

    def particles(self, density: float) -> Particles:
        """At rest, of one density (kg/m3)."""
        return ellipsoids(self.position, self.axes, density, self.orientation)


def half_axes(proportions: npt.ArrayLike, radius: float) -> FloatArray:
    """Half axes in m, shape (3,), of the ellipsoid with these `proportions` and the volume of a sphere of `radius` (m).

    >>> half_axes((1.0, 0.8, 0.64), 5e-6).round(8)
    array([6.25e-06, 5.00e-06, 4.00e-06])
    """
    shape = np.asarray(proportions, dtype=float)
    return np.asarray(radius * shape / np.cbrt(shape.prod()))


def random_turns(count: int, seed: int) -> FloatArray:
    """Unit quaternions, all orientations alike, shape (n, 4)."""
    rows = np.random.default_rng(seed).normal(size=(count, 4))
    return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True))


def random_ellipsoids(
    count: int, packing_fraction: float, axes: npt.ArrayLike, seed: int = 0, worst_overlap: float = 1e-3
) -> EllipsoidPacking:
    """Random packing of `count` ellipsoids in a periodic cube, of the fraction asked for; the same seed gives the same packing.

    axes: half axes in m, one triple or shape (n, 3). Their bounding spheres are packed loosely, the box is pressed from all sides while
    soft frictionless contacts push them apart and round, and they are given time to find their places. Up to where they jam (.70 for
    1:.8:.66) what is left of overlaps is round-off, or none; the result says how much. Raises `InputError` before computing for what no
    packing can be, and afterwards, with what was reached, if any two overlap by more than `worst_overlap` of the sum of their mean radii.

    >>> packing = random_ellipsoids(12, 0.3, (5e-6, 4e-6, 3.3e-6), seed=1)
    >>> round(packing.packing_fraction, 12), packing.worst_overlap
    (0.3, 0.0)
    """
    require(_problems(count, packing_fraction, axes))
    half = np.array(np.broadcast_to(np.asarray(axes, dtype=float), (count, 3)))
    unit = float(np.cbrt(half.prod(axis=1).mean()))
    thrown = random_close_packing(count, LOOSE, half.max(axis=1) / unit, seed)
    bodies = ellipsoids(thrown.position, half / unit, 1.0, random_turns(count, seed))
    made = Scene(bodies, thrown.box, Contact(HertzEllipse(1.0)), (hold(1.0),), skin=0.1)
    work, steps = working(made), 0
    dt = scene_time_step(made, DEEPEST, FRACTION).dt
    edge = (bodies.solid_volume / packing_fraction) ** (1.0 / 3.0)
    for wanted in (edge * (1.0 - BEYOND), None, edge):
        if wanted is None:
            work, used = _settled(work, dt)
        else:
            work, used = _pressed(work, wanted, dt)
        steps += used
    back = np.argsort(work.order)
    assert work.shapes is not None
    overlap = max(largest_overlap(work), 0.0) / 2.0
    if not overlap <= worst_overlap:
        reached = f"{count} ellipsoids (seed {seed}) jam before: two overlap by {overlap:.2g} of their size"
        raise InputError(Problem("packing_fraction", packing_fraction, reached, "ask for less, or allow a larger worst_overlap"))
    box = Box((edge * unit,) * 3)
    position = wrapped(work.bodies.position[back] * unit, box)
    return EllipsoidPacking(position, half, work.shapes.orientation[back], box, packing_fraction, overlap, steps)


def _pressed(work: Working, edge: float, dt: float) -> tuple[Working, int]:
    """The box made a cube of this edge; also the steps it took."""
    start, end = work.cell.copy(), edge * np.eye(3)
    steps = max(1, math.ceil(float(np.abs(end - start).max() / max(edge, float(start.max()))) / (PACE * dt)))
    work, _ = follow(work, Deformation(start, end, steps, dt, DRAG), 0, steps)
    return work, steps


def _settled(work: Working, dt: float) -> tuple[Working, int]:
    """Time for everything to find its place: until overlaps are gone when the box grows back, or go on no longer."""
    steps, before = 0, math.inf
    still = Deformation(work.cell.copy(), work.cell.copy(), PATIENCE, dt, DRAG)
    for _ in range(ROUNDS):
        work, _ = follow(work, still, 0, PATIENCE)
        steps += PATIENCE
        overlap = largest_overlap(work)
        if overlap < BEYOND or (overlap < 0.03 and overlap > 0.999 * before):
            break
        before = overlap
    return work, steps


def _problems(count: int, packing_fraction: float, axes: npt.ArrayLike) -> Iterator[Problem]:
    half = np.asarray(axes, dtype=float)
    if half.shape not in ((3,), (count, 3)) or not (np.isfinite(half) & (half > 0.0)).all():
        yield Problem("axes", half.shape, f"must be positive, finite, and have the shape (3,) or ({count}, 3)", "give half axes in m")
        return
    yield from problems_with_radii(count, half.max(axis=-1))
    yield from slender_problems("axes", half)
    if not 0.0 < packing_fraction <= DENSEST:
        yield Problem("packing_fraction", packing_fraction, f"random packings lie in (0, {DENSEST}]", "denser ones are crystals")
