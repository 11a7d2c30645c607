"""The quasi-static routine: a strain step, then rest; again and again.

A step changes the box, carries the particles along (or leaves them), and looks for the places and turns at which no sphere is pulled. Every
trial is judged from the state that the step began with: what the contacts remember is that of the last equilibrium until the new one is
found, and the way and the time of the whole step lie between. So the search leaves no trace in the memory of a plastic or viscoelastic
contact, and a law in time is integrated implicitly.

The search is FIRE (Bitzek, Koskinen, Gaehler, Moseler & Gumbsch 2006; semi-implicit after Guenole et al. 2020) or, for comparison, damped
dynamics. What the boundary has put in and the contacts neither hold nor have used up went into rearrangements, and is counted as damped.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import literal_unroll

from contactlaws.compiled import inner, kernel
from dem.forces import DRAGGED, WORK, Frame, Past, forces, forces_on_threads
from dem.measure import energies, largest_overlap, network, stress_tensor
from dem.motion import farthest, slack
from dem.scene import QuasiStatic
from dem.working import Working, arrays_of, relisted, threaded, with_arrays

FloatArray = npt.NDArray[np.float64]

#: FIRE's constants, as published: growth and fall of the step, of the mixing, steps before growth, first mixing
GROWTH, FALL, MIXING, MIXING_FALL, PATIENCE = 1.1, 0.5, 0.25, 0.99, 20
#: friction is no potential: a search that mixes no more rolls on for ever
LEAST_MIXING = 0.03
#: first step over the longest, and the longest over the critical one
FIRST_STEP, LONGEST_STEP = 0.1, 1.0
#: stored energy that counts in a scene, over that of a force which does on a way of one radius, per sphere
ENERGY_SHARE = 1e-4
#: damped dynamics: rate of decay times the time in which the critical step would turn a sphere around
DAMPING = 0.1
#: strain steps towards a stress, and how close is close enough
SERVO_STEPS, SERVO_ERROR = 200, 3e-3
#: trials of one of them, and the share of the time in which a step on the way is taken
SERVO_TRIALS, NO_TIME = 20, 1e-6
SMALLEST = 1e-300


Critical = Callable[[float], float]


class Rest(NamedTuple):
    """How a search ended."""

    found: bool
    iterations: int
    kinetic: float  # kinetic energy of the search over that stored in contacts
    imbalance: float  # largest force on a sphere over the mean contact force, or over the scene's if that is larger
    displacement: float  # largest way in the last iteration over the radius
    missing: float | None = None  # largest stress that is missing, over the largest asked for; None: none was asked for

    @property
    def report(self) -> str:
        """One line for a person."""
        return (
            f"{self.iterations} iterations, kinetic over stored energy {self.kinetic:.2g}, largest force on a sphere over the mean contact "
            f"force {self.imbalance:.2g}, last displacement {self.displacement:.2g} radii"
            + ("" if self.missing is None else f"; the stress is {self.missing:.2g} of the largest one asked for away from it")
        )


class Memories(NamedTuple):
    """What the contacts of one kind remember in a trial, and what they remembered at the last equilibrium."""

    now: Past
    then: Past


class Search(NamedTuple):
    """What a search works on, all arrays shared with the state."""

    start: FloatArray  # m, where the box alone carries the spheres, shape (n, 3)
    turned: FloatArray  # since the last equilibrium, shape (n, 3); (0, 3) without spins
    velocity: FloatArray  # of the search
    spin: FloatArray
    pace: FloatArray  # step in s, mixing, downhill iterations in a row
    tally: FloatArray  # at the last equilibrium
    longest: float  # s; of a step
    duration: float  # s, since the last equilibrium
    fire: bool
    load: float  # N


@inner
def restore(memory, slip, roll, damping, memory_0, slip_0, roll_0, damping_0):  # type: ignore[no-untyped-def]
    """Give the contacts back what they remembered."""
    if memory is not None:
        memory[:] = memory_0
    if slip is not None:
        slip[:] = slip_0
    if roll is not None:
        roll[:] = roll_0
    if damping is not None:
        damping[:] = damping_0


@inner
def place_rates(velocity, spin, position, search):  # type: ignore[no-untyped-def]
    """The velocities with which the whole step is made in its whole time."""
    for i in range(len(position)):
        for a in range(3):
            velocity[i, a] = (position[i, a] - search.start[i, a]) / search.duration
            if spin is not None:
                spin[i, a] = search.turned[i, a] / search.duration


@kernel
def evaluate(threaded, groups, pasts, search, bodies, frame, force, torque, virial, reaction, tally):  # type: ignore[no-untyped-def]
    """The forces of a trial, as if the whole step lay between it and the last equilibrium.

    `pasts` is what the contacts of each kind remember, now and then.
    """
    for kind in literal_unroll(pasts):
        past, had = kind.now, kind.then
        restore(past.memory, past.slip, past.roll, past.damping, had.memory, had.slip, had.roll, had.damping)
    tally[:] = search.tally
    place_rates(bodies.velocity, bodies.spin, bodies.position, search)
    if threaded is None:
        forces(groups, bodies, frame, search.duration, force, torque, virial, reaction, tally)
    else:
        forces_on_threads(groups, bodies, frame, search.duration, force, torque, virial, reaction, tally)


@inner
def push(place, velocity, force, inertia, dt, keep, share):  # type: ignore[no-untyped-def]
    """Accelerate by the force, keep a part of the velocity and turn it towards the force by a share, and move."""
    n = len(place)
    speed, size = 0.0, 0.0
    for i in range(n):
        for a in range(3):
            total = 0.0
            for t in range(len(force)):
                total += force[t, i, a]
            velocity[i, a] = keep * (velocity[i, a] + dt * total / inertia[i])
            speed += velocity[i, a] ** 2
            size += total**2
    turn = share * math.sqrt(speed / size) if size > 0.0 else 0.0
    for i in range(n):
        for a in range(3):
            total = 0.0
            for t in range(len(force)):
                total += force[t, i, a]
            velocity[i, a] = (1.0 - share) * velocity[i, a] + turn * total
            place[i, a] += dt * velocity[i, a]


@inner
def power(velocity, force):  # type: ignore[no-untyped-def]
    """Of the forces, in W."""
    total = 0.0
    for t in range(len(force)):
        for i in range(len(velocity)):
            for a in range(3):
                total += velocity[i, a] * force[t, i, a]
    return total


@inner
def step_back(place, velocity, dt):  # type: ignore[no-untyped-def]
    """Half a step back, and stop."""
    for i in range(len(place)):
        for a in range(3):
            place[i, a] -= 0.5 * dt * velocity[i, a]
            velocity[i, a] = 0.0


@kernel
def iterate(  # type: ignore[no-untyped-def]
    threaded, groups, pasts, search, count, bodies, masses, inertias, frame, listed, cell, force, torque, virial, reaction, tally
):
    """Up to `count` iterations, fewer if the pair list no longer holds; returns their number and whether it holds."""
    pace, room = search.pace, 0.5 * slack(listed, cell, True)
    for iteration in range(count):
        share, keep = 0.0, 1.0 - DAMPING
        if search.fire:
            keep = 1.0
            if power(search.velocity, force) + power(search.spin, torque) >= 0.0:
                pace[2] += 1.0
                if pace[2] > PATIENCE:
                    pace[0], pace[1] = min(GROWTH * pace[0], search.longest), max(pace[1] * MIXING_FALL, LEAST_MIXING)
            else:
                step_back(bodies.position, search.velocity, pace[0])
                step_back(search.turned, search.spin, pace[0])
                pace[0], pace[1], pace[2] = max(FALL * pace[0], 0.01 * search.longest), MIXING, 0.0
            share = pace[1]
        push(bodies.position, search.velocity, force, masses, pace[0], keep, share)
        push(search.turned, search.spin, torque, inertias, pace[0], keep, share)
        if farthest(bodies.position, listed, cell) > room:
            return iteration + 1, False
        evaluate(threaded, groups, pasts, search, bodies, frame, force, torque, virial, reaction, tally)
    return count, True


def step_to(
    work: Working, cell: FloatArray, duration: float, affine: bool, critical: Critical, load: float, settings: QuasiStatic
) -> tuple[Working, Rest]:
    """Change the box to the edge vectors `cell` (m) in `duration` (s) and look for rest; the state found is returned, at rest or not.

    `critical` gives the critical time step (s) for overlaps up to its argument (m), `load` is a contact force (N) that counts in the scene.
    Only the walls of a box move if the motion is not `affine`.
    """
    held, before = _held(work), work.virial.sum(axis=0)
    old = work.cell.copy()
    stretch = np.asarray(np.linalg.solve(old, cell), dtype=np.float64)
    change = cell - old
    start: FloatArray = work.bodies.position @ stretch if affine else work.bodies.position.copy()
    work.bodies.position[:], work.old[:], work.cell[:] = start, old, cell
    for wall in work.walls:
        if wall[1] < 0.0:
            wall[2] += change[int(wall[0]), int(wall[0])]
    gradient = np.asarray(np.linalg.solve(0.5 * (old + cell), change) / duration if affine else np.zeros((3, 3)), dtype=np.float64)
    image_rate = np.zeros((3, 3)) if affine else change / duration
    spins = len(work.torque[0])
    reach = 2.0 * float(work.radii.max(initial=0.0)) * float(np.abs(stretch - np.eye(3)).max())
    longest = LONGEST_STEP * critical(largest_overlap(work) + reach)
    search = Search(
        start=start.copy(),
        turned=np.zeros((spins, 3)),
        velocity=np.zeros_like(start),
        spin=np.zeros((spins, 3)),
        pace=np.array([(1.0 if settings.method == "damped" else FIRST_STEP) * longest, MIXING, 0.0]),
        tally=work.tally.copy(),
        longest=longest,
        duration=duration,
        fire=settings.method != "damped",
        load=load,
    )
    work, rest = _found(work, search, gradient, image_rate, settings)
    work.bodies.velocity[:] = 0.0
    if work.bodies.spin is not None:
        work.bodies.spin[:] = 0.0
    strain = np.linalg.solve(0.5 * (old + cell), change)
    given = -float(np.sum(0.5 * (before + work.virial.sum(axis=0)) * strain))
    work.tally[0, WORK] += given
    work.tally[0, DRAGGED] += given - (_held(work) - held)
    return work, rest


def _held(work: Working) -> float:
    """Energy in J that contacts hold or have used up."""
    _, stored, sheared, dissipated, rubbed, dashed, _, _ = energies(work)
    return stored + sheared + dissipated + rubbed + dashed


def _copied(past: Past) -> Past:
    return Past(*(None if array is None else array.copy() for array in past))


class _Stand(NamedTuple):
    """A state, what its contacts remembered at the last equilibrium, and what its forces are computed with."""

    work: Working
    before: tuple[Past, ...]
    search: Search
    gradient: FloatArray
    image_rate: FloatArray

    @property
    def trial(self) -> tuple[Any, ...]:
        """What `evaluate` begins with."""
        pasts = tuple(Memories(group.past, before) for group, before in zip(self.work.groups, self.before, strict=True))
        return threaded(self.work), self.work.groups, pasts, self.search

    @property
    def frame(self) -> Frame:
        images = self.work.listed.images
        return Frame(images @ self.work.cell, images @ self.image_rate, self.gradient, self.work.walls)

    @property
    def sums(self) -> tuple[FloatArray, ...]:
        return self.work.force, self.work.torque, self.work.virial, self.work.reaction, self.work.tally

    def relisted(self) -> _Stand:
        """With a new pair list; what is remembered goes along."""
        work = relisted(self.work._replace(groups=tuple(g._replace(past=p) for g, p in zip(self.work.groups, self.before, strict=True))))
        return self._replace(work=work, before=tuple(_copied(group.past) for group in work.groups))

    def judged(self) -> _Stand:
        """With the forces of where the spheres are, and a list that holds."""
        work = self.work
        room = 0.5 * slack(work.listed, work.cell, True)
        stand = self if farthest(work.bodies.position, work.listed, work.cell) <= room else self.relisted()
        evaluate(*stand.trial, stand.work.bodies, stand.frame, *stand.sums)
        return stand


def _found(work: Working, search: Search, gradient: FloatArray, image_rate: FloatArray, settings: QuasiStatic) -> tuple[Working, Rest]:
    """Search until the criteria are met or the iterations are used up."""
    stand = _Stand(work, tuple(_copied(group.past) for group in work.groups), search, gradient, image_rate).judged()
    masses, inertias, done = work.masses, 0.4 * work.masses * work.radii**2, 0
    while True:
        rest = _rest(stand.work, search, done, settings)
        if rest.found or done >= settings.most or not np.isfinite(stand.work.force).all():
            return stand.work, rest
        some, holds = iterate(
            *stand.trial, settings.look, stand.work.bodies, masses, inertias, stand.frame, stand.work.listed, stand.work.cell,
            *stand.sums,
        )  # fmt: skip
        done += some
        if not holds:
            stand = stand.judged()


def _rest(work: Working, search: Search, iteration: int, settings: QuasiStatic) -> Rest:
    """Whether all is at rest."""
    if not work.size:
        return Rest(True, iteration, 0.0, 0.0, 0.0)
    found, stored, velocity = network(work), energies(work)[1], search.velocity
    kinetic = float(0.5 * np.sum(work.masses[:, None] * velocity**2))
    pull = float(np.sqrt((work.force.sum(axis=0) ** 2).sum(axis=1)).max())
    if len(search.turned):
        pull = max(pull, float((np.sqrt((work.torque.sum(axis=0) ** 2).sum(axis=1)) / work.radii).max()))
    mean = float(np.linalg.norm(found.force, axis=1).mean()) if len(found.first) else 0.0
    way = float(search.pace[0] * np.sqrt((velocity**2).sum(axis=1)).max() / work.radii.min())
    # below jamming forces never balance but fade: what is left is measured by what counts in the scene
    imbalance = pull / max(mean, search.load)
    energy = max(stored, ENERGY_SHARE * work.size * search.load * float(work.radii.min()))
    still = imbalance <= settings.force and kinetic <= settings.kinetic * energy and way <= settings.displacement
    return Rest(still, iteration, kinetic / energy, imbalance, way)


def step_to_stress(
    work: Working,
    cell: FloatArray,
    target: tuple[float | None, ...],
    duration: float,
    affine: bool,
    critical: Critical,
    load: float,
    settings: QuasiStatic,
) -> tuple[Working, Rest]:
    """Move edges until they carry `target` (Pa per axis), the others (None) to those of `cell` (m), in `duration` (s).

    Each trial starts from the same state with the same time ahead, so trials leave no trace in what contacts remember. How the stress
    answers is learnt from them (Broyden). Where the target is farther than a strain step, such a step is taken first, in next to no time.
    """
    controlled = np.flatnonzero([stress is not None for stress in target])
    wanted = np.array([target[axis] for axis in controlled], dtype=float)
    iterations, answer = 0, _Answer(None)
    for number in range(SERVO_STEPS):
        before = {name: array.copy() for name, array in arrays_of(work).items()}
        goal = cell if number == 0 else work.cell.copy()
        first = np.diag(stress_tensor(work, with_motion=False))[controlled]
        allowed = SERVO_ERROR * max(float(np.abs(wanted).max()), float(np.abs(first).max()))
        known, strain = (np.zeros(len(controlled)), first), answer.strain(wanted - first, settings.strain_step)
        for _ in range(SERVO_TRIALS):
            far = float(np.abs(strain).max()) >= settings.strain_step
            trial = goal.copy()
            trial[:, controlled] = before["cell"][:, controlled] * (1.0 - strain)
            start = with_arrays(work, {name: array.copy() for name, array in before.items()})
            time = duration * (NO_TIME if far else 1.0)
            found, rest = step_to(start, trial, time, affine, critical, load, settings)
            iterations += rest.iterations
            stress = np.diag(stress_tensor(found, with_motion=False))[controlled]
            missing = wanted - stress
            if not rest.found or (not far and float(np.abs(missing).max()) <= allowed):
                return found, rest._replace(iterations=iterations)
            answer = answer.learnt(strain - known[0], stress - known[1])
            known, more = (strain, stress), answer.strain(missing, settings.strain_step)
            if far and float(np.abs(strain + more).max()) >= settings.strain_step:
                break  # the target is farther still
            strain = np.clip(strain + more, -settings.strain_step, settings.strain_step)
        work = found
    return work, rest._replace(found=False, iterations=iterations, missing=float(np.abs(missing).max() / np.abs(wanted).max()))


class _Answer(NamedTuple):
    """How the stress of controlled edges answers their strain, as far as it is known."""

    stiffness: FloatArray | None  # Pa; None: nothing has answered yet

    def strain(self, missing: FloatArray, most: float) -> FloatArray:
        """The strain that brings the missing stress, at most `most`: all of it while nothing is known."""
        if self.stiffness is None or abs(np.linalg.det(self.stiffness)) <= 0.0:
            return most * np.sign(missing)
        strain = np.asarray(np.linalg.solve(self.stiffness, missing), dtype=np.float64)
        return strain * min(1.0, most / max(float(np.abs(strain).max()), SMALLEST))

    def learnt(self, strain: FloatArray, gained: FloatArray) -> _Answer:
        """After one more trial."""
        if not strain.any():
            return self
        if self.stiffness is not None:
            return _Answer(self.stiffness + np.outer(gained - self.stiffness @ strain, strain) / float(strain @ strain))
        if np.all(gained * strain > 0.0):
            return _Answer(np.diag(gained / strain))
        return self
