"""Random packings that rest: equal spheres squeezed until they hold each other, the start of what is compared with other codes."""

from __future__ import annotations

import itertools
from functools import cache

import numpy as np

from contactlaws.elastic import Hertz
from contactlaws.material import Material
from dem.box import Box, wrapped
from dem.measure import energies
from dem.motion import Deformation
from dem.packing import random_close_packing
from dem.particles import Particles, spheres
from dem.scene import Contact, Scene
from dem.timestep import scene_time_step
from dem.working import follow, working

RADIUS, DENSITY = 5e-6, 4750.0  # m, kg/m3
MATERIAL = Material(142e9, 0.25, density=DENSITY)
LOOSE = 0.6  # packing fraction of the random packing that is squeezed
#: time steps of the squeeze and of the rest, and the share of its speed that a sphere loses in one: slow modes of a barely rigid packing
#: die out soonest if this is small; the steps are counted, not waited for, since near jamming nothing ever quite rests
SQUEEZING, SETTLING, DRAG = 500, 10_000, 0.005
NOISE = 1e-3  # kinetic over stored energy at the start, so that something moves
LARGEST = 12_500  # spheres that are packed; more are copies of a packing side by side


def settled(count: int, packing_fraction: float) -> tuple[Particles, Box]:
    """`count` frictionless elastic spheres at (nearly) rest at this fraction, with the `NOISE` of random speeds, and their periodic box.

    More than `LARGEST` are 8 copies, so their number must then be 8 times a smaller one's.
    """
    if count > LARGEST:
        part, box = _at_rest(count // 8, packing_fraction)
        edges = np.array(box.lengths)
        position = np.concatenate([part + np.array(corner) * edges for corner in itertools.product((0, 1), repeat=3)])
        x, y, z = (2.0 * edges).tolist()
        box = Box((x, y, z))
    else:
        position, box = _at_rest(count, packing_fraction)
    particles = spheres(position, RADIUS, DENSITY)
    speed = np.random.default_rng(1).normal(size=position.shape)
    speed -= speed.mean(axis=0)
    held = stored_energy(particles, box)
    speed *= np.sqrt(NOISE * held / (0.5 * particles.mass[0] * np.sum(speed**2)))
    return particles._replace(velocity=speed), box


def hertz() -> Hertz:
    """The law of one sphere."""
    return Hertz(RADIUS, MATERIAL.reduced_modulus)


def stored_energy(particles: Particles, box: Box) -> float:
    """Elastic energy of frictionless spheres in J."""
    return energies(working(Scene(particles, box, Contact(hertz()), ())))[1]


@cache
def _at_rest(count: int, packing_fraction: float) -> tuple[np.ndarray, Box]:
    packing = random_close_packing(count, LOOSE, RADIUS, seed=1)
    stretch = (LOOSE / packing_fraction) ** (1.0 / 3.0)
    scene = Scene(spheres(packing.position, RADIUS, DENSITY), packing.box, Contact(hertz()), (), skin=0.1)
    dt = scene_time_step(scene, 2.0 * RADIUS * (1.0 - stretch), 0.4).dt
    start, end = packing.box.cell, stretch * packing.box.cell
    work, _ = follow(working(scene), Deformation(start, end, SQUEEZING, dt, DRAG / dt), 0, SQUEEZING)
    work, _ = follow(work, Deformation(end, end, SETTLING, dt, DRAG / dt), 0, SETTLING)
    shuffled = np.random.default_rng(2).permutation(count)  # neither code is handed an order that suits it
    return wrapped(work.bodies.position, work.box)[shuffled], work.box
