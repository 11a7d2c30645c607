"""What a scene needs, what it can do without and why, and what is wrong with it."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from contactlaws import dispatch, pair
from contactlaws.errors import InputError, Problem
from dem import box as boxes
from dem import particles as bodies
from dem.scene import Scene

#: beyond it inertia shows in the stress of frictionless spheres
QUASI_STATIC = 1e-3
#: coordination number with which the pressure of a compressed packing is estimated
EXPECTED_CONTACTS = 6.0


def problems_with(scene: Scene) -> Iterator[Problem]:
    """Yield everything in the scene that cannot be simulated."""
    yield from bodies.problems_with(scene.particles)
    yield from boxes.problems_with(scene.box)
    yield from _contact_problems(scene)
    yield from _programme_problems(scene)
    for name, low, high in (("inertial_number", 0.0, 1.0), ("time_step_fraction", 0.0, 1.0), ("skin", 0.0, 10.0)):
        value = getattr(scene, name)
        if not low < value <= high:
            yield Problem(name, value, f"must lie in ({low:g}, {high:g}]", f"the default is {Scene.__dataclass_fields__[name].default:g}")
    if scene.drag is not None and not 0.0 < scene.drag < math.inf:
        yield Problem("drag", scene.drag, "must be positive", "None is no drag")
    for name in ("outputs", "frames"):
        if getattr(scene, name) < 1:
            yield Problem(name, getattr(scene, name), "must be at least 1", "ask for some output")


def _contact_problems(scene: Scene) -> Iterator[Problem]:
    for role in ("tangential", "rolling", "damping"):
        if getattr(scene.contact, role) is not None:
            yield Problem(f"contact.{role}", getattr(scene.contact, role), "this role is not supported yet", "leave it out")
    law = scene.contact.normal
    try:
        dispatch.law_of(law)
    except InputError as error:
        yield from error.problems
        return
    for name, value in law._asdict().items():  # type: ignore[attr-defined]
        if isinstance(value, float | int) and not (isinstance(value, float) and math.isfinite(value)):
            yield Problem(f"contact.normal.{name}", value, "must be a finite float", "an int or NaN in a law's record is a mistake")
    if not law.radius > 0.0:  # type: ignore[attr-defined]
        yield Problem("contact.normal.radius", law.radius, "must be positive", "give the radius in m that the law was made for")  # type: ignore[attr-defined]


def _programme_problems(scene: Scene) -> Iterator[Problem]:
    if not scene.programme:
        yield Problem("programme", "empty", "needs at least one stage", "use uniaxial_compression")
    for number, (stage, change) in enumerate(zip(scene.programme, changes(scene), strict=True)):
        for axis, stretch, periodic in zip("xyz", stage.stretch, scene.box.periodic, strict=True):
            name = f"programme[{number}].stretch {axis}"
            if not (math.isfinite(stretch) and stretch > 0.0):
                yield Problem(name, stretch, "must be positive", "a strain of 1 or more leaves nothing of the box")
            elif stretch != 1.0 and not periodic:
                yield Problem(name, stretch, "an open axis cannot be compressed", "make the axis periodic")
        if stage.duration is None:
            if change == 0.0 or not scene.particles.size:
                yield Problem(f"programme[{number}].duration", None, "nothing moves, so nothing says how slowly", "give it in s")
        elif not (math.isfinite(stage.duration) and stage.duration > 0.0):
            remedy = "give it in s; a strain rate must not be 0"
            yield Problem(f"programme[{number}].duration", stage.duration, "must be positive", remedy)


def overlap_problems(scene: Scene, overlap: float) -> Iterator[Problem]:
    """What is wrong with a start at this overlap (m, of a pair)."""
    smallest = float(np.min(scene.particles.radii, initial=math.inf))
    if not overlap <= smallest:
        bound = f"spheres lie deeper in each other than the smallest radius, {smallest:.4g} m"
        yield Problem("overlap at the start", overlap, bound, "pack them first")


def reference_pressure(scene: Scene, strain: float) -> float:
    """Effective-medium estimate in Pa of the pressure when every sphere is pressed by `strain`: phi z F/(4 pi R^2)."""
    law, radius = scene.contact.normal, float(np.mean(scene.particles.radii))
    state = dispatch.initial_state(law)
    force, _ = pair.pair_force(law, pair.pair_scale(law, radius, radius), 2.0 * radius * strain, 0.0, 0.0, state)
    fraction = scene.particles.solid_volume / scene.box.volume
    return fraction * EXPECTED_CONTACTS * float(force) / (4.0 * math.pi * radius * radius)


def inertial_time(scene: Scene) -> float:
    """d sqrt(rho/p) in s: strain rate times it is the inertial number. p is the effective-medium pressure at the largest strain."""
    density = float(np.sum(scene.particles.mass)) / scene.particles.solid_volume
    pressure = reference_pressure(scene, largest_strain(scene))
    return 2.0 * float(np.mean(scene.particles.radii)) * math.sqrt(density / pressure)


def largest_strain(scene: Scene) -> float:
    """Largest engineering strain that the programme reaches from the initial box, along any axis."""
    return max((abs(1.0 - stretch) for stage in scene.programme for stretch in stage.stretch), default=0.0)


def durations(scene: Scene) -> tuple[float, ...]:
    """Duration in s of each stage, those left open from the inertial number."""
    return tuple(
        stage.duration if stage.duration is not None else change * inertial_time(scene) / scene.inertial_number
        for stage, change in zip(scene.programme, changes(scene), strict=True)
    )


def drags(scene: Scene) -> tuple[float, ...]:
    """Rate in 1/s at which velocities relative to the box fade, per stage: without it an elastic packing heats up, the more the slower."""
    moving = scene.drag is not None and largest_strain(scene) > 0.0 and scene.particles.size > 0
    return (scene.drag / inertial_time(scene) if moving and scene.drag is not None else 0.0,) * len(scene.programme)


def changes(scene: Scene) -> tuple[float, ...]:
    """Largest change of stretch along any axis in each stage."""
    before = ((1.0, 1.0, 1.0), *(stage.stretch for stage in scene.programme))
    return tuple(max(abs(b - a) for a, b in zip(old, new.stretch, strict=True)) for old, new in zip(before, scene.programme, strict=False))


def left_out(scene: Scene) -> tuple[str, ...]:
    """One line for everything that the scene does not need and is not computed."""
    law = dispatch.law_of(scene.contact.normal)
    lines = ["no tangential force, rolling or damping asked for: no rotations, no tangential history"]
    if np.ndim(scene.particles.radius) == 0:
        lines.append("one radius: no radius per particle, one pair scale for all contacts")
    if not law.memory:
        lines.append(f"{law.name} has no memory: no history per contact")
    if scene.box.periodic == (True, True, True):
        lines.append("periodic along all axes: no walls, no wall search")
    return tuple(lines)


def motion_notes(scene: Scene, durations: tuple[float, ...]) -> tuple[str, ...]:
    """How the box moves and how fast, one line per stage in which it does."""
    lines = ["the box deforms affinely and carries the particles along (SLLOD); velocities and kinetic energy are relative to it"]
    for number, (change, duration, drag) in enumerate(zip(changes(scene), durations, drags(scene), strict=True)):
        if change == 0.0 or not scene.particles.size:
            continue
        rate, slowness = change / duration, inertial_time(scene)
        line = f"stage {number}: strain rate {rate:.3g} 1/s over {duration:.3g} s, inertial number {rate * slowness:.2g} at the top"
        if drag > 0.0:
            line += f"; non-affine velocities fade at {drag:.3g} 1/s, which carries some {drag * rate * slowness**2:.1g} of the pressure"
        lines.append(line)
    return tuple(lines)


def rate_warnings(scene: Scene, durations: tuple[float, ...]) -> tuple[str, ...]:
    """Stages too fast for a quasi-static answer."""
    if not scene.particles.size:
        return ()
    moving = ((change, duration) for change, duration in zip(changes(scene), durations, strict=True) if change > 0.0)
    numbers = [change / duration * inertial_time(scene) for change, duration in moving]
    return tuple(f"inertial number {n:.2g} > {QUASI_STATIC:g}: inertia shows in the stress" for n in numbers if n > 1.001 * QUASI_STATIC)
