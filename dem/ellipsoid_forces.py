"""The pair kernel of ellipsoids: what `dem.forces` is for spheres, with the same pair list, box, walls and sums.

Pairs whose bounding spheres meet are taken in blocks. Their common normals are improved by one step of Newton's method from those of the
step before, all at once and without a branch, so that the compiler makes it several pairs wide; the few for which that is not enough (new
contacts, fast turns, deep overlaps) are looked at one by one. Forces act in the contact point, where the surfaces meet.
"""

from __future__ import annotations

import math

import numba
import numpy as np
from numba import literal_unroll

from contactlaws import shaped
from contactlaws.compiled import inlined, inner, kernel
from contactlaws.ellipsoid_gap import DEEP, closest, dot, look, pair_shape, times, wall_shape
from contactlaws.tangential import damper_force, dragged, tangential_stiffness
from dem.forces import BLOCK, DAMPED, LARGEST, NEAREST, ONE, PRESSED, SHEARED, clear

#: rows of what a contact remembers: the common normal (also of pairs that are apart); overlap in m; normal force of the law in N; what
#: contactlaws.shaped.ROLLED says; the law's own
AXIS, BEFORE, PUSH, ROLLED, OF_LAW = 0, 3, 4, 5, 9
#: columns of `rotation.Shapes.extent`
REACH, SHARPEST, GRACE = 0, 1, 2
#: rows of a block: centre to centre; normal; tensors; mean radii; overlap before and now; contact point; shape of the gap; what has been
#: found; the largest turn, squared, for which one step of Newton's method is enough
D, N, S_1, S_2, MEAN_1, MEAN_2, HAD, GAP, POINT, RADIUS, RATIO, STATE, LIMIT, MEAN = 0, 3, 6, 12, 18, 19, 20, 21, 22, 25, 26, 27, 28, 29
ROWS = 30
#: of a pair: its bodies are apart; they touch; one has to look
APART, TOUCHING, OPEN = 0.0, 1.0, 2.0


@inlined
def six(array, row, column):  # type: ignore[no-untyped-def]
    """A tensor from a block."""
    return (
        array[row, column],
        array[row + 1, column],
        array[row + 2, column],
        array[row + 3, column],
        array[row + 4, column],
        array[row + 5, column],
    )


@inlined
def three(array, row, column):  # type: ignore[no-untyped-def]
    """A vector from a block."""
    return array[row, column], array[row + 1, column], array[row + 2, column]


@inlined
def improve(buf, size):  # type: ignore[no-untyped-def]
    """One step of Newton's method for every pair of a block, and what follows from it.

    Overlap, normal, contact point and curvatures are right to the second order of the turn, so nothing is evaluated twice.
    """
    for q in range(size):
        s_1, s_2, d, n = six(buf, S_1, q), six(buf, S_2, q), three(buf, D, q), three(buf, N, q)
        mean_1, mean_2 = buf[MEAN_1, q], buf[MEAN_2, q]
        g, h_1, h_2, k, j, p, r, e, f, gx, gy, xx, xy, yy = look(s_1, s_2, d, n)
        a, c = xx - g, yy - g
        determinant = a * c - xy * xy
        i = 1.0 / determinant
        x, y = (xy * gy - c * gx) * i, (xy * gx - a * gy) * i
        deeper = g + 0.5 * (gx * x + gy * y)
        way = (x * e[0] + y * f[0], x * e[1] + y * f[1], x * e[2] + y * f[2])
        moved = times(s_1, way)
        along = dot(p, way)
        nx, ny, nz = n[0] + way[0], n[1] + way[1], n[2] + way[2]
        off = nx * nx + ny * ny + nz * nz - 1.0
        unit = 1.0 + off * (-0.5 + 0.375 * off)  # 1/sqrt(1 + off), so near to 1; what is left goes with the next step
        nx, ny, nz = nx * unit, ny * unit, nz * unit
        of_both = 1.0 / (mean_1 + mean_2)
        back = deeper * mean_1 * of_both
        buf[MEAN, q] = mean_1 * mean_2 * of_both
        buf[N, q], buf[N + 1, q], buf[N + 2, q] = nx, ny, nz
        buf[POINT, q] = p[0] + (moved[0] - p[0] * along) * k - back * nx
        buf[POINT + 1, q] = p[1] + (moved[1] - p[1] * along) * k - back * ny
        buf[POINT + 2, q] = p[2] + (moved[2] - p[2] * along) * k - back * nz
        buf[RADIUS, q], buf[RATIO, q] = pair_shape(s_1, s_2, mean_1, mean_2, k, j, p, r, xx, xy, yy)
        buf[GAP, q] = deeper
        sure = (x * x + y * y < buf[LIMIT, q]) & (determinant > 0.0) & (a + c > 0.0) & (buf[HAD, q] > 0.0)
        sure = sure & (deeper <= DEEP * (h_1 + h_2)) & (deeper > 0.0)
        buf[STATE, q] = APART if g < 0.0 else (TOUCHING if sure else OPEN)


@inner
def look_closely(buf, q, n, sharpest):  # type: ignore[no-untyped-def]
    """What `improve` finds, of one pair from the normal `n` on, however far that is from the common one."""
    s_1, s_2, d = six(buf, S_1, q), six(buf, S_2, q), three(buf, D, q)
    mean_1, mean_2 = buf[MEAN_1, q], buf[MEAN_2, q]
    n, _ = closest(s_1, s_2, d, n, sharpest, buf[HAD, q] > 0.0, False)
    g, _, _, k, j, p, r, _, _, _, _, xx, xy, yy = look(s_1, s_2, d, n)
    back = g * mean_1 / (mean_1 + mean_2)
    for axis in range(3):
        buf[N + axis, q] = n[axis]
        buf[POINT + axis, q] = p[axis] - back * n[axis]
    buf[RADIUS, q], buf[RATIO, q] = pair_shape(s_1, s_2, mean_1, mean_2, k, j, p, r, xx, xy, yy)
    buf[GAP, q] = g
    buf[STATE, q] = TOUCHING if g > 0.0 else APART


@inlined
def on_wall(buf, q):  # type: ignore[no-untyped-def]
    """What `improve` finds, of an ellipsoid and a flat: the normal is the flat's, all else is closed."""
    s, n = six(buf, S_1, q), three(buf, N, q)
    p = times(s, n)
    k = 1.0 / math.sqrt(dot(p, n))
    p = (p[0] * k, p[1] * k, p[2] * k)
    h = dot(p, n)
    g = h - dot(three(buf, D, q), n)
    for axis in range(3):
        buf[POINT + axis, q] = p[axis] - g * n[axis]
    buf[RADIUS, q], buf[RATIO, q] = wall_shape(s, buf[MEAN_1, q], h, p)
    buf[GAP, q], buf[MEAN, q] = g, buf[MEAN_1, q]
    buf[STATE, q] = TOUCHING if g > 0.0 else APART


@inner
def ended(memory, slip, damping, row):  # type: ignore[no-untyped-def]
    """Clear what a contact remembers, but for the normal; the works in J of its last bit of way, of the law and of the damper."""
    before = memory[BEFORE, row]
    pressed, damped = -0.5 * memory[PUSH, row] * before, 0.0
    for k in range(BEFORE, len(memory)):
        memory[k, row] = 0.0
    if slip is not None:
        for a in range(4):
            slip[a, row] = 0.0
    if damping is not None:
        damped = -0.5 * damping[row] * before
        damping[row] = 0.0
    return pressed, damped


@kernel
def ellipsoid_forces(  # type: ignore[no-untyped-def]
    law, tangential, damper, share, rates, first, partner, image, memory, slip, damping,
    position, velocity, spin, radius, mass, one_mass, surface, extent, frame, dt, span,
    force, torque, virial, reaction, network, tally,
):  # fmt: skip
    """Add the forces (N) and torques (N m) of the pairs `span[0]` to `span[1]`: see `dem.forces.pair_forces`.

    `radius` holds mean radii. The tally gets the work of the normal forces of the law, F d(overlap): with a common normal that is all of
    it, since points in contact move apart along the normal as the overlap shrinks. What of it is not stored has been dissipated.
    """
    buf, place = np.empty((ROWS, BLOCK)), np.empty(BLOCK, np.uint64)
    shift, speed, gradient, walls = frame
    row, last = np.uint64(span[0]), np.uint64(span[1])
    pressed, damped, sheared, largest = 0.0, 0.0, 0.0, 0.0
    xx, xy, xz, yx, yy, yz, zx, zy, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    shrinking, turning, scale = False, 0.0, 1.0 / share
    if tangential is not None:
        shrinking, turning = tangential.shrinking, 1.0 if tangential.turning else 0.0
    while row < last:
        size = np.uint64(0)
        while row < last and size < np.uint64(BLOCK):
            i, j, reach = first[row], partner[row], extent[first[row], REACH]
            if image is not None:
                s = image[row]
                for a in range(3):
                    buf[D + a, size] = position[j, a] + shift[s, a] - position[i, a]
                    buf[N + a, size] = memory[AXIS + a, row]
                reach += extent[j, REACH]
            else:
                for a in range(3):
                    here = a == int(walls[j, 0])
                    buf[D + a, size] = walls[j, 2] - position[i, a] if here else 0.0
                    buf[N + a, size] = -walls[j, 1] if here else 0.0
            d = three(buf, D, size)
            if dot(d, d) < reach * reach:
                for k in range(6):
                    buf[S_1 + k, size] = surface[i, k]
                buf[MEAN_1, size] = radius[i]
                if image is not None:
                    for k in range(6):
                        buf[S_2 + k, size] = surface[j, k]
                    buf[MEAN_2, size] = radius[j]
                    buf[LIMIT, size] = min(extent[i, GRACE], extent[j, GRACE])
                buf[HAD, size] = memory[BEFORE, row]
                place[size] = row
                size += ONE
            elif memory[BEFORE, row] != 0.0:
                one, two = ended(memory, slip, damping, row)
                pressed, damped = pressed + one, damped + two
            row += ONE
        if image is not None:
            improve(buf, size)
        else:
            for q in range(size):
                on_wall(buf, q)
        # the first body stays the same for a few pairs: its sums wait until it changes
        current = first[place[0]] if size > np.uint64(0) else first[row - ONE]
        fx, fy, fz, tx, ty, tz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for q in range(size):
            at = place[q]
            i, j = first[at], partner[at]
            if image is not None:
                if buf[STATE, q] == OPEN:
                    look_closely(buf, q, three(memory, AXIS, at), extent[i, SHARPEST] + extent[j, SHARPEST])
                    for a in range(3):
                        memory[AXIS + a, at] = buf[N + a, q]
                elif buf[STATE, q] == TOUCHING:
                    for a in range(3):
                        memory[AXIS + a, at] = buf[N + a, q]
            else:
                for a in range(3):
                    memory[AXIS + a, at] = buf[N + a, q]
            if buf[STATE, q] == APART:
                if buf[HAD, q] != 0.0:
                    one, two = ended(memory, slip, damping, at)
                    pressed, damped = pressed + one, damped + two
                continue
            n, p, overlap = three(buf, N, q), three(buf, POINT, q), buf[GAP, q]
            mean = buf[MEAN, q] * scale
            shape, deep = (buf[RADIUS, q] * scale, buf[RATIO, q], mean), overlap * share
            own = shaped.remembered(law, memory, OF_LAW, at)
            rolled = (memory[ROLLED, at], memory[ROLLED + 1, at], memory[ROLLED + 2, at], memory[ROLLED + 3, at])
            f, own, rolled = shaped.shaped_force(law, shape, deep, own, rolled)
            change = overlap - buf[HAD, q]
            pressed += 0.5 * (f + memory[PUSH, at]) * change
            largest = max(largest, deep / mean)
            memory[BEFORE, at], memory[PUSH, at] = overlap, f
            for k in range(4):
                memory[ROLLED + k, at] = rolled[k]
            shaped.remember(law, memory, OF_LAW, at, own)
            d = (p[0], p[1], p[2])
            if image is not None:
                d = three(buf, D, q)
            if rates is not None:
                width = shaped.contact_radius(law, shaped.counted(shape, rolled), deep, own)
                v = relative_velocity(velocity, spin, walls, gradient, speed, image, at, i, j, d, p)
                if damper is not None:
                    m = one_mass if image is None else 0.5 * one_mass
                    if mass is not None:
                        m = mass[i] if image is None else mass[i] * mass[j] / (mass[i] + mass[j])
                    held = max(f + damper_force(damper, width, m, -dot(v, n)), 0.0) - f
                    damped += 0.5 * (held + damping[at]) * change
                    damping[at] = held
                    f += held
            gx, gy, gz = f * n[0], f * n[1], f * n[2]
            if tangential is not None:
                had = slip[3, at] if shrinking else width
                spun = spin[i, 0] * n[0] + spin[i, 1] * n[1] + spin[i, 2] * n[2]
                if image is not None:
                    other = spin[j, 0] * n[0] + spin[j, 1] * n[1] + spin[j, 2] * n[2]
                    spun = (buf[MEAN_1, q] * spun + buf[MEAN_2, q] * other) / (buf[MEAN_1, q] + buf[MEAN_2, q])
                way, most = (v[0] * dt, v[1] * dt, v[2] * dt), tangential.friction * f
                stiffness, old = tangential_stiffness(tangential, width), (slip[0, at], slip[1, at], slip[2, at])
                t, work = dragged(stiffness, most, width, had, spun * dt * turning, n, way, old)
                slip[0, at], slip[1, at], slip[2, at], slip[3, at] = t[0], t[1], t[2], width
                sheared += work
                gx, gy, gz = gx - t[0], gy - t[1], gz - t[2]
            if i != current:
                force[current, 0], force[current, 1], force[current, 2] = (
                    force[current, 0] - fx,
                    force[current, 1] - fy,
                    force[current, 2] - fz,
                )
                torque[current, 0], torque[current, 1], torque[current, 2] = (
                    torque[current, 0] - tx,
                    torque[current, 1] - ty,
                    torque[current, 2] - tz,
                )
                fx, fy, fz, tx, ty, tz, current = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, i
            fx, fy, fz = fx + gx, fy + gy, fz + gz
            tx, ty, tz = tx + p[1] * gz - p[2] * gy, ty + p[2] * gx - p[0] * gz, tz + p[0] * gy - p[1] * gx
            if image is not None:
                x, y, z = p[0] - d[0], p[1] - d[1], p[2] - d[2]
                force[j, 0], force[j, 1], force[j, 2] = force[j, 0] + gx, force[j, 1] + gy, force[j, 2] + gz
                torque[j, 0] += y * gz - z * gy
                torque[j, 1] += z * gx - x * gz
                torque[j, 2] += x * gy - y * gx
            else:
                reaction[j, 0], reaction[j, 1], reaction[j, 2] = reaction[j, 0] + gx, reaction[j, 1] + gy, reaction[j, 2] + gz
            xx, xy, xz = xx + d[0] * gx, xy + d[0] * gy, xz + d[0] * gz
            yx, yy, yz = yx + d[1] * gx, yy + d[1] * gy, yz + d[1] * gz
            zx, zy, zz = zx + d[2] * gx, zy + d[2] * gy, zz + d[2] * gz
            if len(network) > 0:
                network[at, 0], network[at, 1], network[at, 2] = gx, gy, gz
        force[current, 0] -= fx
        force[current, 1] -= fy
        force[current, 2] -= fz
        torque[current, 0], torque[current, 1], torque[current, 2] = (
            torque[current, 0] - tx,
            torque[current, 1] - ty,
            torque[current, 2] - tz,
        )
    virial[0, 0], virial[0, 1], virial[0, 2] = virial[0, 0] + xx, virial[0, 1] + xy, virial[0, 2] + xz
    virial[1, 0], virial[1, 1], virial[1, 2] = virial[1, 0] + yx, virial[1, 1] + yy, virial[1, 2] + yz
    virial[2, 0], virial[2, 1], virial[2, 2] = virial[2, 0] + zx, virial[2, 1] + zy, virial[2, 2] + zz
    tally[PRESSED] += pressed
    tally[DAMPED] += damped
    tally[SHEARED] += sheared
    tally[LARGEST] = max(tally[LARGEST], largest)


@kernel
def ellipsoid_energies(law, tangential, share, memory, slip, radius_1, radius_2, walls):  # type: ignore[no-untyped-def]
    """What can be got back in J of pairs by their law, and what tangential forces store; mean radii in m."""
    held, sheared = 0.0, 0.0
    for row in range(memory.shape[1]):
        if memory[BEFORE, row] <= 0.0:
            continue
        mean = (radius_1[row] if walls else radius_1[row] * radius_2[row] / (radius_1[row] + radius_2[row])) / share
        rolled = (memory[ROLLED, row], memory[ROLLED + 1, row], memory[ROLLED + 2, row], memory[ROLLED + 3, row])
        own = shaped.remembered(law, memory, OF_LAW, row)
        held += shaped.shaped_stored(law, mean, memory[BEFORE, row] * share, own, rolled) / share
        if tangential is not None:
            stiffness = tangential_stiffness(tangential, max(slip[3, row], NEAREST))
            sheared += 0.5 * (slip[0, row] ** 2 + slip[1, row] ** 2 + slip[2, row] ** 2) / stiffness
    return held, sheared


@inlined
def relative_velocity(velocity, spin, walls, gradient, speed, image, row, i, j, d, p):  # type: ignore[no-untyped-def]
    """Of the second surface (or the wall) against the first in the contact point, m/s: p from the first centre, d to the second."""
    vx, vy, vz = -velocity[i, 0], -velocity[i, 1], -velocity[i, 2]
    if image is not None:
        s = image[row]
        vx, vy, vz = vx + velocity[j, 0] + speed[s, 0], vy + velocity[j, 1] + speed[s, 1], vz + velocity[j, 2] + speed[s, 2]
        x, y, z = p[0] - d[0], p[1] - d[1], p[2] - d[2]
        vx += spin[j, 1] * z - spin[j, 2] * y
        vy += spin[j, 2] * x - spin[j, 0] * z
        vz += spin[j, 0] * y - spin[j, 1] * x
    else:
        axis = int(walls[j, 0])
        vx += walls[j, 3] if axis == 0 else 0.0
        vy += walls[j, 3] if axis == 1 else 0.0
        vz += walls[j, 3] if axis == 2 else 0.0
    vx += d[0] * gradient[0, 0] + d[1] * gradient[1, 0] + d[2] * gradient[2, 0] - spin[i, 1] * p[2] + spin[i, 2] * p[1]
    vy += d[0] * gradient[0, 1] + d[1] * gradient[1, 1] + d[2] * gradient[2, 1] - spin[i, 2] * p[0] + spin[i, 0] * p[2]
    vz += d[0] * gradient[0, 2] + d[1] * gradient[1, 2] + d[2] * gradient[2, 2] - spin[i, 0] * p[1] + spin[i, 1] * p[0]
    return vx, vy, vz


def _ellipsoids_on_threads(  # type: ignore[no-untyped-def]
    law, tangential, damper, share, rates, first, partner, image, memory, slip, damping,
    position, velocity, spin, radius, mass, one_mass, surface, extent, frame, dt,
    force, torque, virial, reaction, network, tally,
):  # fmt: skip
    """`ellipsoid_forces` of all pairs of one kind, a share on each thread."""
    parts, count = len(force), len(first)
    for part in numba.prange(parts):
        ellipsoid_forces(
            law, tangential, damper, share, rates, first, partner, image, memory, slip, damping,
            position, velocity, spin, radius, mass, one_mass, surface, extent, frame, dt,
            (count * part // parts, count * (part + 1) // parts),
            force[part], torque[part], virial[part], reaction[part], network, tally[part],
        )  # fmt: skip


ellipsoids_on_threads = kernel(_ellipsoids_on_threads, parallel=True)


@kernel
def forces_of_ellipsoids(groups, bodies, shapes, frame, dt, force, torque, virial, reaction, tally):  # type: ignore[no-untyped-def]
    """The forces of all pairs, on one thread; no more than 30 arguments are handed on, see `dem.forces.forces`."""
    for sums in (force, torque, virial, reaction):
        clear(sums)
    nothing = np.empty((0, 3))
    for group in literal_unroll(groups):
        roles, rows, past = group.roles, group.rows, group.past
        ellipsoid_forces(
            roles.normal, roles.tangential, roles.damper, roles.share, roles.rates,
            rows.first, rows.partner, rows.image, past.memory, past.slip, past.damping,
            bodies.position, bodies.velocity, bodies.spin, bodies.radius, bodies.mass, bodies.one_mass,
            shapes.surface, shapes.extent,
            frame, dt, (np.int64(0), len(rows.first)), force[0], torque[0], virial[0], reaction[0], nothing, tally[0],
        )  # fmt: skip


@kernel
def forces_of_ellipsoids_on_threads(groups, bodies, shapes, frame, dt, force, torque, virial, reaction, tally):  # type: ignore[no-untyped-def]
    """The same with a share of the pairs on each thread, which has a row of the sums."""
    for sums in (force, torque, virial, reaction):
        clear(sums)
    nothing = np.empty((0, 3))
    for group in literal_unroll(groups):
        roles, rows, past = group.roles, group.rows, group.past
        ellipsoids_on_threads(
            roles.normal, roles.tangential, roles.damper, roles.share, roles.rates,
            rows.first, rows.partner, rows.image, past.memory, past.slip, past.damping,
            bodies.position, bodies.velocity, bodies.spin, bodies.radius, bodies.mass, bodies.one_mass,
            shapes.surface, shapes.extent,
            frame, dt, force, torque, virial, reaction, nothing, tally,
        )  # fmt: skip
