"""The pair kernel of ellipsoids: what `dem.forces` is for spheres, with the same pair list, box, walls and sums.

Pairs whose bounding spheres meet are taken in blocks. Their common normals are improved by one step of Newton's method from those of the
step before, all at once and without a branch, so that the compiler makes it several pairs wide; the few for which that is not enough (new
contacts, fast turns, deep overlaps) are looked at one by one. Those that touch move to the front of the block, and so do their forces: by
the law, by friction, each in a pass of its own over all of them; the few that have rolled to another shape are asked one by one. Sums go
over contacts in the order of the list, however they fall into blocks. Forces act in the contact point, where the surfaces meet.
"""

from __future__ import annotations

import math

import numba
import numpy as np
from numba import literal_unroll

from contactlaws import shaped
from contactlaws.compiled import inlined, inner, kernel
from contactlaws.ellipsoid_gap import DEEP, closest, dot, downhill, look, pair_shape, radii_tensor, times, touched, trace_across, wall_shape
from contactlaws.tangential import damper_force, dragged, tangential_stiffness
from dem.forces import DAMPED, LARGEST, NEAREST, ONE, PRESSED, SHEARED, clear

#: rows of what a contact remembers: the common normal (also of pairs that are apart); of those, how far in m the centres must be from each
#: other along it to be apart for sure, less how far surfaces had turned by then, or 0; overlap in m; normal force of the law in N; what
#: contactlaws.shaped.ROLLED says; the law's own
AXIS, FREE, BEFORE, PUSH, ROLLED, OF_LAW = 0, 3, 4, 5, 6, 10
#: columns of `rotation.Shapes.surface` after the tensor
REACH, SHARPEST, GRACE = 6, 7, 8
#: pairs taken at a time
BLOCK = 32
#: rows of a block. Of a pair: centre to centre; normal; contact point; overlap now and before; shape of the gap; mean radius of both as of
#: a body on a flat, times the share; mean radii
D, N, POINT, GAP, HAD, RADIUS, RATIO, MEAN, MEAN_1, MEAN_2 = 0, 3, 6, 9, 10, 11, 12, 13, 14, 15
OF_PAIR = 16
#: of the search: what has been found; the largest turn, squared, for which one step of Newton's method is enough; tensors
STATE, LIMIT, S_1, S_2, INVERSE_1, INVERSE_2, TRACE_1, TRACE_2, DETERMINANT = 16, 17, 18, 24, 30, 31, 32, 33, 34
#: of those that touch: see shaped.ROLLED; force of the law before and now; contact radius; whether one has to ask alone; velocity of the
#: second centre against the first; spins; friction; force on the second body; torques; the law's own memory
WAS, PUSHED, FORCE, WIDTH, ALONE, V, SPIN_1, SPIN_2 = 16, 20, 21, 22, 23, 24, 27, 30
SLIP, G, T_1, T_2, WORK, OWN = 33, 37, 40, 43, 46, 47
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

    Overlap, normal and contact point are right to the second order of the turn, so nothing is evaluated twice; the curvatures are those at
    the normal of the step before, right to the first.
    """
    for q in range(size):
        s_1, s_2, d, n = six(buf, S_1, q), six(buf, S_2, q), three(buf, D, q), three(buf, N, q)
        mean_1, mean_2 = buf[MEAN_1, q], buf[MEAN_2, q]
        radii = mean_1 + mean_2
        h_1, h_2, k, j, p, r = touched(s_1, s_2, n)
        g, off = h_1 + h_2 - dot(d, n), (p[0] + r[0] - d[0], p[1] + r[1] - d[1], p[2] + r[2] - d[2])
        w = radii_tensor(s_1, s_2, k, j, p, r)
        step, determinant = downhill(w, g, n, off, radii)
        once = 1.0 / (determinant * radii)  # one division for both
        i, of_both = once * radii, once * determinant
        determinant *= of_both
        way = (-i * step[0], -i * step[1], -i * step[2])
        trace, turn = w[0] + w[3] + w[5], dot(way, way)
        deeper = g + 0.5 * dot(off, way)
        moved = times(s_1, way)
        along = dot(p, way)
        nx, ny, nz = n[0] + way[0], n[1] + way[1], n[2] + way[2]
        off_unit = nx * nx + ny * ny + nz * nz - 1.0
        unit = 1.0 + off_unit * (-0.5 + 0.375 * off_unit)  # 1/sqrt(1 + off_unit), so near to 1; what is left goes with the next step
        nx, ny, nz = nx * unit, ny * unit, nz * unit
        back = deeper * mean_1 * of_both
        buf[MEAN, q] = mean_1 * mean_2 * of_both
        buf[N, q], buf[N + 1, q], buf[N + 2, q] = nx, ny, nz
        buf[POINT, q] = p[0] + (moved[0] - p[0] * along) * k - back * nx
        buf[POINT + 1, q] = p[1] + (moved[1] - p[1] * along) * k - back * ny
        buf[POINT + 2, q] = p[2] + (moved[2] - p[2] * along) * k - back * nz
        buf[INVERSE_1, q], buf[INVERSE_2, q], buf[TRACE_1, q], buf[TRACE_2, q] = k, j, trace_across(s_1, p), trace_across(s_2, r)
        buf[DETERMINANT, q] = determinant + g * (trace - g)
        buf[GAP, q] = g if g < 0.0 else deeper  # of bodies apart that along the normal they had
        sure = (turn < buf[LIMIT, q]) & (determinant > 0.0) & (trace > 2.0 * g) & (buf[HAD, q] > 0.0)
        sure = sure & (deeper <= DEEP * (h_1 + h_2)) & (deeper > 0.0)
        buf[STATE, q] = APART if g < 0.0 else (TOUCHING if sure else OPEN)
    for q in range(size):  # by itself: roots and divisions wait for each other, and a short loop has many of them on the way
        mean_1, mean_2, k, j = buf[MEAN_1, q], buf[MEAN_2, q], buf[INVERSE_1, q], buf[INVERSE_2, q]
        buf[RADIUS, q], buf[RATIO, q] = pair_shape(buf[TRACE_1, q], buf[TRACE_2, q], mean_1, mean_2, k, j, buf[DETERMINANT, q])


@inner
def look_closely(buf, q, n, sharpest):  # type: ignore[no-untyped-def]
    """What `improve` finds, of one pair from the normal `n` on, however far that is from the common one."""
    s_1, s_2, d = six(buf, S_1, q), six(buf, S_2, q), three(buf, D, q)
    mean_1, mean_2 = buf[MEAN_1, q], buf[MEAN_2, q]
    n, _ = closest(s_1, s_2, d, n, sharpest, buf[HAD, q] > 0.0, False)
    g, _, _, k, j, p, r, _, _, _, _, xx, xy, yy = look(s_1, s_2, d, n)
    back = g * mean_1 / (mean_1 + mean_2)
    buf[MEAN, q] = mean_1 * mean_2 / (mean_1 + mean_2)
    for axis in range(3):
        buf[N + axis, q] = n[axis]
        buf[POINT + axis, q] = p[axis] - back * n[axis]
    buf[RADIUS, q], buf[RATIO, q] = pair_shape(trace_across(s_1, p), trace_across(s_2, r), mean_1, mean_2, k, j, xx * yy - xy * xy)
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


@inlined
def to_the_front(buf, place, q, to):  # type: ignore[no-untyped-def]
    """Move what has been found of a pair to another place in its block."""
    for k in range(OF_PAIR):
        buf[k, to] = buf[k, q]
    place[to] = place[q]


@inlined
def on_flat(share, buf, q):  # type: ignore[no-untyped-def]
    """Shape, and overlap in m, of the one body on a flat that a contact of a block is to the law: see `contactlaws.shaped`."""
    scale = 1.0 / share
    return (buf[RADIUS, q] * scale, buf[RATIO, q], buf[MEAN, q] * scale), buf[GAP, q] * share


@inlined
def answered(law, buf, q, found):  # type: ignore[no-untyped-def]
    """Write what the law has found for a contact into its block: force, the law's memory, `shaped.ROLLED`."""
    buf[FORCE, q], own, rolled = found
    shaped.remember(law, buf, OWN, q, own)
    buf[WAS, q], buf[WAS + 1, q], buf[WAS + 2, q], buf[WAS + 3, q] = rolled


@inlined
def pushed(law, share, buf, size):  # type: ignore[no-untyped-def]
    """Forces of the law, of all contacts of a block whose shape lasts; tells the others."""
    for q in range(size):
        shape, deep = on_flat(share, buf, q)
        rolled = shaped.begun(shape, (buf[WAS, q], buf[WAS + 1, q], buf[WAS + 2, q], buf[WAS + 3, q]))
        buf[ALONE, q] = 0.0 if shaped.lasting(shape, deep, rolled) else 1.0
        answered(law, buf, q, shaped.lasting_force(law, shape, deep, shaped.remembered(law, buf, OWN, q), rolled))


@inner
def pushed_alone(law, share, buf, q, memory, row):  # type: ignore[no-untyped-def]
    """The force of the law of a contact that has rolled, from what was before it."""
    shape, deep = on_flat(share, buf, q)
    rolled = (memory[ROLLED, row], memory[ROLLED + 1, row], memory[ROLLED + 2, row], memory[ROLLED + 3, row])
    answered(law, buf, q, shaped.shaped_force(law, shape, deep, shaped.remembered(law, memory, OF_LAW, row), rolled))


@inlined
def widths(law, share, buf, size):  # type: ignore[no-untyped-def]
    """Contact radii that belong to the forces."""
    scale = 1.0 / share
    for q in range(size):
        shape = (buf[WAS, q], buf[WAS + 1, q], buf[MEAN, q] * scale)
        buf[WIDTH, q] = shaped.contact_radius(law, shape, buf[GAP, q] * share, shaped.remembered(law, buf, OWN, q))


@inlined
def slid(buf, size, gradient, image):  # type: ignore[no-untyped-def]
    """Velocities of the second surfaces against the first in the contact points, in place of those of the centres.

    gradient: 1/s, of the box, which carries the second body along with the first. image: None if that is a wall, which does not turn.
    """
    for q in range(size):
        d, p = three(buf, D, q), three(buf, POINT, q)
        ux, uy, uz = three(buf, SPIN_1, q)
        vx = buf[V, q] + d[0] * gradient[0, 0] + d[1] * gradient[1, 0] + d[2] * gradient[2, 0] - uy * p[2] + uz * p[1]
        vy = buf[V + 1, q] + d[0] * gradient[0, 1] + d[1] * gradient[1, 1] + d[2] * gradient[2, 1] - uz * p[0] + ux * p[2]
        vz = buf[V + 2, q] + d[0] * gradient[0, 2] + d[1] * gradient[1, 2] + d[2] * gradient[2, 2] - ux * p[1] + uy * p[0]
        if image is not None:
            x, y, z = p[0] - d[0], p[1] - d[1], p[2] - d[2]
            wx, wy, wz = three(buf, SPIN_2, q)
            vx, vy, vz = vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x
        buf[V, q], buf[V + 1, q], buf[V + 2, q] = vx, vy, vz


@inlined
def rubbed(tangential, buf, size, dt, image):  # type: ignore[no-untyped-def]
    """Friction: what it is now, what it takes from the force on the second body, and its work in J. `image`: see `slid`."""
    turning = 1.0 if tangential.turning else 0.0
    for q in range(size):
        n, width = three(buf, N, q), buf[WIDTH, q]
        spun = dot(three(buf, SPIN_1, q), n)
        if image is not None:
            mean_1, mean_2 = buf[MEAN_1, q], buf[MEAN_2, q]
            spun = (mean_1 * spun + mean_2 * dot(three(buf, SPIN_2, q), n)) / (mean_1 + mean_2)
        had = buf[SLIP + 3, q] if tangential.shrinking else width
        way, old = (buf[V, q] * dt, buf[V + 1, q] * dt, buf[V + 2, q] * dt), three(buf, SLIP, q)
        most, stiffness = tangential.friction * dot(three(buf, G, q), n), tangential_stiffness(tangential, width)
        t, work = dragged(stiffness, most, width, had, spun * dt * turning, n, way, old)
        buf[SLIP, q], buf[SLIP + 1, q], buf[SLIP + 2, q], buf[SLIP + 3, q] = t[0], t[1], t[2], width
        buf[G, q], buf[G + 1, q], buf[G + 2, q] = buf[G, q] - t[0], buf[G + 1, q] - t[1], buf[G + 2, q] - t[2]
        buf[WORK, q] = work


@inlined
def twisted(buf, size):  # type: ignore[no-untyped-def]
    """Torques on both bodies of a force on the second in the contact point."""
    for q in range(size):
        d, p, g = three(buf, D, q), three(buf, POINT, q), three(buf, G, q)
        buf[T_1, q], buf[T_1 + 1, q], buf[T_1 + 2, q] = p[1] * g[2] - p[2] * g[1], p[2] * g[0] - p[0] * g[2], p[0] * g[1] - p[1] * g[0]
        x, y, z = p[0] - d[0], p[1] - d[1], p[2] - d[2]
        buf[T_2, q], buf[T_2 + 1, q], buf[T_2 + 2, q] = y * g[2] - z * g[1], z * g[0] - x * g[2], x * g[1] - y * g[0]


@inlined
def less(force, torque, body, f, t):  # type: ignore[no-untyped-def]
    """Take from a body what it does to those that it touches."""
    for a in range(3):
        force[body, a] -= f[a]
        torque[body, a] -= t[a]


@kernel
def ellipsoid_forces(  # type: ignore[no-untyped-def]
    law, tangential, damper, share, rates, first, partner, image, memory, slip, damping,
    position, velocity, spin, radius, mass, one_mass, surface, turned, frame, dt, span,
    force, torque, virial, reaction, network, tally,
):  # fmt: skip
    """Add the forces (N) and torques (N m) of the pairs `span[0]` to `span[1]`: see `dem.forces.pair_forces`.

    `radius` holds mean radii. The tally gets the work of the normal forces of the law, F d(overlap): with a common normal that is all of
    it, since points in contact move apart along the normal as the overlap shrinks. What of it is not stored has been dissipated.

    A pair that was apart along its normal is passed over until its centres have come nearer along it, or surfaces have turned, by as much
    as its gap: to look at it would find it apart, and change nothing.
    """
    buf, place = np.empty((OWN + len(memory) - OF_LAW, BLOCK)), np.empty(BLOCK, np.uint64)
    shift, speed, gradient, walls = frame
    row, last = np.uint64(span[0]), np.uint64(span[1])
    pressed, damped, sheared, largest, so_far = 0.0, 0.0, 0.0, 0.0, turned[0]
    xx, xy, xz, yx, yy, yz, zx, zy, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    # the first body stays the same for a few pairs: its sums wait until it changes
    fx, fy, fz, tx, ty, tz, current = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, first[row] if row < last else np.uint32(0)
    while row < last:
        size = np.uint64(0)
        while row < last and size < np.uint64(BLOCK):
            i, j, reach = first[row], partner[row], surface[first[row], REACH]
            if image is not None:
                s = image[row]
                for a in range(3):
                    buf[D + a, size] = position[j, a] + shift[s, a] - position[i, a]
                    buf[N + a, size] = memory[AXIS + a, row]
                if memory[BEFORE, row] == 0.0:
                    free = memory[FREE, row]
                    if free > 0.0 and dot(three(buf, D, size), three(buf, N, size)) - so_far > free:
                        row += ONE
                        continue
                reach += surface[j, REACH]
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
                    buf[LIMIT, size] = min(surface[i, GRACE], surface[j, GRACE])
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
        touching = np.uint64(0)
        for q in range(size):
            at = place[q]
            if image is not None and buf[STATE, q] == OPEN:
                look_closely(buf, q, three(memory, AXIS, at), surface[first[at], SHARPEST] + surface[partner[at], SHARPEST])
                for a in range(3):
                    memory[AXIS + a, at] = buf[N + a, q]
            if buf[STATE, q] == TOUCHING:
                for a in range(3):
                    memory[AXIS + a, at] = buf[N + a, q]
                if touching != q:
                    to_the_front(buf, place, q, touching)
                touching += ONE
                if buf[HAD, q] == 0.0:
                    memory[FREE, at] = 0.0
            else:
                if buf[HAD, q] != 0.0:
                    one, two = ended(memory, slip, damping, at)
                    pressed, damped = pressed + one, damped + two
                memory[FREE, at] = max(0.0, buf[GAP, q] + dot(three(buf, D, q), three(memory, AXIS, at)) - so_far)
        size = touching
        for q in range(size):
            at = place[q]
            for k in range(4):
                buf[WAS + k, q] = memory[ROLLED + k, at]
            buf[PUSHED, q] = memory[PUSH, at]
            shaped.remember(law, buf, OWN, q, shaped.remembered(law, memory, OF_LAW, at))
        pushed(law, share, buf, size)
        for q in range(size):
            if buf[ALONE, q] != 0.0:
                pushed_alone(law, share, buf, q, memory, place[q])
        for q in range(size):
            f = buf[FORCE, q]
            buf[G, q], buf[G + 1, q], buf[G + 2, q] = f * buf[N, q], f * buf[N + 1, q], f * buf[N + 2, q]
        if rates is not None:
            widths(law, share, buf, size)
            for q in range(size):
                i, j = first[place[q]], partner[place[q]]
                for a in range(3):
                    buf[SPIN_1 + a, q] = spin[i, a]
                    if image is not None:
                        buf[V + a, q] = velocity[j, a] - velocity[i, a] + speed[image[place[q]], a]
                        buf[SPIN_2 + a, q] = spin[j, a]
                    else:
                        buf[V + a, q] = (walls[j, 3] if a == int(walls[j, 0]) else 0.0) - velocity[i, a]
            slid(buf, size, gradient, image)
        if damper is not None:
            m = one_mass if image is None else 0.5 * one_mass
            for q in range(size):
                at, f = place[q], buf[FORCE, q]
                if mass is not None:
                    m = mass[first[at]] if image is None else 1.0 / (1.0 / mass[first[at]] + 1.0 / mass[partner[at]])
                n = three(buf, N, q)
                held = max(f + damper_force(damper, buf[WIDTH, q], m, -dot(three(buf, V, q), n)), 0.0) - f
                damped += 0.5 * (held + damping[at]) * (buf[GAP, q] - buf[HAD, q])
                damping[at] = held
                buf[G, q], buf[G + 1, q], buf[G + 2, q] = (f + held) * n[0], (f + held) * n[1], (f + held) * n[2]
        if tangential is not None:
            for q in range(size):
                for a in range(4):
                    buf[SLIP + a, q] = slip[a, place[q]]
            rubbed(tangential, buf, size, dt, image)
            for q in range(size):
                sheared += buf[WORK, q]
                for a in range(4):
                    slip[a, place[q]] = buf[SLIP + a, q]
        twisted(buf, size)
        for q in range(size):
            at = place[q]
            i, j, overlap, f = first[at], partner[at], buf[GAP, q], buf[FORCE, q]
            pressed += 0.5 * (f + buf[PUSHED, q]) * (overlap - buf[HAD, q])
            largest = max(largest, overlap * share * share / buf[MEAN, q])
            memory[BEFORE, at], memory[PUSH, at] = overlap, f
            memory[ROLLED + 3, at] = buf[WAS + 3, q]
            if (buf[HAD, q] == 0.0) | (buf[ALONE, q] != 0.0):
                for k in range(3):
                    memory[ROLLED + k, at] = buf[WAS + k, q]
            shaped.remember(law, memory, OF_LAW, at, shaped.remembered(law, buf, OWN, q))
            if i != current:
                less(force, torque, current, (fx, fy, fz), (tx, ty, tz))
                fx, fy, fz, tx, ty, tz, current = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, i
            gx, gy, gz = three(buf, G, q)
            fx, fy, fz = fx + gx, fy + gy, fz + gz
            tx, ty, tz = tx + buf[T_1, q], ty + buf[T_1 + 1, q], tz + buf[T_1 + 2, q]
            d = three(buf, POINT, q)
            if image is not None:
                d = three(buf, D, q)
                for a in range(3):
                    force[j, a] += buf[G + a, q]
                    torque[j, a] += buf[T_2 + a, q]
            else:
                for a in range(3):
                    reaction[j, a] += buf[G + a, q]
            xx, xy, xz = xx + d[0] * gx, xy + d[0] * gy, xz + d[0] * gz
            yx, yy, yz = yx + d[1] * gx, yy + d[1] * gy, yz + d[1] * gz
            zx, zy, zz = zx + d[2] * gx, zy + d[2] * gy, zz + d[2] * gz
            if len(network) > 0:
                network[at, 0], network[at, 1], network[at, 2] = gx, gy, gz
    if span[0] < span[1]:
        less(force, torque, current, (fx, fy, fz), (tx, ty, tz))
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


def _ellipsoids_on_threads(  # type: ignore[no-untyped-def]
    law, tangential, damper, share, rates, first, partner, image, memory, slip, damping,
    position, velocity, spin, radius, mass, one_mass, surface, turned, frame, dt,
    force, torque, virial, reaction, network, tally,
):  # fmt: skip
    """`ellipsoid_forces` of all pairs of one kind, a share on each thread."""
    parts, count = len(force), len(first)
    laws = [law]  # a parallel loop takes records of values, but none of records
    for part in numba.prange(parts):
        ellipsoid_forces(
            laws[0], tangential, damper, share, rates, first, partner, image, memory, slip, damping,
            position, velocity, spin, radius, mass, one_mass, surface, turned, frame, dt,
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
            shapes.surface, shapes.turned,
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
            shapes.surface, shapes.turned,
            frame, dt, force, torque, virial, reaction, nothing, tally,
        )  # fmt: skip
