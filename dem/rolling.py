"""The way of a sphere that is dropped on a bed: exact geometry, no dynamics.

It always goes down as steeply as those it touches let it: without contact it falls, on one sphere it rolls along a meridian, on two along
the circle about the line through their centres. On that arc it goes on until it meets another sphere or the floor, or until one that it
rolls on no longer holds it. It rests where no way leads down; with three contacts that is where the vertical through its centre meets the
triangle of theirs. The largest radius is 1.
"""

from __future__ import annotations

import math

import numpy as np

from contactlaws.compiled import kernel
from dem.packing_cells import put

#: spheres nearer than this touch; arcs are exact to round-off, which a grazing contact does not raise
TOUCH = 1e-9
#: a direction leads into a sphere, or a sphere carries, if its cosine is more than this
GRAZING = 1e-10
#: down, in a bed tilted by 1e-6 to one of three sides
TILTS = ((1e-6, 0.3e-6, -1.0), (-0.76e-6, 0.71e-6, -1.0), (-0.24e-6, -1.01e-6, -1.0))
#: arcs after which a sphere's way is given up and it is dropped elsewhere; a way of 10 is usual
MOST_ARCS = 1000


@kernel
def _dot(a, b):  # type: ignore[no-untyped-def]
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def _plus(a, factor, b):  # type: ignore[no-untyped-def]
    """a + factor b; vectors are tuples, which compile in a fraction of the time of arrays."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


@kernel
def about(x, y, low, high, r, extra, position, radius, cells, found):  # type: ignore[no-untyped-def]
    """Write into `found` (x, y, z, radius) all images of spheres that one of radius r can touch while its centre is within `extra` of the
    vertical at x, y and between these heights. Their number is returned; no image is left out however narrow the box."""
    count, lengths = 0, cells.lengths
    for size in range(len(cells.largest)):
        reach = extra + (1.0 + TOUCH) * (r + cells.largest[size])
        nx, ny = cells.shape[size, 0], cells.shape[size, 1]
        for a in range(math.floor((x - reach) / lengths[0] * nx), math.floor((x + reach) / lengths[0] * nx) + 1):
            for b in range(math.floor((y - reach) / lengths[1] * ny), math.floor((y + reach) / lengths[1] * ny) + 1):
                k = cells.first[cells.start[size] + (a % nx) * ny + b % ny]
                while k >= 0:
                    cx, cy, cz = position[k, 0] + a // nx * lengths[0], position[k, 1] + b // ny * lengths[1], position[k, 2]
                    d = (1.0 + TOUCH) * (r + radius[k])
                    if low - d <= cz <= high + d and (cx - x) ** 2 + (cy - y) ** 2 <= (extra + d) ** 2:
                        found[count, 0], found[count, 1], found[count, 2], found[count, 3] = cx, cy, cz, radius[k]
                        count += 1
                    k = cells.following[k]
    return count


@kernel
def _leads_into(v, normal, count):  # type: ignore[no-untyped-def]
    """Whether the direction leads into one of the spheres touched."""
    for k in range(count):  # noqa: SIM110 - numba has no any() of a generator
        if _dot(v, normal[k]) < -GRAZING:
            return True
    return False


@kernel
def _way_down(down, normal, count):  # type: ignore[no-untyped-def]
    """The steepest way along `down` that the spheres touched leave free, and which two of them it rolls on (-1: none).

    It is gravity projected on the cone of free directions, so the spheres that it rolls on push and do not pull. Zero: the sphere rests.
    """
    if not _leads_into(down, normal, count):
        return -1, -1, down
    for i in range(count):
        push = -_dot(down, normal[i])
        v = _plus(down, push, normal[i])
        steepness = math.sqrt(_dot(v, v))
        if push > 0.0 and steepness > GRAZING:
            v = _plus((0.0, 0.0, 0.0), 1.0 / steepness, v)
            if not _leads_into(v, normal, count):
                return i, -1, v
    for i in range(count):
        for j in range(i):
            n, m = normal[i], normal[j]
            v = (n[1] * m[2] - n[2] * m[1], n[2] * m[0] - n[0] * m[2], n[0] * m[1] - n[1] * m[0])
            sine, cosine, slope, first, second = math.sqrt(_dot(v, v)), _dot(n, m), _dot(v, down), -_dot(n, down), -_dot(m, down)
            if sine < GRAZING or first < cosine * second or second < cosine * first:
                continue  # one of them would have to pull
            v = _plus((0.0, 0.0, 0.0), -1.0 / sine if slope < 0.0 else 1.0 / sine, v)
            if abs(slope) > GRAZING * sine and not _leads_into(v, normal, count):
                return i, j, v
    return -1, -1, (0.0, 0.0, 0.0)


@kernel
def _fall(p, r, found, number, touched, count):  # type: ignore[no-untyped-def]
    """The height at which a sphere that falls from p meets the floor or the first sphere that it does not touch already."""
    height = r
    for k in range(number):
        square = (r + found[k, 3]) ** 2 - (found[k, 0] - p[0]) ** 2 - (found[k, 1] - p[1]) ** 2
        if square > 0.0 and found[k, 2] < p[2] and not _among(found[k], touched, count):
            height = max(height, found[k, 2] + math.sqrt(square))
    return min(height, p[2])


@kernel
def _among(sphere, touched, count):  # type: ignore[no-untyped-def]
    for k in range(count):  # noqa: SIM110 - as above
        if touched[k, 0] == sphere[0] and touched[k, 1] == sphere[1] and touched[k, 2] == sphere[2]:
            return True
    return False


@kernel
def _arc(r, a, b):  # type: ignore[no-untyped-def]
    """Centre and radius of the circle on which a sphere rolls over a and, unless they are one, b; and the height at which it leaves one of
    them: where it would have to be pulled to stay in touch with both."""
    da, db = r + a[3], r + b[3]
    axis = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
    square = _dot(axis, axis)
    if square == 0.0:
        return (a[0], a[1], a[2]), da, a[2]
    share = 0.5 * (da * da - db * db + square) / square
    cosine = 0.5 * (da * da + db * db - square) / (da * db)
    leave = -np.inf
    for slope, height in (
        (1.0 / da - cosine / db, a[2] / da - cosine * b[2] / db),
        (1.0 / db - cosine / da, b[2] / db - cosine * a[2] / da),
    ):
        if slope > 0.0:
            leave = max(leave, height / slope)
    return _plus(a, share, axis), math.sqrt(max(da * da - share * share * square, 0.0)), leave


@kernel
def _end_of_arc(centre, size, f, h, lowest):  # type: ignore[no-untyped-def]
    """The angle, from f towards h, at which a circle has sunk to the height `lowest`, or its lowest point."""
    top, amplitude = math.atan2(h[2], f[2]), size * math.hypot(f[2], h[2])
    return max(top + math.acos(min(max((lowest - centre[2]) / amplitude, -1.0), 1.0)), 0.0)


@kernel
def _first_met(centre, size, f, h, end, r, found, number, touched, count):  # type: ignore[no-untyped-def]
    """The angle, at most `end`, at which a sphere on that circle meets the first of those that it does not roll on."""
    for k in range(number):
        q = _plus(found[k], -1.0, centre)
        along, across = _dot(q, f), _dot(q, h)
        reach = 2.0 * size * math.hypot(along, across)
        excess = size * size + _dot(q, q) - (r + found[k, 3]) ** 2
        if abs(excess) >= reach:
            continue  # nowhere, or everywhere: one of those that it rolls on
        t = math.atan2(across, along) - math.acos(excess / reach)
        t += 2.0 * math.pi if t <= -math.pi else 0.0
        near_start = abs(t) < 1e-6 or t > 2.0 * math.pi - 1e-6
        if _among(found[k], touched, count):
            t = np.inf if near_start or t < 0.0 else t  # it is just leaving that one
        elif t < -1e-6:
            t = np.inf
        end = min(end, max(t, 0.0))
    return end


@kernel
def _touched(p, r, found, number, touched, normal):  # type: ignore[no-untyped-def]
    """Write down which of the spheres found touch one at p, and the directions from them to it; their number is returned."""
    count = 0
    for k in range(number):
        q = _plus(p, -1.0, found[k])
        distance = math.sqrt(_dot(q, q))
        if distance < (1.0 + TOUCH) * (r + found[k, 3]) and count < len(touched):
            for axis in range(3):
                touched[count, axis], normal[count, axis] = found[k, axis], q[axis] / distance
            touched[count, 3] = found[k, 3]
            count += 1
    return count


@kernel
def _roll(p, r, position, radius, cells, found, touched, normal):  # type: ignore[no-untyped-def]
    """Whether a sphere let go at p comes to rest within `MOST_ARCS`, and where. At rest it must stay in each of `TILTS`:
    what is balanced on one or two is not."""
    for _ in range(MOST_ARCS):
        if p[2] <= r * (1.0 + TOUCH):
            return True, (p[0], p[1], r)
        number = about(p[0], p[1], p[2], p[2], r, 0.0, position, radius, cells, found)
        count = _touched(p, r, found, number, touched, normal)
        i, j, v = _way_down((0.0, 0.0, -1.0), normal, count)
        for tilt in TILTS:
            if i < 0 and v[2] == 0.0:
                i, j, v = _way_down(tilt, normal, count)
        if i < 0 and v[2] == 0.0:
            return True, p
        if i < 0:
            number = about(p[0], p[1], -1.0, p[2], r, 0.0, position, radius, cells, found)
            p = (p[0], p[1], _fall(p, r, found, number, touched, count))
            continue
        centre, size, lowest = _arc(r, touched[i], touched[i if j < 0 else j])
        f = _plus(p, -1.0, centre)
        f = _plus(f, -_dot(f, v), v)
        f = _plus((0.0, 0.0, 0.0), 1.0 / math.sqrt(_dot(f, f)), f)
        end = _end_of_arc(centre, size, f, v, max(lowest, r))
        number = about(centre[0], centre[1], centre[2] - size, p[2], r, size, position, radius, cells, found)
        end = _first_met(centre, size, f, v, end, r, found, number, touched, count)
        p = _plus(_plus(centre, size * math.cos(end), f), size * math.sin(end), v)
    return False, p


@kernel
def pile_up(start, radius, position, cells):  # type: ignore[no-untyped-def]
    """Drop spheres at the places `start`, as many as `position` holds; returns the number of drops, or 0 if `start` was too short."""
    found, touched, normal = np.empty((16 * len(radius) + 64, 4)), np.empty((12, 4)), np.empty((12, 3))
    top, drops = 0.0, 0
    for i in range(len(radius)):
        rests, p = False, (0.0, 0.0, 0.0)
        while not rests:
            if drops == len(start):
                return 0
            rests, p = _roll(
                (start[drops, 0], start[drops, 1], top + 2.0 * radius[i]), radius[i], position, radius, cells, found, touched, normal
            )
            drops += 1
        top = max(top, p[2] + radius[i])
        for axis in range(2):
            position[i, axis] = p[axis] - math.floor(p[axis] / cells.lengths[axis]) * cells.lengths[axis]
        position[i, 2] = p[2]
        put(i, position, cells)
    return drops
