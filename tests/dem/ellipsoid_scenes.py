"""Scenes of a few ellipsoids, and what is conserved in them. They share their types, so that one compilation serves them all."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

import dem
from contactlaws.hertz_ellipse import HertzEllipse
from contactlaws.material import Material
from contactlaws.tangential import damper, mindlin
from dem.motion import Deformation
from dem.timestep import scene_time_step
from dem.working import Working, follow, working

FloatArray = npt.NDArray[np.float64]

MATERIAL, DENSITY = Material(142e9, 0.25), 4750.0
#: half axes in m
TRIAXIAL = (6.3e-6, 5.0e-6, 4.1e-6)
SIZE = 5e-6
LAW = HertzEllipse(MATERIAL.reduced_modulus)


def contact(friction: float = 0.0, restitution: float = 1.0) -> dem.Contact:
    """Every role that ellipsoids have; a coefficient of 0, or a restitution of 1, is none of it."""
    return dem.Contact(LAW, mindlin(friction, MATERIAL), None, damper(restitution, MATERIAL))


def random_turns(count: int, seed: int) -> FloatArray:
    """Unit quaternions, all orientations alike."""
    rows = np.random.default_rng(seed).normal(size=(count, 4))
    return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True))


def product(p: FloatArray, q: FloatArray) -> FloatArray:
    """The quaternion of turning by q first, then by p."""
    w, v = p[..., :1], p[..., 1:]
    s, u = q[..., :1], q[..., 1:]
    return np.concatenate([w * s - (v * u).sum(axis=-1, keepdims=True), w * u + s * v + np.cross(v, u)], axis=-1)


def scene(particles: dem.Particles, touch: dem.Contact, **settings: object) -> dem.Scene:
    """In an open box of 40 sizes with walls along z; it stands still unless `settings` has a programme."""
    box = dem.Box((40.0 * SIZE,) * 3, (False, False, False))
    given: dict[str, object] = {"programme": (dem.hold(1.0),), "walls": (False, False, True), "skin": 0.3, **settings}
    return dem.Scene(particles, given.pop("box", box), touch, **given)  # type: ignore[arg-type]


def collided(made: dem.Scene, overlap: float, fraction: float, most: int = 100_000) -> Working:
    """Follow until nothing touches any more; the step in s is `fraction` of the critical one at this overlap (m)."""
    dt = scene_time_step(made, overlap, fraction).dt
    work, touched = working(made), False
    for _ in range(0, most, 20):
        work, _ = follow(work, Deformation(work.cell.copy(), work.cell.copy(), 10**9, dt), 0, 20)
        touches = bool(work.force.any())
        if touched and not touches:
            return work
        touched = touched or touches
    raise AssertionError("the collision does not end")


def angular_momentum(work: Working) -> FloatArray:
    """kg m2/s about the origin, spins included."""
    assert work.shapes is not None
    orbital = np.cross(work.bodies.position, work.masses[:, None] * work.bodies.velocity)
    return np.asarray((orbital + work.shapes.momentum).sum(axis=0))
