"""The one pair kernel: every force of every scene, and of the impact of two spheres, is computed here.

Pairs are taken in blocks, in three passes over the same short buffers: gather what the two spheres have, compute, scatter. The middle pass
has no indirect access, so the compiler makes it four contacts wide. It does so without changing the order of any sum, since sums over
contacts are kept apart for each place in the block: how a kernel was compiled does not show in the bits. What a scene does not need is
None, and compiled away.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
import numpy.typing as npt
from numba import literal_unroll

from contactlaws import dispatch, pair
from contactlaws.compiled import inner, kernel
from contactlaws.tangential import Damper, Mindlin, Rolling, damper_force, dragged, tangential_stiffness

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.uint32]

#: rows of the tally, which the kernels keep: J dissipated by contacts that have ended; J that tangential forces and rolling moments took
#: up; J that dampers took; largest overlap of one body over its radius, at any time; J taken by the drag; J given by the moving boundary;
#: J that the normal forces of ellipsoids took up
LOST, SHEARED, DAMPED, LARGEST, DRAGGED, WORK, PRESSED = range(7)
TALLIES = 7
#: pairs taken at a time: the buffers stay in the first cache
BLOCK = 64
#: below any distance; keeps two centres in one place from a division by zero
NEAREST = 1e-150
ONE = np.uint64(1)  # unsigned indices: numba then needs no test for negative ones
#: rows of a block: centre to centre; relative velocity; half the spins; relative spin; force and moment on the second; the rest
D, V, C, W, G, T, M = 0, 3, 6, 9, 12, 15, 18
OVERLAP, INVERSE, NORMAL, MASS, CONTACT, RADIUS_1, RADIUS_2 = range(21, 28)
SLIP, ROLL, HAD, TURN, SCALE, BLOCKS = 28, 32, 35, 36, 37, 38
SUMS = BLOCKS + 3 + dispatch.SCRATCH


class Bodies(NamedTuple):
    """The spheres as the kernels see them."""

    position: FloatArray  # m, shape (n, 3); never wrapped
    velocity: FloatArray  # m/s, shape (n, 3); relative to the box
    spin: FloatArray | None  # 1/s, shape (n, 3); None: no force can turn them
    radius: FloatArray | None  # m, shape (n,); None: all are `one_radius`
    one_radius: float
    mass: FloatArray | None  # kg, shape (n,); None: all are `one_mass`
    one_mass: float


class Roles(NamedTuple):
    """The physics of one kind of contact; None is absent."""

    normal: object
    tangential: Mindlin | None
    rolling: Rolling | None
    damper: Damper | None
    share: float  # of the overlap that is the law's body's, see contactlaws.pair
    rates: bool | None  # None: nothing asks how fast the spheres approach
    blocks: bool | None  # None: the law is asked contact by contact


class Rows(NamedTuple):
    """Half list of the pairs of one kind, each once, sorted by the first sphere; of walls, `partner` is the wall and `image` None."""

    first: IndexArray
    partner: IndexArray
    image: npt.NDArray[np.uint16 | np.uint32] | None  # row of the shifts


class Past(NamedTuple):
    """What contacts remember, one column or row per pair."""

    memory: FloatArray | None  # of the law, shape (m, floats); (floats, m) for a law that takes blocks
    slip: FloatArray | None  # tangential force on the first sphere in N, and the contact radius in m; shape (4, m)
    roll: FloatArray | None  # rolling moment on the first sphere in N m, shape (3, m)
    damping: FloatArray | None  # the damper's force in N, shape (m,)


class Frame(NamedTuple):
    """The box at one moment."""

    shift: FloatArray  # m, where each image is, shape (k, 3)
    speed: FloatArray  # m/s, of each image relative to the box, shape (k, 3)
    gradient: FloatArray  # 1/s; the velocity of the box at x is x @ gradient
    walls: FloatArray  # axis, 1 (particles above) or -1, place in m, velocity in m/s relative to the box; shape (w, 4)


@inner
def forget(law, scale, share, memory, row):  # type: ignore[no-untyped-def]
    """End a contact: clear its memory and return the energy in J that it has used up."""
    state = dispatch.load_state(law, memory, row)
    touched = False
    for value in state:
        touched = touched or value != 0.0
    if not touched:
        return 0.0
    stored, dissipated = pair.pair_energy(law, scale, 0.0, state, share)
    for k in range(memory.shape[1]):  # afterwards: the state may be this very row
        memory[row, k] = 0.0
    return stored + dissipated


@kernel
def pair_forces(  # type: ignore[no-untyped-def]
    law, tangential, rolling, damper, share, rates, blocks, first, partner, image, memory, slip, roll, damping,
    position, velocity, spin, radius, one_radius, mass, one_mass, frame, dt, span,
    force, torque, virial, reaction, network, tally,
):  # fmt: skip
    """Add the forces (N) and torques (N m) of the pairs `span[0]` to `span[1]`, and the work that goes with `dt` (s) since the last call.

    It is long because it is the loop that costs. `virial` is the sum of d_a F_b over contacts in J, d from the first centre to the second
    (or to the wall) and F the force on the second, shape (3, 3); `reaction` the force on each wall; `network` the F of each pair, or empty.
    """
    buf = np.empty((SUMS + 11, BLOCK))
    shift, speed, gradient, walls = frame
    row, last = np.uint64(span[0]), np.uint64(span[1])
    reach, scale, equal_mass = 2.0 * one_radius, pair.pair_scale(law, one_radius, one_radius, share), 0.5 * one_mass
    if image is None:
        reach, scale, equal_mass = one_radius, pair.wall_scale(law, one_radius), one_mass
    lost, damped, largest = 0.0, 0.0, 0.0
    shrinking, turning = False, 0.0
    if tangential is not None:
        shrinking, turning = tangential.shrinking, 1.0 if tangential.turning else 0.0
    for k in range(11):
        for q in range(BLOCK):
            buf[SUMS + k, q] = 0.0
    xx_rate, xy_rate, xz_rate = gradient[0, 0], gradient[0, 1], gradient[0, 2]
    yx_rate, yy_rate, yz_rate = gradient[1, 0], gradient[1, 1], gradient[1, 2]
    zx_rate, zy_rate, zz_rate = gradient[2, 0], gradient[2, 1], gradient[2, 2]
    carried, drifting = False, False
    for a in range(3):
        for b in range(3):
            carried = carried or gradient[a, b] != 0.0
        for k in range(len(speed)):
            drifting = drifting or speed[k, a] != 0.0
    while row < last:
        size = min(np.uint64(BLOCK), last - row)
        for q in range(size):
            i, j = first[row + q], partner[row + q]
            if image is not None:
                s = image[row + q]
                for a in range(3):
                    buf[D + a, q] = position[j, a] + shift[s, a] - position[i, a]
            else:
                for a in range(3):
                    buf[D + a, q] = walls[j, 2] - position[i, a] if a == int(walls[j, 0]) else 0.0
            if radius is not None:
                buf[RADIUS_1, q] = radius[i]
                if image is not None:
                    buf[RADIUS_2, q] = radius[j]
        if rates is not None:
            for q in range(size):
                i, j = first[row + q], partner[row + q]
                for a in range(3):
                    if image is not None:
                        buf[V + a, q] = velocity[j, a] - velocity[i, a]
                    else:
                        buf[V + a, q] = (walls[j, 3] if a == int(walls[j, 0]) else 0.0) - velocity[i, a]
                if mass is not None:
                    buf[MASS, q] = mass[i] if image is None else mass[i] * mass[j] / (mass[i] + mass[j])
            if carried:
                for q in range(size):
                    dx, dy, dz = buf[D, q], buf[D + 1, q], buf[D + 2, q]
                    buf[V, q] += dx * xx_rate + dy * yx_rate + dz * zx_rate
                    buf[V + 1, q] += dx * xy_rate + dy * yy_rate + dz * zy_rate
                    buf[V + 2, q] += dx * xz_rate + dy * yz_rate + dz * zz_rate
            if image is not None and drifting:
                for q in range(size):
                    for a in range(3):
                        buf[V + a, q] += speed[image[row + q], a]
        if spin is not None and tangential is not None:
            for q in range(size):  # mean spin, weighted with the distances from the contact to the centres
                i, j = first[row + q], partner[row + q]
                for a in range(3):
                    if image is None:
                        buf[C + a, q] = spin[i, a]
                    elif radius is None:
                        buf[C + a, q] = 0.5 * (spin[i, a] + spin[j, a])
                    else:
                        buf[C + a, q] = (radius[i] * spin[i, a] + radius[j] * spin[j, a]) / (radius[i] + radius[j])
                    if rolling is not None:
                        buf[W + a, q] = (spin[j, a] if image is not None else 0.0) - spin[i, a]
        for q in range(size):
            dx, dy, dz = buf[D, q], buf[D + 1, q], buf[D + 2, q]
            distance = math.sqrt(dx * dx + dy * dy + dz * dz)
            if radius is not None:
                reach = buf[RADIUS_1, q]
                scale = pair.wall_scale(law, reach)
                if image is not None:
                    reach = buf[RADIUS_1, q] + buf[RADIUS_2, q]
                    scale = pair.pair_scale(law, buf[RADIUS_1, q], buf[RADIUS_2, q], share)
                buf[SCALE, q] = scale
            buf[INVERSE, q], buf[OVERLAP, q] = 1.0 / max(distance, NEAREST), reach - distance
            if blocks is not None:
                buf[BLOCKS, q] = (reach - distance) * share / scale
        if blocks is not None:
            dispatch.normal_forces(law, dt, memory, row, size, buf, BLOCKS)
        for q in range(size):
            dx, dy, dz, inverse, overlap, rate = buf[D, q], buf[D + 1, q], buf[D + 2, q], buf[INVERSE, q], buf[OVERLAP, q], 0.0
            if radius is not None:
                scale = buf[SCALE, q]
            if rates is not None:
                rate = -(dx * buf[V, q] + dy * buf[V + 1, q] + dz * buf[V + 2, q]) * inverse
            if memory is None:
                f, _ = pair.pair_force(law, scale, overlap, rate, dt, dispatch.initial_state(law), share)
                if tangential is not None or damper is not None:
                    buf[CONTACT, q] = pair.pair_contact_radius(law, scale, max(overlap, 0.0), dispatch.initial_state(law), share)
            elif blocks is not None:
                f = scale * scale * buf[BLOCKS + 1, q]
                buf[SUMS + 10, q] += scale * scale * scale / share * buf[BLOCKS + 2, q]
                if tangential is not None or damper is not None:
                    state = dispatch.load_state(law, memory.T, row + q)
                    buf[CONTACT, q] = pair.pair_contact_radius(law, scale, max(overlap, 0.0), state, share)
            elif overlap > 0.0:
                f, state = pair.pair_force(law, scale, overlap, rate, dt, dispatch.load_state(law, memory, row + q), share)
                if tangential is not None or damper is not None:
                    buf[CONTACT, q] = pair.pair_contact_radius(law, scale, overlap, state, share)
                dispatch.put_back(law, memory, row + q, state)
            else:
                f = 0.0
                buf[CONTACT, q] = 0.0
                lost += forget(law, scale, share, memory, row + q)
            if damper is not None:
                m = buf[MASS, q] if mass is not None else equal_mass
                most = f + damper_force(damper, buf[CONTACT, q], m, rate)
                held = (max(most, 0.0) if overlap > 0.0 else 0.0) - f
                damped += 0.5 * (held + damping[row + q]) * rate * dt
                damping[row + q] = held
                f += held
            buf[OVERLAP, q], buf[NORMAL, q] = overlap / (scale * law.radius), f
            f *= inverse
            buf[G, q], buf[G + 1, q], buf[G + 2, q] = f * dx, f * dy, f * dz
        if tangential is not None:
            for a in range(4):  # to and from the block by themselves: what may overlap in memory is computed one by one
                for q in range(size):
                    buf[SLIP + a, q] = slip[a, row + q]
            if rolling is not None:
                for a in range(3):
                    for q in range(size):
                        buf[ROLL + a, q] = roll[a, row + q]
            for q in range(size):
                inverse = buf[INVERSE, q]
                n = (buf[D, q] * inverse, buf[D + 1, q] * inverse, buf[D + 2, q] * inverse)
                cx, cy, cz = buf[C, q], buf[C + 1, q], buf[C + 2, q]
                way = (
                    (buf[V, q] - (cy * buf[D + 2, q] - cz * buf[D + 1, q])) * dt,
                    (buf[V + 1, q] - (cz * buf[D, q] - cx * buf[D + 2, q])) * dt,
                    (buf[V + 2, q] - (cx * buf[D + 1, q] - cy * buf[D, q])) * dt,
                )
                a = buf[CONTACT, q]
                had = buf[SLIP + 3, q] if shrinking else a
                turn = (cx * n[0] + cy * n[1] + cz * n[2]) * dt * turning
                old = (buf[SLIP, q], buf[SLIP + 1, q], buf[SLIP + 2, q])
                most = tangential.friction * buf[NORMAL, q]
                s, work = dragged(tangential_stiffness(tangential, a), most, a, had, turn, n, way, old)
                buf[SLIP, q], buf[SLIP + 1, q], buf[SLIP + 2, q], buf[SLIP + 3, q] = s[0], s[1], s[2], a
                buf[HAD, q], buf[TURN, q] = had, turn
                buf[SUMS + 9, q] += work
                lever = 0.5  # of the first radius over the sum of both; with radii, over that sum
                if image is None:
                    lever = 1.0
                if radius is not None:
                    lever = 1.0 / buf[RADIUS_1, q]
                    if image is not None:
                        lever = 1.0 / (buf[RADIUS_1, q] + buf[RADIUS_2, q])
                buf[T, q] = lever * (buf[D + 1, q] * s[2] - buf[D + 2, q] * s[1])
                buf[T + 1, q] = lever * (buf[D + 2, q] * s[0] - buf[D, q] * s[2])
                buf[T + 2, q] = lever * (buf[D, q] * s[1] - buf[D + 1, q] * s[0])
                buf[G, q], buf[G + 1, q], buf[G + 2, q] = buf[G, q] - s[0], buf[G + 1, q] - s[1], buf[G + 2, q] - s[2]
            for a in range(4):
                for q in range(size):
                    slip[a, row + q] = buf[SLIP + a, q]
            if rolling is not None:
                for q in range(size):
                    inverse = buf[INVERSE, q]
                    n = (buf[D, q] * inverse, buf[D + 1, q] * inverse, buf[D + 2, q] * inverse)
                    arm = reach * 0.25 if image is not None else reach
                    if radius is not None:
                        arm = buf[RADIUS_1, q]
                        if image is not None:
                            arm = arm * buf[RADIUS_2, q] / (arm + buf[RADIUS_2, q])
                    old = (buf[ROLL, q], buf[ROLL + 1, q], buf[ROLL + 2, q])
                    angle = (buf[W, q] * dt, buf[W + 1, q] * dt, buf[W + 2, q] * dt)
                    stiffness = tangential_stiffness(tangential, buf[SLIP + 3, q]) * arm * arm
                    most = rolling.friction * arm * buf[NORMAL, q]
                    moment, work = dragged(stiffness, most, buf[SLIP + 3, q], buf[HAD, q], buf[TURN, q], n, angle, old)
                    buf[M, q], buf[M + 1, q], buf[M + 2, q] = moment
                    buf[SUMS + 9, q] += work
                for a in range(3):
                    for q in range(size):
                        roll[a, row + q] = buf[M + a, q]
        for q in range(size):
            dx, dy, dz, gx, gy, gz = buf[D, q], buf[D + 1, q], buf[D + 2, q], buf[G, q], buf[G + 1, q], buf[G + 2, q]
            buf[SUMS, q] += dx * gx
            buf[SUMS + 1, q] += dx * gy
            buf[SUMS + 2, q] += dx * gz
            buf[SUMS + 3, q] += dy * gx
            buf[SUMS + 4, q] += dy * gy
            buf[SUMS + 5, q] += dy * gz
            buf[SUMS + 6, q] += dz * gx
            buf[SUMS + 7, q] += dz * gy
            buf[SUMS + 8, q] += dz * gz
        if len(network) > 0:
            for q in range(size):
                for a in range(3):
                    network[row + q, a] = buf[G + a, q]
        # the first sphere stays the same for a few pairs: its sums wait until it changes
        current = first[row]
        fx, fy, fz, tx, ty, tz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for q in range(size):
            largest = max(largest, buf[OVERLAP, q])
            if buf[OVERLAP, q] <= 0.0:
                continue
            i, j = first[row + q], partner[row + q]
            if i != current:
                force[current, 0], force[current, 1], force[current, 2] = (
                    force[current, 0] - fx,
                    force[current, 1] - fy,
                    force[current, 2] - fz,
                )
                fx, fy, fz = 0.0, 0.0, 0.0
                if tangential is not None:
                    torque[current, 0] += tx
                    torque[current, 1] += ty
                    torque[current, 2] += tz
                    tx, ty, tz = 0.0, 0.0, 0.0
                current = i
            fx, fy, fz = fx + buf[G, q], fy + buf[G + 1, q], fz + buf[G + 2, q]
            for a in range(3):
                if image is not None:
                    force[j, a] += buf[G + a, q]
                else:
                    reaction[j, a] += buf[G + a, q]
            if tangential is not None:
                r = 1.0 if radius is None else radius[i]
                tx, ty, tz = tx + r * buf[T, q], ty + r * buf[T + 1, q], tz + r * buf[T + 2, q]
                if rolling is not None:
                    tx, ty, tz = tx + buf[M, q], ty + buf[M + 1, q], tz + buf[M + 2, q]
                if image is not None:
                    for a in range(3):
                        t = buf[T + a, q] if radius is None else buf[T + a, q] * radius[j]
                        torque[j, a] += t if rolling is None else t - buf[M + a, q]
        force[current, 0] -= fx
        force[current, 1] -= fy
        force[current, 2] -= fz
        if tangential is not None:
            torque[current, 0] += tx
            torque[current, 1] += ty
            torque[current, 2] += tz
        row += size
    for q in range(BLOCK):
        for a in range(3):
            for b in range(3):
                virial[a, b] += buf[SUMS + 3 * a + b, q]
        tally[SHEARED] += buf[SUMS + 9, q]
        tally[LOST] += buf[SUMS + 10, q]
    tally[LOST] += lost
    tally[DAMPED] += damped
    tally[LARGEST] = max(tally[LARGEST], share * largest)


@inner
def clear(sums):  # type: ignore[no-untyped-def]
    """Zeros in an array of shape (threads, k, 3)."""
    for part in range(sums.shape[0]):
        for i in range(sums.shape[1]):
            sums[part, i, 0], sums[part, i, 1], sums[part, i, 2] = 0.0, 0.0, 0.0


def _pairs_on_threads(  # type: ignore[no-untyped-def]
    law, tangential, rolling, damper, share, rates, blocks, first, partner, image, memory, slip, roll, damping,
    position, velocity, spin, radius, one_radius, mass, one_mass, frame, dt,
    force, torque, virial, reaction, network, tally,
):  # fmt: skip
    """`pair_forces` of all pairs of one kind, a share on each thread. A parallel loop takes records of values, but none of records."""
    parts, count = len(force), len(first)
    for part in numba.prange(parts):
        pair_forces(
            law, tangential, rolling, damper, share, rates, blocks, first, partner, image, memory, slip, roll, damping,
            position, velocity, spin, radius, one_radius, mass, one_mass, frame, dt,
            (count * part // parts, count * (part + 1) // parts),
            force[part], torque[part], virial[part], reaction[part], network, tally[part],
        )  # fmt: skip


pairs_on_threads = kernel(_pairs_on_threads, parallel=True)


@kernel
def forces(groups, bodies, frame, dt, force, torque, virial, reaction, tally):  # type: ignore[no-untyped-def]
    """The forces of all pairs, on one thread, with the records taken apart: only arguments are compiled away.

    No more than 30 of them: beyond, Python calls in a way that numba does not unroll.
    """
    for sums in (force, torque, virial, reaction):
        clear(sums)
    nothing = np.empty((0, 3))
    for group in literal_unroll(groups):
        roles, rows, past = group.roles, group.rows, group.past
        pair_forces(
            roles.normal, roles.tangential, roles.rolling, roles.damper, roles.share, roles.rates, roles.blocks,
            rows.first, rows.partner, rows.image, past.memory, past.slip, past.roll, past.damping,
            bodies.position, bodies.velocity, bodies.spin, bodies.radius, bodies.one_radius, bodies.mass, bodies.one_mass,
            frame, dt, (np.int64(0), len(rows.first)), force[0], torque[0], virial[0], reaction[0], nothing, tally[0],
        )  # fmt: skip


@kernel
def forces_on_threads(groups, bodies, frame, dt, force, torque, virial, reaction, tally):  # type: ignore[no-untyped-def]
    """`forces` with a share of the pairs on each thread, which has a row of the sums."""
    for sums in (force, torque, virial, reaction):
        clear(sums)
    nothing = np.empty((0, 3))
    for group in literal_unroll(groups):
        roles, rows, past = group.roles, group.rows, group.past
        pairs_on_threads(
            roles.normal, roles.tangential, roles.rolling, roles.damper, roles.share, roles.rates, roles.blocks,
            rows.first, rows.partner, rows.image, past.memory, past.slip, past.roll, past.damping,
            bodies.position, bodies.velocity, bodies.spin, bodies.radius, bodies.one_radius, bodies.mass, bodies.one_mass,
            frame, dt,
            force, torque, virial, reaction, nothing, tally,
        )  # fmt: skip


@kernel
def contact_energies(law, tangential, rolling, share, memory, slip, roll, overlap, radius_1, radius_2, walls):  # type: ignore[no-untyped-def]
    """Stored and dissipated energy in J of pairs by their law, and what tangential forces and rolling moments store; `walls`: flats."""
    stored, dissipated, sheared = 0.0, 0.0, 0.0
    for row in range(len(overlap)):
        if overlap[row] <= 0.0:
            continue
        scale = pair.wall_scale(law, radius_1[row]) if walls else pair.pair_scale(law, radius_1[row], radius_2[row], share)
        state = dispatch.initial_state(law) if memory is None else dispatch.load_state(law, memory, row)
        kept, used = pair.pair_energy(law, scale, overlap[row], state, share)
        stored, dissipated = stored + kept, dissipated + used
        if tangential is not None:
            stiffness = tangential_stiffness(tangential, max(slip[3, row], NEAREST))
            sheared += 0.5 * (slip[0, row] ** 2 + slip[1, row] ** 2 + slip[2, row] ** 2) / stiffness
            if rolling is not None:
                arm = radius_1[row] if walls else radius_1[row] * radius_2[row] / (radius_1[row] + radius_2[row])
                sheared += 0.5 * (roll[0, row] ** 2 + roll[1, row] ** 2 + roll[2, row] ** 2) / (stiffness * arm * arm)
    return stored, dissipated, sheared
