"""What of a scene the engine LAMMPS does not do: said before anything is computed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contactlaws import dispatch, shaped
from contactlaws.errors import Problem
from dem.scene import Scene


def problems_with(scene: Scene) -> Iterator[Problem]:
    """Yield everything in the scene that this engine does not do."""
    contact, count = scene.contact, scene.particles.size
    known = dispatch.law_of(contact.normal) if not shaped.is_shaped(contact.normal) else None
    if known is None or scene.particles.axes is not None:
        yield Problem("particles", "ellipsoids", "are not for the engine lammps", "leave out --engine")
    elif known.in_time:
        yield Problem("law", known.name, "depends on time, which the engine lammps does not know", "leave out --engine")
    if scene.between:
        yield Problem("between", len(scene.between), "is not for the engine lammps: one kind of particles", "leave out --engine")
    if any(scene.walls) or not all(scene.box.periodic):
        yield Problem("walls", scene.walls, "are not for the engine lammps: the box must be periodic along each axis", "leave out --engine")
    if any(scene.box.tilt) or any(any(stage.shear) for stage in scene.programme):
        yield Problem("shear", "given", "is not for the engine lammps: the box must be a cuboid", "leave out --engine")
    for name, wrong in (
        ("stress control", any(stage.follows_stress for stage in scene.programme)),
        ("quasi_static", scene.quasi_static is not None),
        ("affine", not scene.affine),
        ("carry", bool(scene.carry)),
        ("adaptive_step", scene.adaptive_step),
    ):
        if wrong:
            yield Problem(name, "asked for", "is not for the engine lammps", "leave out --engine, or this")
    if count == 0 or not np.array_equal(np.sort(scene.particles.id), np.arange(1, count + 1)):
        yield Problem("id", count, "must be 1 to n for the engine lammps, with at least one sphere", "number the spheres so")
        return
    needed = 4.0 * (1.0 + scene.skin) * float(scene.particles.radii.max())
    shortest = min(length * min(1.0, *(s.stretch[a] for s in scene.programme)) for a, length in enumerate(scene.box.lengths))
    if shortest < needed:
        yield Problem("box", shortest, f"must be at least {needed:.4g} m along each axis: no sphere may meet another twice", "take more")
