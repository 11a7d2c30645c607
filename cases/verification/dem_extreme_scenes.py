"""Scenes at the extremes: sizes, masses, speeds, overlaps, boxes, numbers of particles, long rests and tiny strains."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

import dem
from cases.verification.dem_extreme_trial import (
    DENSITY,
    HERTZ,
    MASS,
    MATERIAL,
    RADIUS,
    FloatArray,
    Trial,
    finite,
    hertz_collision,
    judged,
    refused,
    shaken,
    whole,
)
from contactlaws import tangential
from contactlaws.elastoplastic import Thornton
from dem.impact import restitution
from dem.measure import energies, largest_overlap, network, stress_tensor
from dem.motion import Deformation
from dem.neighbours import neighbours
from dem.packing import face_centred_cubic, simple_cubic
from dem.quasi_static import step_to
from dem.scene import QuasiStatic
from dem.timestep import pair_stiffness, scene_time_step
from dem.working import Working, arrays_of, follow, with_arrays, working

OPEN = (False, False, False)


def collision(radii: tuple[float, float], masses: tuple[float, float], speed: float, contact: dem.Contact, **settings: Any) -> dem.Scene:
    """Two spheres that just touch, the second at rest, followed for twice Hertz's time of contact."""
    apart = radii[0] + radii[1]
    bodies = dem.spheres([[0.0, 0.0, 0.0], [apart, 0.0, 0.0]], list(radii), DENSITY, [[speed, 0.0, 0.0], [0.0, 0.0, 0.0]])
    bodies = bodies._replace(mass=np.array(masses))
    reduced = masses[0] * masses[1] / (masses[0] + masses[1])
    _, time = hertz_collision(speed, reduced, radii[0] * radii[1] / apart, 0.5 * MATERIAL.reduced_modulus)
    given: dict[str, Any] = {"outputs": 20, "time_step_fraction": 0.02, **settings}
    return dem.Scene(bodies, dem.Box((10.0 * apart,) * 3, OPEN), contact, (dem.hold(2.0 * time),), **given)


def bounced(made: dem.Scene, expected: float) -> tuple[float, float, dem.Trajectory]:
    """Error of the coefficient of restitution, of the momentum over the first sphere's, and the run."""
    found = dem.run(made)
    velocity, speed = found.frames[-1].velocity[:, 0], made.particles.velocity[0, 0]
    momentum = float(made.particles.mass @ velocity / (made.particles.mass[0] * speed) - 1.0)
    return whole(found, float((velocity[1] - velocity[0]) / speed - expected)), whole(found, momentum), found


def sizes() -> list[Trial]:
    """Radii 1:100 and masses 1:1e6."""
    trials = []
    for done, radii, masses in (
        ("radii 1:100, one density", (RADIUS, 100.0 * RADIUS), (MASS, 1e6 * MASS)),
        ("radii 100:1, one density", (100.0 * RADIUS, RADIUS), (1e6 * MASS, MASS)),
        ("equal radii, masses 1:1e6", (RADIUS, RADIUS), (MASS, 1e6 * MASS)),
        ("equal radii, masses 1e6:1", (RADIUS, RADIUS), (1e6 * MASS, MASS)),
    ):
        wrong, momentum, _ = bounced(collision(radii, masses, 1e-2, dem.Contact(HERTZ)), 1.0)
        trials.append(judged(f"elastic collision, {done}: error of restitution", wrong, 1e-3))
        trials.append(judged(f"elastic collision, {done}: error of momentum", momentum, 1e-9))
    return trials


def restitutions() -> list[Trial]:
    """What a damper is asked for, from nothing to everything."""
    trials = [refused("a damper of restitution 0", lambda: tangential.damper(0.0, MATERIAL), "must lie in (0, 1]")]
    for asked in (1e-3, 0.01, 0.05, 0.2, 0.5, 0.8, 0.99, 1.0):
        contact = dem.Contact(HERTZ, damping=tangential.damper(asked, MATERIAL))
        made = collision((RADIUS, RADIUS), (MASS, MASS), 0.1, contact)
        ratio = contact.damping.ratio if contact.damping else 0.0
        longer = tuple(stage._replace(duration=(stage.duration or 0.0) * (1.0 + 20.0 * ratio)) for stage in made.programme)
        wrong, _, _ = bounced(dataclasses.replace(made, programme=longer), asked)
        trials.append(judged(f"a damper of restitution {asked:g}: error", wrong, 5e-3))
    return trials


def speeds() -> list[Trial]:
    """Of collision; the slowest overlap less than places are rounded to, the fastest press a sphere by its radius."""
    trials = []
    for exponent in range(-9, 4):
        speed = 10.0**exponent
        made = collision((RADIUS, RADIUS), (MASS, MASS), speed, dem.Contact(HERTZ), frames=20)
        deepest, _ = hertz_collision(speed, 0.5 * MASS, 0.5 * RADIUS, 0.5 * MATERIAL.reduced_modulus)
        wrong, _, found = bounced(made, 1.0)
        if found.stopped is not None:
            sound = finite(found) and deepest >= 2.0 * RADIUS and "where the body ends" in found.stopped
            trials.append(
                Trial(f"collision at {speed:g} m/s", found.stopped, "stops and says why", sound, "one clear error" if sound else "NO")
            )
            continue
        depth = 2.0 * RADIUS * found.statistics["largest_overlap"] / deepest - 1.0
        trials.append(judged(f"collision at {speed:g} m/s, {deepest / RADIUS:.2g} R deep: error of restitution", wrong, 1e-3))
        trials.append(judged(f"collision at {speed:g} m/s: error of depth", depth, 1e-3))
    return trials


def overlaps() -> list[Trial]:
    """At the start, released: what Hertz's contact stores becomes motion."""
    trials = []
    for depth in (1e-9, 1e-6, 1e-3, 0.01, 0.1, 0.3, 0.5):
        overlap = depth * RADIUS
        bodies = dem.spheres([[0.0, 0.0, 0.0], [2.0 * RADIUS - overlap, 0.0, 0.0]], RADIUS, DENSITY)
        stored = 8.0 / 15.0 * 0.5 * MATERIAL.reduced_modulus * np.sqrt(0.5 * RADIUS) * overlap**2.5
        time = hertz_collision(2.0 * np.sqrt(stored / MASS), 0.5 * MASS, 0.5 * RADIUS, 0.5 * MATERIAL.reduced_modulus)[1]
        made = dem.Scene(
            bodies, dem.Box((20.0 * RADIUS,) * 3, OPEN), dem.Contact(HERTZ), (dem.hold(time),), outputs=5, time_step_fraction=0.02
        )
        found = dem.run(made)
        wrong = float(found.energies.kinetic[-1] / stored - 1.0)
        # places of 1e-5 m are rounded to 1e-21 m, which is 2e-7 of the smallest overlap
        trials.append(judged(f"released from an overlap of {depth:g} R: error of the energy", whole(found, wrong), 1e-3))
    deep = dem.spheres([[0.0, 0.0, 0.0], [0.9 * RADIUS, 0.0, 0.0]], RADIUS, DENSITY)
    box, hold = dem.Box((20.0 * RADIUS,) * 3), (dem.hold(1e-9),)
    trials.append(
        refused("an overlap of 1.1 R", lambda: dem.run(dem.Scene(deep, box, dem.Contact(HERTZ), hold)), "lie deeper in each other")
    )
    return trials


def stiff_unloading() -> list[Trial]:
    """A plastic law whose contacts unload a thousand times as stiffly as they load."""
    modulus, depth = MATERIAL.reduced_modulus, 0.01
    law = Thornton(RADIUS, modulus, 2.0 * modulus * depth**0.5 / (1000.0 * np.pi))
    contact = dem.Contact(law)
    loading = 0.5 * np.pi * law.yield_pressure * RADIUS
    ratio = pair_stiffness(contact, RADIUS, RADIUS, 2.0 * depth * RADIUS) / loading
    trials = [
        judged(
            f"unloading {ratio:.0f} times as stiff as loading at .01 R: bound of the stiffness over loading, over 1000",
            ratio / 1000.0 - 1.0,
            0.5,
        )
    ]
    yield_depth = (np.pi * law.yield_pressure / (2.0 * modulus)) ** 2 * RADIUS
    yield_speed = np.sqrt(4.0 / (0.5 * MASS) * 8.0 / 15.0 * modulus * np.sqrt(RADIUS) * yield_depth**2.5)
    speed = 1e4 * yield_speed
    r = yield_speed / speed
    closed = np.sqrt(6.0 * np.sqrt(3.0) / 5.0 * (1.0 - r * r / 6.0)) * (r / (r + 2.0 * np.sqrt(1.2 - 0.2 * r * r))) ** 0.25
    found = restitution(law, RADIUS, DENSITY, [speed])
    trials.append(
        judged(
            f"its restitution at 1e4 times the speed of first yield ({closed:.4f}): error", float(found.restitution[0] / closed - 1.0), 2e-3
        )
    )
    made = dem.packed_scene(shaken(1.001), DENSITY, contact, dem.uniaxial_compression(0.02), inertial_number=2e-3, outputs=20)
    run = dem.run(made)
    trials.append(judged("its crystal compressed by 2 % and released: energy balance", whole(run, run.statistics["energy_balance"]), 1e-3))
    rest = dem.run(dataclasses.replace(made, quasi_static=QuasiStatic(), outputs=5))
    away = rest.pressure[5] / run.pressure[20] - 1.0
    trials.append(judged("the same by states of rest: pressure at the top against motion", whole(rest, float(away)), 0.05))
    return trials


def left_alone(work: Working, steps: list[int], dt: float, drag: float) -> tuple[Working, list[float]]:
    """A copy of the state after all these steps in a box that stays, and the largest way over R after each so many."""
    start, ways = work.bodies.position, []
    work = with_arrays(work, {key: array.copy() for key, array in arrays_of(work).items()})
    for count in steps:
        work, _ = follow(work, Deformation(work.cell, work.cell, 10**9, dt, drag), 0, count)
        ways.append(float(np.abs(work.bodies.position - start).max() / RADIUS))
    return work, ways


def resting() -> list[Trial]:
    """A million steps of a packing at rest, with and without friction; what contacts remember of how they came there is kept.

    Friction has no potential, and a packing in which many contacts are about to slide may be at rest and yet not stable: it then swings
    with an amplitude that grows (Chattoraj, Gendelman, Pica Ciamarra & Procaccia 2019, Phys. Rev. Lett. 123, 098003). This one is; that
    it is the model that does so and not the integration shows in the growth, which is the same with a quarter of the step. A drag of a
    fiftieth per step holds it.
    """
    trials = []
    for name, friction, drag in (("frictionless", None, 0.0), ("with friction and a drag", tangential.mindlin(0.3, MATERIAL), 0.02)):
        made = dem.packed_scene(shaken(), DENSITY, dem.Contact(HERTZ, friction), (dem.hold(1.0),))
        still = QuasiStatic(force=1e-9, kinetic=1e-20, displacement=1e-12)
        cell = made.box.stretched((0.999, 0.999, 0.999)).cell
        critical = lambda overlap, scene=made: scene_time_step(scene, overlap, 1.0).critical  # noqa: E731
        work, rest = step_to(working(made), cell, 1.0, True, critical, 1e-9, still)  # type: ignore[arg-type]
        found = 1.0 if rest.found else float("nan")
        dt, held = scene_time_step(made, largest_overlap(work), 0.4).dt, sum(energies(work)[:3])
        after, ways = left_alone(work, [1_000_000], dt, drag / dt)
        gained = float((sum(energies(after)[:3]) - held) / held)
        momentum = float(np.abs(after.masses @ after.bodies.velocity).max() / np.sqrt(2.0 * held * after.masses.sum()))
        # the rest is one to 1e-9 of the mean force, over a stiffness that makes 1e-2 R of it
        trials.append(judged(f"1e6 steps at rest, {name}: largest way over R", found * ways[0], 1e-10))
        trials.append(judged(f"{name}: energy gained over that held", found * gained, 1e-10))
        trials.append(judged(f"{name}: net momentum over that of the energy held", found * momentum, 1e-12))
        if friction is not None:
            coarse, fine = (left_alone(work, [200_000 * parts] * 3, dt / parts, 0.0)[1] for parts in (1, 4))
            rates = [np.log(ways[2] / ways[1]) for ways in (coarse, fine)]
            done = f"no drag: swings grow {np.exp(rates[0]):.0f} times in 2e5 steps; their rate against steps a quarter as long"
            trials.append(judged(done, found * float(rates[0] / rates[1] - 1.0), 0.05))
    return trials


def tiny_strains() -> list[Trial]:
    """1e-12 at a time: positions of 1e-5 m resolve 2e-16 of themselves, so the stress is right to a few parts in ten thousand of that."""
    trials, strain, squeezed = [], 1e-12, 0.99
    crystal = face_centred_cubic((2, 2, 2), RADIUS)
    box = crystal.box.stretched((squeezed,) * 3)
    bodies = dem.spheres(crystal.position * squeezed, RADIUS, DENSITY)
    base = working(dem.Scene(bodies, box, dem.Contact(HERTZ), (dem.hold(1.0),)))
    found = network(base)
    force, branch, depth = found.normal_force, np.linalg.norm(found.branch, axis=1), found.overlap
    # p = 1/(3V) sum of F r: all r shrink by the strain, V by three times it
    slope = float(np.sum(1.5 * force / depth * branch**2 - force * branch + 3.0 * force * branch) / (3.0 * box.volume))
    for way, settings in (("in motion", {}), ("by states of rest", {"quasi_static": QuasiStatic(strain_step=strain)})):
        programme = (dem.isotropic_compression(1000.0 * strain, 1e-6),)
        made = dem.Scene(bodies, box, dem.Contact(HERTZ), programme, outputs=1000, **settings)  # type: ignore[arg-type]
        run = dem.run(made)
        wrong = float((run.pressure[-1] - run.pressure[0]) / (slope * 1000.0 * strain) - 1.0)
        trials.append(judged(f"1000 strain increments of 1e-12 {way}: error of the pressure's increase", whole(run, wrong), 1e-3))
    return trials


def few() -> list[Trial]:
    """None, one, two."""
    box, contact = dem.Box((20.0 * RADIUS,) * 3), dem.Contact(HERTZ)
    programme = (dem.isotropic_compression(0.5, 1e-6),)
    trials = []
    for count in (0, 1, 2):
        place = np.array([[1.0, 1.0, 1.0], [8.0, 8.0, 8.0]])[:count] * RADIUS
        for way, settings in (("in motion", {}), ("by states of rest", {"quasi_static": QuasiStatic(strain_step=0.05)})):
            made = dem.Scene(dem.spheres(place, RADIUS, DENSITY), box, contact, programme, outputs=5, **settings)  # type: ignore[arg-type]
            found = dem.run(made)
            moved = np.abs(found.frames[-1].position - 0.5 * place).max(initial=0.0) + np.abs(found.stress).max()
            trials.append(
                judged(
                    f"{count} particles, box halved {way}: stress, and distance from where the box carries them",
                    whole(found, float(moved)),
                    1e-15,
                )
            )
    return trials


def narrow() -> list[Trial]:
    """Boxes in which a sphere meets its own images."""
    trials = []
    expected: FloatArray | None = None
    for cells in ((6, 6, 6), (2, 2, 2), (1, 1, 1), (1, 6, 2)):
        lattice = simple_cubic(cells, RADIUS)
        box = lattice.box.stretched((0.99,) * 3)
        made = dem.Scene(dem.spheres(lattice.position * 0.99, RADIUS, DENSITY), box, dem.Contact(HERTZ), (dem.hold(1e-9),), outputs=1)
        stress = stress_tensor(working(made))
        expected = stress if expected is None else expected
        wrong = float(np.abs(stress - expected).max() / np.abs(expected).max())
        trials.append(
            judged(
                f"simple lattice of {cells[0]} x {cells[1]} x {cells[2]}: stress against the largest", whole(dem.run(made), wrong), 1e-10
            )
        )
    one = dem.spheres([[0.0, 0.0, 0.0]], RADIUS, DENSITY)
    for edge in (0.9, 0.1, 1e-3):
        box = dem.Box((edge * RADIUS, 10.0 * RADIUS, 10.0 * RADIUS))
        attempt = dem.Scene(one, box, dem.Contact(HERTZ), (dem.hold(1e-9),))
        trials.append(refused(f"a box {edge:g} R wide", lambda scene=attempt: dem.run(scene), "lie deeper in each other"))  # type: ignore[misc]
    return trials


def across() -> list[Trial]:
    """A contact across each of 6 faces, 12 edges and 8 corners, in a cuboid and in a sheared box."""
    trials = []
    for name, tilt in (("cuboid", (0.0, 0.0, 0.0)), ("sheared box", (3.0, -4.0, 7.0))):
        box = dem.Box((20.0 * RADIUS,) * 3, (True,) * 3, tuple(t * RADIUS for t in tilt))  # type: ignore[arg-type]
        wrong, count = 0.0, 0
        for image in itertools.product((-1, 0, 1), repeat=3):
            if not any(image):
                continue
            apart = np.array([0.3, 0.5, 0.81]) / np.linalg.norm([0.3, 0.5, 0.81]) * 1.99 * RADIUS
            places = np.array([[0.2, 0.1, 0.3], [0.2, 0.1, 0.3]]) * RADIUS
            places[1] += apart + np.array(image) @ box.cell
            work = working(dem.Scene(dem.spheres(places, RADIUS, DENSITY), box, dem.Contact(HERTZ), (dem.hold(1.0),)))
            expected = 4.0 / 3.0 * 0.5 * MATERIAL.reduced_modulus * np.sqrt(0.5 * RADIUS) * (0.01 * RADIUS) ** 1.5
            found = network(work)
            count += len(found.first)
            wrong = max(wrong, float(np.abs(found.normal_force - expected).max(initial=0.0)) / expected)
        trials.append(judged(f"contacts across 26 faces, edges and corners of a {name}: missed or doubled", float(count - 26), 0.0))
        trials.append(judged(f"{name}: error of their force", wrong, 1e-10))
    return trials


def borders() -> list[Trial]:
    """Particles exactly on the border of a cell of the neighbour search, of the box, and one bit beside."""
    reach, trials = 2.0 * RADIUS, []
    for cells in (3, 4, 5):
        edge = cells * reach
        lines = np.concatenate([[0.0, -0.0, edge, np.nextafter(edge, 0.0), np.nextafter(0.0, -1.0)], np.arange(1, cells) * reach])
        places = np.array(list(itertools.product(lines, (0.0, reach, edge), (0.0, np.nextafter(edge, 0.0)))))
        places += np.random.default_rng(4).integers(-2, 3, places.shape) * edge
        found = neighbours(places, np.full(len(places), RADIUS), dem.Box((edge,) * 3), 0.0)
        trials.append(
            judged(f"{len(places)} particles on borders of {cells} cells: pairs missed or doubled", float(unlike(places, edge, found)), 0.0)
        )
    return trials


def unlike(places: FloatArray, edge: float, found: Any) -> int:
    """Pairs that only one of brute force over 27 images and the search finds; those within round-off of touching aside."""
    wrapped = np.floor(places / edge).astype(np.int64)
    wanted: set[tuple[int, ...]] = set()
    near: set[tuple[int, ...]] = set()
    for image in itertools.product((-1, 0, 1), repeat=3):
        apart = (places - wrapped * edge)[None] + np.array(image) * edge - (places - wrapped * edge)[:, None]
        distance = np.linalg.norm(apart, axis=2)
        for i, j in np.argwhere(distance <= 2.0 * RADIUS * (1.0 + 1e-9)):
            if j > i or (j == i and image > (0, 0, 0)):
                code = (int(i), int(j), *(np.array(image) + wrapped[i] - wrapped[j]).tolist())
                (wanted if distance[i, j] < 2.0 * RADIUS * (1.0 - 1e-9) else near).add(code)
    images = found.images[found.image]
    listed = [(int(i), int(j), *image.tolist()) for i, j, image in zip(found.first, found.partner, images, strict=True)]
    doubled = len(listed) - len(set(listed))
    return doubled + len(wanted - set(listed)) + len(set(listed) - wanted - near)


def one_point() -> list[Trial]:
    """All particles in one place."""
    bodies, box = dem.spheres(np.full((20, 3), 3.0 * RADIUS), RADIUS, DENSITY), dem.Box((20.0 * RADIUS,) * 3)
    scenes = {
        "20 particles at one point": dem.Scene(bodies, box, dem.Contact(HERTZ), (dem.hold(1e-9),)),
        "the same, by states of rest": dem.Scene(
            bodies, box, dem.Contact(HERTZ), (dem.isotropic_compression(0.1),), quasi_static=QuasiStatic()
        ),
    }
    return [refused(name, lambda scene=scene: dem.run(scene), "lie deeper in each other") for name, scene in scenes.items()]  # type: ignore[misc]


def walled() -> list[Trial]:
    """A wall through the packing, and spheres beyond it."""
    trials, box = [], dem.Box((20.0 * RADIUS,) * 3, OPEN)
    for done, height in (
        ("a sphere's centre in the wall", 0.0),
        ("centre beyond the wall", -0.5),
        ("a sphere beyond the wall, not touching", -5.0),
    ):
        bodies = dem.spheres([[10.0 * RADIUS, 10.0 * RADIUS, height * RADIUS]], RADIUS, DENSITY)
        made = dem.Scene(bodies, box, dem.Contact(HERTZ), (dem.hold(1e-9),), walls=(False, False, True))
        trials.append(refused(done, lambda scene=made: dem.run(scene), "wall"))  # type: ignore[misc]
    lattice = simple_cubic((3, 3, 3), RADIUS)
    bodies = dem.spheres(lattice.position, RADIUS, DENSITY)
    cut = dem.Scene(bodies, lattice.box._replace(periodic=OPEN), dem.Contact(HERTZ), (dem.hold(1e-9),), walls=(False, False, True))
    trials.append(refused("walls through the outer layers of a lattice", lambda: dem.run(cut), "wall"))
    fast = dem.spheres([[10.0 * RADIUS, 10.0 * RADIUS, 2.0 * RADIUS]], RADIUS, DENSITY, [[0.0, 0.0, -1e4]])
    through = dem.run(dem.Scene(fast, box, dem.Contact(HERTZ), (dem.hold(1e-8),), walls=(False, False, True)))
    sound = finite(through) and through.stopped is not None and "through a wall" in through.stopped
    trials.append(
        Trial("shot at a wall at 1e4 m/s", str(through.stopped), "stops and says why", sound, "one clear error" if sound else "NOT SAID")
    )
    return trials


BODIES: dict[str, Callable[[], list[Trial]]] = {"sizes": sizes, "few": few, "overlaps": overlaps, "one-point": one_point}
MOTION: dict[str, Callable[[], list[Trial]]] = {
    "restitution": restitutions,
    "speeds": speeds,
    "stiff-unloading": stiff_unloading,
    "resting": resting,
    "tiny-strains": tiny_strains,
}
BOXES: dict[str, Callable[[], list[Trial]]] = {"narrow": narrow, "across": across, "borders": borders, "walls": walled}
