"""What of a scene the engine LAMMPS does not do: said before anything is computed."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from contactlaws import shaped
from contactlaws.errors import Problem
from dem.box import Box
from dem.scene import UNCHANGED, Scene


def problems_with(scene: Scene) -> Iterator[Problem]:
    """Yield everything in the scene that this engine does not do."""
    count = scene.particles.size
    if scene.particles.axes is not None or any(shaped.is_shaped(contact.normal) for contact in scene.contacts):
        yield Problem("particles", "ellipsoids", "are not for the engine lammps", "leave out --engine")
        return
    if not all(wall or periodic for wall, periodic in zip(scene.walls, scene.box.periodic, strict=True)):
        yield Problem("box", scene.box.periodic, "open axes need walls in the engine lammps", "give them, or make the axes periodic")
    if any(scene.box.tilt) and not (scene.affine and all(scene.box.periodic)):
        bound = "needs a periodic box that carries the particles along in the engine lammps"
        yield Problem("box tilt", scene.box.tilt, bound, "set affine, or take a cuboid")
    across = any(stage.stress[a] is not None for stage in scene.programme for a in range(3) if not scene.walls[a])
    if any(scene.walls) and not scene.affine and across:
        bound = "is not for the engine lammps along a periodic axis, beside walls that move by themselves"
        yield Problem("stress control", "asked for", bound, "leave out --engine, or set affine")
    if scene.quasi_static is not None:
        yield Problem("quasi_static", "asked for", "is not for the engine lammps", "leave out --engine, or this")
    if count == 0 or not np.array_equal(np.sort(scene.particles.id), np.arange(1, count + 1)):
        yield Problem("id", count, "must be 1 to n for the engine lammps, with at least one sphere", "number the spheres so")
        return
    needed = needed_height(scene)
    lowest = min(lowest_height(scene.box.stretched(stage.stretch, stage.shear)) for stage in (UNCHANGED, *scene.programme))
    if lowest < needed:
        yield Problem("box", lowest, f"must be at least {needed:.4g} m across: no sphere may meet another twice", "take more")


def needed_height(scene: Scene) -> float:
    """Of a box, in m, in which no sphere can meet another twice."""
    return 4.0 * (1.0 + scene.skin) * float(scene.particles.radii.max())


def lowest_height(box: Box) -> float:
    """Of a box, in m: the least distance of two opposite faces that repeat; infinite where none does."""
    heights = 1.0 / np.linalg.norm(np.linalg.inv(box.cell), axis=0)
    return min((float(height) for height, periodic in zip(heights, box.periodic, strict=True) if periodic), default=math.inf)


def leans(scene: Scene) -> bool:
    """Whether the box ever is no cuboid."""
    return any(scene.box.tilt) or any(any(stage.shear) for stage in scene.programme)
