"""Scenes of a few spheres for the tests of friction, walls, threads and restarts.

All of them have the same physics by type (a law with memory, friction, rolling, a damper, walls along z), so that one compilation serves
them all; what a test does not want has the coefficient 0.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

import dem
from contactlaws.elastoplastic import Thornton
from contactlaws.material import Material
from contactlaws.tangential import damper, mindlin, rolling
from dem.motion import Deformation
from dem.packing import Packing, face_centred_cubic
from dem.timestep import scene_time_step
from dem.working import Working, follow, renew_forces, working

FloatArray = npt.NDArray[np.float64]

RADIUS, DENSITY = 5e-6, 4750.0
MATERIAL = Material(142e9, 0.25)
MASS = DENSITY * 4.0 / 3.0 * np.pi * RADIUS**3
INERTIA = 0.4 * MASS * RADIUS**2
#: far from every wall
MIDDLE = 20.0 * RADIUS
#: never yields, and is Hertz to the last bit
NEVER_YIELDS = Thornton(RADIUS, MATERIAL.reduced_modulus, 1e6 * MATERIAL.youngs_modulus)
#: yields at an overlap of 2.5e-5 R
YIELDS = Thornton(RADIUS, MATERIAL.reduced_modulus, MATERIAL.reduced_modulus / 314.0)


def contact(friction: float = 0.0, roll: float = 0.0, restitution: float = 1.0, law: object = NEVER_YIELDS, **changes: bool) -> dem.Contact:
    """Every role; `changes` are those of the friction's record."""
    return dem.Contact(law, mindlin(friction, MATERIAL)._replace(**changes), rolling(roll), damper(restitution, MATERIAL))


def scene(position: npt.ArrayLike, touch: dem.Contact, velocity: npt.ArrayLike | None = None, **settings: object) -> dem.Scene:
    """Spheres in an open box of 40 radii with walls along z; it stands still unless `settings` has a programme."""
    bodies = dem.spheres(position, RADIUS, DENSITY, velocity)
    box = dem.Box((2.0 * MIDDLE,) * 3, (False, False, False))
    given: dict[str, object] = {"programme": (dem.hold(1.0),), "walls": (False, False, True), "skin": 0.5, **settings}
    spin = given.pop("spin", None)
    bodies = bodies._replace(spin=None if spin is None else np.array(spin, dtype=float))
    return dem.Scene(bodies, given.pop("box", box), touch, **given)  # type: ignore[arg-type]


def still(work: Working, dt: float) -> Deformation:
    """A box that stays as it is."""
    return Deformation(work.cell.copy(), work.cell.copy(), 10**9, dt)


def step_for(made: dem.Scene, overlap: float, fraction: float) -> float:
    """A time step in s for overlaps up to `overlap` (m)."""
    return scene_time_step(made, overlap, fraction).dt


def collided(made: dem.Scene, dt: float, most: int = 400_000) -> Working:
    """Follow a collision until nothing touches any more."""
    work, touched = working(made), False
    for _ in range(0, most, 50):
        work, _ = follow(work, still(work, dt), 0, 50)
        touches = bool(work.force.any())
        if touched and not touches:
            return work
        touched = touched or touches
    raise AssertionError("the collision does not end")


def carried(work: Working, velocity: npt.ArrayLike, spin: npt.ArrayLike, dt: float) -> None:
    """Move every sphere at a prescribed velocity and spin for `dt`, and compute the forces there."""
    work.bodies.velocity[:] = velocity
    assert work.bodies.spin is not None
    work.bodies.spin[:] = spin
    work.bodies.position[:] += dt * work.bodies.velocity
    renew_forces(work, None, dt)


def in_order(work: Working, rows: FloatArray) -> FloatArray:
    """Rows of the state in the order of the scene."""
    back = np.empty_like(rows)
    back[work.order] = rows
    return back


def angular_momentum(work: Working) -> FloatArray:
    """About the origin, spins included, kg m2/s."""
    assert work.bodies.spin is not None
    orbital = np.cross(work.bodies.position, work.masses[:, None] * work.bodies.velocity)
    return np.asarray((orbital + (0.4 * work.masses * work.radii**2)[:, None] * work.bodies.spin).sum(axis=0))


def walled_crystal(apart: float = 1.01, moved: float = 0.004) -> Packing:
    """32 spheres of a lattice moved at random, periodic along x and y, just between two walls along z."""
    crystal = face_centred_cubic((2, 2, 2), RADIUS)
    position = crystal.position * apart + np.random.default_rng(0).uniform(-moved, moved, crystal.position.shape) * RADIUS
    position[:, 2] += RADIUS - position[:, 2].min()
    edge, height = crystal.box.lengths[0] * apart, float(position[:, 2].max()) + RADIUS
    return crystal._replace(position=position, box=dem.Box((edge, edge, height), (True, True, False)))
