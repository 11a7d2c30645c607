"""Leap-frog in a box that deforms: kick half, drift, kick half; and the loop over steps.

The velocity v is relative to the box, whose own is x L, L the velocity gradient. A sphere that no force acts on goes straight in the
laboratory, so with a box that goes from H to H' = H F linearly in a step of dt it is at x' = x F + v dt, with v' = v F^-1: the SLLOD
equations solved exactly, as rows. Kick and drift are both symplectic, the scheme is of second order, and keeps the total momentum to
round-off. The motion of the box is affine: every particle is carried along with it at once, and no wave starts from a moving face. The
energy that the boundary gives is the change of kinetic energy in the drift and the trapezium of -virial : L dt.

With a drag, velocities relative to the box and spins fade at a constant rate, between the two halves of a kick. Frictionless elastic
spheres would turn every rearrangement into heat that never leaves, and the slower the loading, the hotter they would end.

Each thread computes its share of the pairs into forces of its own; they are added in the order of the threads. So the same scene on the
same number of threads gives the same bits.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.compiled import inner, kernel
from dem.forces import DRAGGED, WORK, Frame
from dem.step import all_forces, move_all

FloatArray = npt.NDArray[np.float64]


class Deformation(NamedTuple):
    """One stage: edge vectors, rows of a matrix in m, that go from `start` to `end` linearly in `steps` time steps, but for the servo."""

    start: FloatArray  # shape (3, 3)
    end: FloatArray  # shape (3, 3)
    steps: int
    dt: float  # s
    drag: float = 0.0  # 1/s; at which velocities relative to the box fade
    affine: bool = True  # whether the box carries the particles along; if not, only images and walls move
    target: FloatArray = np.zeros(3)  # Pa, per axis; stress that the edge is moved to hold
    gain: FloatArray = np.zeros(3)  # 1/(Pa s), per axis; 0: the edge goes as start and end say
    fastest: float = 0.0  # 1/s; strain rate that the servo does not exceed


class Listed(NamedTuple):
    """What the pair list was made for."""

    position: FloatArray  # m, shape (n, 3)
    cell: FloatArray  # m, the edge vectors then
    images: FloatArray  # which image each row of the shifts is, in edges; shape (k, 3)
    skin: float  # m
    reach: float  # m; the largest distance of centres in contact


# What follows works on small matrices in plain loops: numpy's functions would double the time that compiling takes.


@inner
def place_cell(deformation, step, cell):  # type: ignore[no-untyped-def]
    """Put the edge vectors after `step` steps of the stage into `cell`, but for the edges under stress control."""
    start, end = deformation.start, deformation.end
    share = step / deformation.steps
    for i in range(3):
        for j in range(3):
            if not (i == j and deformation.gain[i] > 0.0):
                cell[i, j] = end[i, j] if step == deformation.steps else start[i, j] + (end[i, j] - start[i, j]) * share


@inner
def total(parts):  # type: ignore[no-untyped-def]
    """Sum of the matrices of all threads."""
    whole = np.zeros(parts.shape[1:])
    for t in range(parts.shape[0]):
        for i in range(parts.shape[1]):
            for j in range(parts.shape[2]):
                whole[i, j] += parts[t, i, j]
    return whole


@inner
def places(images, cell):  # type: ignore[no-untyped-def]
    """Where images are in m: the product of two matrices."""
    shift = np.empty_like(images)
    for k in range(len(images)):
        for a in range(3):
            shift[k, a] = images[k, 0] * cell[0, a] + images[k, 1] * cell[1, a] + images[k, 2] * cell[2, a]
    return shift


@inner
def largest_entry(a, b):  # type: ignore[no-untyped-def]
    """Of the difference of two matrices, without its sign."""
    most = 0.0
    for i in range(3):
        for j in range(3):
            most = max(most, abs(a[i, j] - b[i, j]))
    return most


@inner
def product(a, b):  # type: ignore[no-untyped-def]
    """Of two matrices of shape (3, 3)."""
    c = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            c[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]
    return c


@inner
def inverse(a):  # type: ignore[no-untyped-def]
    """Of a lower triangular matrix of shape (3, 3)."""
    b = np.zeros((3, 3))
    for i in range(3):
        b[i, i] = 1.0 / a[i, i]
    b[1, 0] = -a[1, 0] * b[0, 0] * b[1, 1]
    b[2, 1] = -a[2, 1] * b[1, 1] * b[2, 2]
    b[2, 0] = -(a[2, 0] * b[0, 0] + a[2, 1] * b[1, 0]) * b[2, 2]
    return b


@inner
def servo(deformation, cell, virial):  # type: ignore[no-untyped-def]
    """Move the edges under stress control in `cell` for one step, by how far the stress is from its target."""
    volume = cell[0, 0] * cell[1, 1] * cell[2, 2]
    for axis in range(3):
        if deformation.gain[axis] > 0.0:
            rate = deformation.gain[axis] * (virial[axis, axis] / volume - deformation.target[axis])
            rate = min(max(rate, -deformation.fastest), deformation.fastest)
            cell[axis, axis] *= 1.0 + rate * deformation.dt


@inner
def gradient_of(old, cell, dt):  # type: ignore[no-untyped-def]
    """Velocity gradient in 1/s, in the middle of a step of `dt` (s), of a box that goes from `old` to `cell`; 0 of one that stays."""
    gradient, change = np.zeros((3, 3)), np.zeros((3, 3))
    if largest_entry(cell, old) == 0.0:
        return gradient
    for i in range(3):
        for j in range(3):
            change[i, j], gradient[i, j] = cell[i, j] - old[i, j], 0.5 * (cell[i, j] + old[i, j])
    gradient = product(inverse(gradient), change)
    for i in range(3):
        for j in range(3):
            gradient[i, j] /= dt
    return gradient


@kernel
def next_cell(deformation, step, cell, virial):  # type: ignore[no-untyped-def]
    """The edge vectors in m after `step` steps of a stage, one step on from `cell`, where `virial` (J, shape (3, 3)) was found."""
    after = cell.copy()
    servo(deformation, after, virial)
    place_cell(deformation, step, after)
    return after


@kernel
def carried_along(old, cell, dt):  # type: ignore[no-untyped-def]
    """What a box that went from `old` to `cell` in `dt` (s) does to what it carries: the inverse of its stretch, and `gradient_of`."""
    return inverse(product(inverse(old), cell)), gradient_of(old, cell, dt)


@kernel
def strain_of(cell, old, new):  # type: ignore[no-untyped-def]
    """Change of the edge vectors from `old` to `new` over what they are, `cell`: work is the virial with it."""
    change = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            change[i, j] = new[i, j] - old[i, j]
    return product(inverse(cell), change)


@inner
def done(bodies, force, virial, reaction, cell, change, still, walls, carried, dt):  # type: ignore[no-untyped-def]
    """Half the work in J that the boundary does on contacts in a step: with the forces of its start, or of its end."""
    if still:
        return 0.0
    if not carried and len(walls):  # then nothing but walls moves
        work = 0.0
        for w in range(len(walls)):
            work -= 0.5 * total(reaction)[w, int(walls[w, 0])] * walls[w, 3] * dt
        return work
    tension = total(virial)
    if not carried:  # images move: what is left of the sum of d F is that of shift F
        for t in range(len(force)):
            for i in range(len(bodies.position)):
                for a in range(3):
                    for b in range(3):
                        tension[a, b] -= bodies.position[i, a] * force[t, i, b]
    strain, work = product(inverse(cell), change), 0.0
    for i in range(3):
        for j in range(3):
            work -= 0.5 * tension[i, j] * strain[i, j]
    return work


@inner
def place_walls(walls, old, cell, moving, carried, dt):  # type: ignore[no-untyped-def]
    """Move the walls to the faces of `cell`; one that no affine motion carries has a velocity of its own."""
    for w in range(len(walls)):
        axis = int(walls[w, 0])
        change = cell[axis, axis] - old[axis, axis]
        share = -moving if walls[w, 1] > 0.0 else 1.0 - moving
        if carried:
            share = 0.0 if walls[w, 1] > 0.0 else 1.0
        walls[w, 2] += share * change
        walls[w, 3] = 0.0 if carried else share * change / dt


@kernel
def moved_walls(walls, old, cell, moving, carried, dt):  # type: ignore[no-untyped-def]
    """The walls after a step of `dt` (s) in which the edge vectors went from `old` to `cell`, see `place_walls`."""
    moved = walls.copy()
    place_walls(moved, old, cell, moving, carried, dt)
    return moved


@kernel
def farthest(position, listed, cell):  # type: ignore[no-untyped-def]
    """How far in m any sphere has gone since the list was made, beyond what the box carried it."""
    carried = product(inverse(listed.cell), cell)
    largest = 0.0
    for i in range(len(position)):
        x, y, z = listed.position[i, 0], listed.position[i, 1], listed.position[i, 2]
        dx = position[i, 0] - (x * carried[0, 0] + y * carried[1, 0] + z * carried[2, 0])
        dy = position[i, 1] - (y * carried[1, 1] + z * carried[2, 1])
        dz = position[i, 2] - z * carried[2, 2]
        largest = max(largest, dx * dx + dy * dy + dz * dz)
    return math.sqrt(largest)


@kernel
def slack(listed, cell, affine):  # type: ignore[no-untyped-def]
    """How far in m two spheres may come closer before a pair outside the list can touch: the skin, less what the box used of it."""
    if not affine:  # images and walls come closer by themselves
        most = 1.0
        for k in range(len(listed.images)):
            for a in range(3):
                most = max(most, abs(listed.images[k, a]))
        return listed.skin - most * 3.0 * largest_entry(cell, listed.cell)
    carried = product(inverse(listed.cell), cell)
    square = 0.0
    for i in range(3):
        for j in range(3):
            square += (carried[i, j] - (1.0 if i == j else 0.0)) ** 2
    return listed.skin - math.sqrt(square) * (listed.reach + listed.skin)


@kernel
def advance(  # type: ignore[no-untyped-def]
    threaded, shapes, groups, deformation, step, steps, drifted,
    bodies, cell, old, listed, walls, moving, force, torque, virial, reaction, tally,
):  # fmt: skip
    """Take `steps` steps from number `step` of a stage, or fewer if the pair list no longer holds.

    `shapes` None: all are spheres. `groups` is `(roles, rows, past)` of each kind of pair, `walls` as in `forces.Frame`; `moving` the share
    of a walled edge's change that its lower wall makes. The sums have one row per thread. `cell` (the edge vectors, one step earlier `old`)
    and `walls` change with the state. Returns the step reached, and whether it stands in the middle, with positions moved and the forces
    still to come; then the caller makes a new list and calls again with `drifted`.
    """
    dt, fade, parts = deformation.dt, math.exp(-deformation.drag * deformation.dt), len(force)
    begun = drifted
    travel = farthest(bodies.position, listed, cell if deformation.affine else listed.cell)  # since the list was made, maybe calls ago
    sums, change, gradient = np.zeros((parts, 4)), np.zeros((3, 3)), np.zeros((3, 3))
    speed = np.zeros_like(listed.images)
    controlled = deformation.gain[0] + deformation.gain[1] + deformation.gain[2] > 0.0
    for now in range(step, step + steps):
        if not drifted:
            for i in range(3):
                for j in range(3):
                    old[i, j] = cell[i, j]
            if controlled:
                servo(deformation, cell, total(virial))
            place_cell(deformation, now + 1, cell)
        still = largest_entry(cell, old) == 0.0
        carried = deformation.affine and not still
        for i in range(3):
            for j in range(3):
                change[i, j] = cell[i, j] - old[i, j]
        if not drifted:
            stretch = product(inverse(old), cell)
            back = inverse(stretch)
            half, faded = (0.5 * dt, fade) if begun else (0.0, math.sqrt(fade))
            begun = True
            place_walls(walls, old, cell, moving, carried, dt)
            tally[0, WORK] += done(bodies, force, virial, reaction, old, change, still, walls, carried, dt)
            move_all(threaded, bodies, shapes, force, torque, half, faded, 0.5 * dt, dt, carried, stretch, back, sums)
            fastest = 0.0
            for part in range(parts):
                tally[0, DRAGGED] += sums[part, 0]
                tally[0, WORK] += sums[part, 1]
                fastest = max(fastest, sums[part, 2])
            travel += dt * math.sqrt(fastest)
            room = 0.5 * slack(listed, cell, deformation.affine)
            if travel > room:
                travel = farthest(bodies.position, listed, cell if deformation.affine else listed.cell)
                if travel > room:
                    return now, True
        drifted = False
        if deformation.affine:
            gradient = gradient_of(old, cell, dt)
        else:
            speed = places(listed.images, change)
            for k in range(len(speed)):
                for a in range(3):
                    speed[k, a] /= dt
        frame = Frame(places(listed.images, cell), speed, gradient, walls)
        all_forces(threaded, groups, bodies, shapes, frame, dt, force, torque, virial, reaction, tally)
        tally[0, WORK] += done(bodies, force, virial, reaction, cell, change, still, walls, carried, dt)
    move_all(threaded, bodies, shapes, force, torque, 0.5 * dt, math.sqrt(fade), 0.0, 0.0, dt < 0.0, cell, cell, sums)
    for part in range(parts):
        tally[0, DRAGGED] += sums[part, 0]
    return step + steps, False
