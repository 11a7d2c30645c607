"""What a scene needs, what it can do without and why, and what is wrong with it."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numba
import numpy as np

from contactlaws import shaped
from contactlaws.ellipsoid import bluntness
from contactlaws.errors import InputError, Problem
from contactlaws.tangential import Damper, Mindlin, Rolling
from dem import box as boxes
from dem import particles as bodies
from dem.laws import first_force, in_time, known_law
from dem.scene import UNCHANGED, Contact, QuasiStatic, Scene, beginnings
from dem.working import Working

#: what can be carried along though the scene does not need it
CARRIED = ("radius", "mass", "rates", "rotation", "history")
#: beyond it inertia shows in the stress of frictionless spheres
QUASI_STATIC = 1e-3
#: strain that a stage under stress control is given time for, if it has no duration
SERVO_STRAIN = 0.05
#: contact force that counts in a quasi-static scene, over that of the largest strain
LOAD_SHARE = 0.1
#: coordination number with which the pressure of a compressed packing is estimated
EXPECTED_CONTACTS = 6.0


def problems_with(scene: Scene) -> Iterator[Problem]:
    """Yield everything in the scene that cannot be simulated."""
    yield from bodies.problems_with(scene.particles)
    yield from boxes.problems_with(scene.box)
    yield from _contact_problems(scene)
    yield from _wall_problems(scene)
    yield from _programme_problems(scene)
    for name, low, high in (("inertial_number", 0.0, 1.0), ("time_step_fraction", 0.0, 1.0), ("skin", 0.0, 10.0)):
        value = getattr(scene, name)
        if not low < value <= high:
            yield Problem(name, value, f"must lie in ({low:g}, {high:g}]", f"the default is {Scene.__dataclass_fields__[name].default:g}")
    if scene.threads > numba.config.NUMBA_NUM_THREADS:
        remedy = "ask for fewer, or set NUMBA_NUM_THREADS before starting"
        yield Problem("threads", scene.threads, f"numba has {numba.config.NUMBA_NUM_THREADS} threads here", remedy)
    if not (math.isfinite(scene.density_scaling) and scene.density_scaling > 0.0):
        yield Problem("density_scaling", scene.density_scaling, "must be positive", "1 leaves the masses as they are")
    if not 0.0 <= scene.moving_walls <= 1.0:
        yield Problem("moving_walls", scene.moving_walls, "must lie in [0, 1]", "0 moves the upper wall, 1 the lower, 0.5 both")
    elif scene.moving_walls and (scene.affine or not any(scene.walls)):
        bound = "matters only to walls that move by themselves"
        yield Problem("moving_walls", scene.moving_walls, bound, "set walls and affine=False, or leave it out")
    if not 0.0 <= scene.neglect < 1.0:
        yield Problem("neglect", scene.neglect, "must lie in [0, 1)", "0 neglects nothing")
    for name in scene.carry:
        if name not in CARRIED:
            yield Problem("carry", name, f"must be of {', '.join(CARRIED)}", "leave it out: the scene decides by itself")
    if scene.drag is not None and not 0.0 < scene.drag < math.inf:
        yield Problem("drag", scene.drag, "must be positive", "None is no drag")
    for name in ("outputs", "frames", "threads"):
        if not (isinstance(value := getattr(scene, name), int) and value >= 1):
            yield Problem(name, value, "must be a whole number, at least 1", "ask for some output")
    for one, other, _ in scene.between:
        if not (0 <= one < scene.kinds and 0 <= other < scene.kinds):
            yield Problem("between", (one, other), f"there are kinds 0 to {scene.kinds - 1}", "give the particles their `kind`")
    if scene.quasi_static is not None and scene.particles.axes is not None:
        yield Problem("quasi_static", "set", "knows spheres only", "leave it out, and take a small inertial_number")
    if scene.quasi_static is not None:
        yield from _search_problems(scene.quasi_static)


def _search_problems(settings: QuasiStatic) -> Iterator[Problem]:
    for name in ("strain_step", "force", "kinetic", "displacement"):
        if not 0.0 < (value := getattr(settings, name)) < 1.0:
            yield Problem(f"quasi_static.{name}", value, "must lie in (0, 1)", f"the default is {QuasiStatic._field_defaults[name]:g}")
    for name in ("most", "look"):
        if not (isinstance(value := getattr(settings, name), int) and value >= 1):
            yield Problem(f"quasi_static.{name}", value, "must be a whole number, at least 1", "it counts iterations")
    if settings.method not in ("fire", "damped"):
        yield Problem("quasi_static.method", settings.method, "must be fire or damped", "the default is fire")


def _wall_problems(scene: Scene) -> Iterator[Problem]:
    """Particles whose centres lie in a wall or beyond it."""
    bodies = scene.particles
    for name, wall, length, place in zip("xyz", scene.walls, scene.box.lengths, bodies.position.T, strict=True):
        outside = np.flatnonzero(~((place > 0.0) & (place < length)))
        if wall and len(outside):
            bound = f"particle {int(bodies.id[outside[0]])} lies beyond the walls at 0 and {length:g} m"
            yield Problem(f"position {name}", float(place[outside[0]]), bound, "move it into the box, or make the box larger")


def _contact_problems(scene: Scene) -> Iterator[Problem]:
    if scene.wall_contact is not None and len(scene.wall_contact) < scene.kinds:
        yield Problem("wall_contact", len(scene.wall_contact), f"must be given for each of {scene.kinds} kinds", "or leave it out")
    for number, contact in enumerate(scene.contacts):
        name = "contact" if number == 0 else f"contact {number}"
        yield from (problem._replace(name=f"{name}.{problem.name}") for problem in _problems_of(contact))
        yield from (problem._replace(name=f"{name}.{problem.name}") for problem in _problems_of_shapes(scene, contact))


def _problems_of_shapes(scene: Scene, contact: Contact) -> Iterator[Problem]:
    """Laws of spheres for ellipsoids and the other way round, and roles that ellipsoids have not."""
    shaped_law, name = shaped.is_shaped(contact.normal), type(contact.normal).__name__
    if scene.particles.axes is None:
        if shaped_law:
            yield Problem("normal", name, "is a law of ellipsoids", "give a law of spheres, or particles by dem.ellipsoids")
        return
    if not shaped_law:
        yield Problem("normal", name, "is a law of spheres", "give one of ellipsoids, as contactlaws.hertz_ellipse.HertzEllipse")
    if contact.rolling is not None:
        yield Problem("rolling", contact.rolling, "is not known for ellipsoids", "leave the role out: their shape resists rolling")


def _problems_of(contact: Contact) -> Iterator[Problem]:
    law = contact.normal
    try:
        known = known_law(law)
    except InputError as error:
        yield from error.problems
        return
    for name, value in law._asdict().items():  # type: ignore[attr-defined]
        if isinstance(value, float | int) and not (isinstance(value, float) and math.isfinite(value)):
            yield Problem(f"normal.{name}", value, "must be a finite float", "an int or NaN in a law's record is a mistake")
    if not (shaped.is_shaped(law) or law.radius > 0.0):  # type: ignore[attr-defined]
        yield Problem("normal.radius", law.radius, "must be positive", "give the radius in m that the law was made for")  # type: ignore[attr-defined]
    yield from known.problems(law)
    if not 0.0 < contact.share <= 1.0:
        yield Problem("share", contact.share, "must lie in (0, 1]", "1/2 is two equal bodies")
    for role, record in (("tangential", Mindlin), ("rolling", Rolling), ("damping", Damper)):
        value = getattr(contact, role)
        if value is None:
            continue
        if not isinstance(value, record):
            yield Problem(role, value, f"must be a {record.__name__} of contactlaws.tangential", "or None")
        elif not all(math.isfinite(number) and number >= 0.0 for number in value):
            yield Problem(role, tuple(value), "must be finite numbers, 0 or more", "see contactlaws.tangential")
    if contact.fitted_overlap is not None and not 0.0 < contact.fitted_overlap < math.inf:
        yield Problem("fitted_overlap", contact.fitted_overlap, "must be positive", "None if it is not known")
    if contact.rolling is not None and contact.tangential is None:
        yield Problem("rolling", contact.rolling, "needs friction: without it no contact can turn a sphere", "give the tangential role too")


def _programme_problems(scene: Scene) -> Iterator[Problem]:
    if not scene.programme:
        yield Problem("programme", "empty", "needs at least one stage", "use uniaxial_compression")
    for axis, wall, periodic in zip("xyz", scene.walls, scene.box.periodic, strict=True):
        if wall and periodic:
            yield Problem(f"walls {axis}", True, "a box that repeats along an axis has no wall there", "make the axis open")
    for number, (stage, change) in enumerate(zip(scene.programme, changes(scene), strict=True)):
        for axis, stretch, periodic, wall, stress in zip("xyz", stage.stretch, scene.box.periodic, scene.walls, stage.stress, strict=True):
            name = f"programme[{number}].stretch {axis}"
            if not (math.isfinite(stretch) and stretch > 0.0):
                yield Problem(name, stretch, "must be positive", "a strain of 1 or more leaves nothing of the box")
            elif (stretch != 1.0 or stress is not None) and not (periodic or wall):
                yield Problem(name, stretch, "an open axis without walls cannot be compressed", "make the axis periodic, or give it walls")
            elif stretch != 1.0 and not scene.affine and any(scene.walls) and not wall:
                yield Problem(name, stretch, "without affine motion a box with walls changes only between them", "set affine")
            if stress is not None and not (math.isfinite(stress) and stress >= 0.0):
                yield Problem(f"programme[{number}].stress {axis}", stress, "must be 0 or more", "compression is positive")
        if not all(math.isfinite(value) for value in stage.shear):
            yield Problem(f"programme[{number}].shear", stage.shear, "must be finite", "give the angle")
        if any(stage.shear) and not (scene.affine and all(scene.box.periodic)):
            yield Problem(f"programme[{number}].shear", stage.shear, "needs a periodic box that carries the particles along", "set affine")
        if stage.duration is None:
            if change == 0.0 or not scene.particles.size:
                yield Problem(f"programme[{number}].duration", None, "nothing moves, so nothing says how slowly", "give it in s")
            elif scene.quasi_static is not None and any(_in_time(contact.normal) for contact in scene.contacts):
                bound = "a law in time needs the time that passes between states of rest"
                yield Problem(f"programme[{number}].duration", None, bound, "give it in s")
            elif scene.density_scaling != 1.0 and any(_in_time(contact.normal) for contact in scene.contacts):
                bound = "scaled masses would make it longer, and a law in time would answer to that"
                yield Problem(f"programme[{number}].duration", None, bound, "give it in s")
        elif not (math.isfinite(stage.duration) and stage.duration > 0.0):
            remedy = "give it in s; a strain rate must not be 0"
            yield Problem(f"programme[{number}].duration", stage.duration, "must be positive", remedy)


def _in_time(law: object) -> bool:
    try:
        return in_time(law)
    except InputError:  # said elsewhere
        return False


def overlap_problems(scene: Scene, overlap: float) -> Iterator[Problem]:
    """What is wrong with a start at this overlap (m, of a pair)."""
    smallest = float(np.min(scene.particles.radii, initial=math.inf))
    if not overlap <= smallest:
        bound = f"particles lie deeper in each other than the smallest (mean) radius, {smallest:.4g} m"
        yield Problem("overlap at the start", overlap, bound, "pack them first")


def typical_force(scene: Scene, strain: float | None = None) -> float:
    """Force in N of a contact whose spheres of the mean radius are pressed by `strain`; None: by the largest of the programme."""
    if not scene.particles.size:
        return 0.0
    law, radius = scene.contact.normal, float(np.mean(scene.particles.radii))
    strain = (largest_strain(scene) or SERVO_STRAIN) if strain is None else strain
    return first_force(law, radius, radius, 2.0 * radius * strain)


def reference_pressure(scene: Scene, strain: float) -> float:
    """Effective-medium estimate in Pa of the pressure when every sphere is pressed by `strain`: phi z F/(4 pi R^2)."""
    radius, fraction = float(np.mean(scene.particles.radii)), scene.particles.solid_volume / scene.box.volume
    return fraction * EXPECTED_CONTACTS * typical_force(scene, strain) / (4.0 * math.pi * radius * radius)


def inertial_time(scene: Scene) -> float:
    """d sqrt(rho/p) in s: strain rate times it is the inertial number. p is the effective-medium pressure at the largest strain.

    Where the programme asks for stresses, p is the largest of them. rho is with density scaling: inertia is what the number is about.
    """
    density = float(np.sum(scene.masses)) / scene.particles.solid_volume
    asked = [stress for stage in scene.programme for stress in stage.stress if stress]
    pressure = max(asked) if asked else reference_pressure(scene, largest_strain(scene) or SERVO_STRAIN)
    return 2.0 * float(np.mean(scene.particles.radii)) * math.sqrt(density / pressure)


def largest_strain(scene: Scene) -> float:
    """Largest engineering strain or shear of the programme; that of stages after a stress has been reached comes on top."""
    total, largest = 0.0, 0.0
    for before, stage in zip((UNCHANGED, *scene.programme), scene.programme, strict=False):
        if before.follows_stress:
            total, largest = total + largest, 0.0
        largest = max(largest, *(abs(1.0 - stretch) for stretch in stage.stretch), *(abs(angle) for angle in stage.shear))
    return total + largest


def durations(scene: Scene) -> tuple[float, ...]:
    """Duration in s of each stage, those left open from the inertial number; 1 s in the quasi-static routine, which knows no inertia."""
    if scene.quasi_static is not None:
        return tuple(1.0 if stage.duration is None else stage.duration for stage in scene.programme)
    return tuple(
        stage.duration if stage.duration is not None else change * inertial_time(scene) / scene.inertial_number
        for stage, change in zip(scene.programme, changes(scene), strict=True)
    )


def drags(scene: Scene) -> tuple[float, ...]:
    """Rate in 1/s at which velocities relative to the box fade, per stage: without it an elastic packing heats up, the more the slower."""
    moving = scene.drag is not None and max(changes(scene), default=0.0) > 0.0 and scene.particles.size > 0
    return (scene.drag / inertial_time(scene) if moving and scene.drag is not None else 0.0,) * len(scene.programme)


def changes(scene: Scene) -> tuple[float, ...]:
    """Largest change of stretch or shear in each stage; of a stage under stress control, the strain that it is given time for."""
    moved = []
    for start, stage in zip(beginnings(scene.programme), scene.programme, strict=True):
        change = max(abs(b - a) for a, b in zip((*start.stretch, *start.shear), (*stage.stretch, *stage.shear), strict=True))
        moved.append(max(change, SERVO_STRAIN) if stage.follows_stress else change)
    return tuple(moved)


#: nanoseconds per particle-step that each part costs beside frictionless elastic spheres with 6 contacts each, on one thread;
#: `python -m cases.benchmarks.dem_parts` measures them anew
COSTS = {"radius": 7.0, "mass": 4.0, "rates": 8.0, "rotation": 5.0, "memory": 30.0, "friction": 75.0}


def left_out(scene: Scene, work: Working) -> tuple[str, ...]:
    """One line for all that the scene does not need and is not computed: the reason, and what it saves; and what ellipsoids carry."""
    pairs = sum(len(group.rows.first) for group in work.groups) / max(work.size, 1)
    lines = []
    if work.shapes is not None:
        each = sum(array.nbytes for array in work.shapes) / max(work.size, 1)
        both = sum(group.past.memory.nbytes for group in work.groups if group.past.memory is not None) / max(work.size, 1)
        own = f"the turn, inertia and surface of each ({each:.0f} bytes per particle)"
        lines.append(f"ellipsoids: {own}; normal, shape and work of each contact ({both:.0f} bytes per particle)")
    if all(group.past.slip is None for group in work.groups):
        turning = work.bodies.spin is not None
        saved = _saved((0 if turning else 48) + 32 * pairs, "friction")
        lines.append(f"no tangential force asked for: no {'' if turning else 'rotations, no '}tangential history ({saved})")
    if work.bodies.radius is None:
        lines.append(f"one radius: no radius per particle, one pair scale for all contacts ({_saved(8, 'radius')})")
    if work.bodies.mass is None:
        lines.append(f"one mass: no mass per particle ({_saved(8, 'mass')})")
    for kind, group in zip(work.kinds, work.groups, strict=True):
        law = known_law(kind.contact.normal)
        if not (law.memory or shaped.is_shaped(kind.contact.normal)):
            lines.append(f"{law.name} has no memory: no history per contact ({_saved(8 * pairs, 'memory')} for each number of it)")
        if group.roles.rates is None:
            lines.append(f"{law.name} asks for no rates: no relative velocities ({_saved(0, 'rates')})")
    if not any(scene.walls):
        lines.append("no walls: no wall search")
    return tuple(dict.fromkeys(lines))


def _saved(size: float, part: str) -> str:
    return f"saves {size:.0f} bytes per particle and some {COSTS[part]:.0f} ns per particle-step"


def motion_notes(scene: Scene, durations: tuple[float, ...]) -> tuple[str, ...]:
    """How the box moves and how fast, one line per stage in which it does."""
    if scene.quasi_static is not None:
        along = "carries the particles along" if scene.affine else "leaves the particles where they are"
        settings = scene.quasi_static
        return (
            f"quasi-static: strain steps of at most {settings.strain_step:g}, rest by {settings.method}; the box {along} in each step",
            "no inertia: density scaling, inertial number, time step and drag have no effect, and dampers next to none; a stage without a "
            "duration counts as 1 s",
        )
    lines = ["the box deforms affinely and carries the particles along (SLLOD); velocities and kinetic energy are relative to it"]
    if not scene.affine:
        lines = ["only faces and walls of the box move; the particles follow by contact"]
    if scene.density_scaling != 1.0:
        lines.append(
            f"density scaling: all masses times {scene.density_scaling:g}, time steps times {math.sqrt(scene.density_scaling):.3g}; "
            f"inertial numbers are those of the heavier particles, and a quasi-static answer asks for at most {QUASI_STATIC:g}"
        )
    for number, (change, duration, drag) in enumerate(zip(changes(scene), durations, drags(scene), strict=True)):
        if change == 0.0 or not scene.particles.size:
            continue
        rate, slowness = change / duration, inertial_time(scene)
        line = f"stage {number}: strain rate {rate:.3g} 1/s over {duration:.3g} s, inertial number {rate * slowness:.2g} at the top"
        if drag > 0.0:
            line += f"; non-affine velocities fade at {drag:.3g} 1/s, which carries some {drag * rate * slowness**2:.1g} of the pressure"
        lines.append(line)
    return tuple(lines)


def shape_warnings(scene: Scene) -> tuple[str, ...]:
    """Ellipsoids sharper or blunter than those that a law was fitted to."""
    axes = scene.particles.axes
    if axes is None:
        return ()
    lines, ends = [], bluntness(axes)
    for contact in scene.contacts:
        law = shaped.shaped_law_of(contact.normal)
        beyond = int(np.count_nonzero(shaped.beyond_fit(law, *ends)))
        if law.fitted is not None and beyond:
            sharpest, bluntest = (f"1 : {flat:.3g} : {flat:.3g}" for flat in map(shaped.flatness, law.fitted))
            lines.append(
                f"{beyond} of {len(axes)} ellipsoids can have contacts sharper or blunter than {law.name} was fitted to "
                f"(spheroids from {sharpest} to {bluntest}, at the end of the first axis): these count as the nearest of those"
            )
    return tuple(dict.fromkeys(lines))


def rate_warnings(scene: Scene, durations: tuple[float, ...]) -> tuple[str, ...]:
    """Stages too fast for a quasi-static answer, and scaled masses that gain nothing."""
    if not scene.particles.size or scene.quasi_static is not None:
        return ()
    idle = [str(number) for number, stage in enumerate(scene.programme) if stage.duration is None]
    useless = (
        f"density scaling saves nothing in stages without a duration ({', '.join(idle)}): the inertial number makes them "
        f"{math.sqrt(scene.density_scaling):.3g} times longer, as the time step",
    )
    numbers = [change / duration * inertial_time(scene) for change, duration in zip(changes(scene), durations, strict=True)]
    fast = tuple(
        f"stage {stage}: inertial number {number:.2g} > {QUASI_STATIC:g}: inertia shows in the stress"
        for stage, number in enumerate(numbers)
        if number > 1.001 * QUASI_STATIC
    )
    return (*(useless if idle and scene.density_scaling != 1.0 else ()), *fast)
