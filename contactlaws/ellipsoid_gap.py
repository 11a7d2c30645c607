"""The gap between two ellipsoids: their common normal, how deep they overlap, and the curvatures where they meet.

An ellipsoid with the half axes a, b, c in the frame Q is the tensor S = Q diag(a^2, b^2, c^2) Q^T. Its support function is h(n) =
sqrt(n S n), the point with the normal n is S n/h, and there the tensor of the radii of curvature is W = (S - S n n S/h^2)/h, across n. Of
two, with d from the first centre to the second,

    g(n) = h_1(n) + h_2(n) - d n

is how far the planes across n that touch them from outside overlap. One n with g(n) < 0 proves that they are apart: a pair that was apart
costs one evaluation. The least g is the overlap, and there the normals of both are n and -n. In the plane across n the gradient of g is
that of S_1 n/h_1 + S_2 n/h_2 - d, and its Hessian W_1 + W_2 - g, so Newton's method takes a 2 by 2 system; the curvature tensors W^-1 that
the law of the contact asks for come with it. All in tuples, the tensors as xx, xy, xz, yy, yz, zz.

What is found is the overlap for sure (a) if g < 0; (b) if g is at most `sharpest` of both together, the least radius of curvature c^2/a:
by Blaschke's rolling theorem a ball of that radius rolls freely inside the sum of the two bodies, so a stationary point that near is the
least. A contact that began so is followed as it deepens, which keeps its force continuous; beyond, `searched` looks everywhere.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.compiled import inlined, inner, kernel

FloatArray = npt.NDArray[np.float64]

#: iterations of Newton's method, damped; and of the search on a line
MOST, HALVINGS = 100, 40
#: turn in a step below which n is found: the next one would be its square
SETTLED = 1e-9
#: longest turn in a step
LONGEST = 0.5
#: directions that are tried where nothing else is certain, and how many of the best are followed down
DIRECTIONS, BEST = 400, 6
GOLDEN = math.pi * (3.0 - math.sqrt(5.0))
#: overlap over the distance of both tangent planes from their centres, up to which a contact is followed
DEEP = 0.5


@inlined
def dot(a, b):  # type: ignore[no-untyped-def]
    """Of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def times(s, n):  # type: ignore[no-untyped-def]
    """A symmetric tensor times a vector."""
    return (
        s[0] * n[0] + s[1] * n[1] + s[2] * n[2],
        s[1] * n[0] + s[3] * n[1] + s[4] * n[2],
        s[2] * n[0] + s[4] * n[1] + s[5] * n[2],
    )


@inlined
def across(n):  # type: ignore[no-untyped-def]
    """Two unit vectors across `n` and each other, smooth but for one jump (Duff et al. 2017)."""
    sign = math.copysign(1.0, n[2])
    a = -1.0 / (sign + n[2])
    b = n[0] * n[1] * a
    return (1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]), (b, sign + n[1] * n[1] * a, -n[1])


@inlined
def surface_tensor(axes, q):  # type: ignore[no-untyped-def]
    """S in m2 of half axes (m) turned by the unit quaternion q (w, x, y, z)."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    a, b, c = axes[0] * axes[0], axes[1] * axes[1], axes[2] * axes[2]
    ux, uy, uz = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)
    vx, vy, vz = 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)
    wx, wy, wz = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)
    return (
        a * ux * ux + b * vx * vx + c * wx * wx,
        a * ux * uy + b * vx * vy + c * wx * wy,
        a * ux * uz + b * vx * vz + c * wx * wz,
        a * uy * uy + b * vy * vy + c * wy * wy,
        a * uy * uz + b * vy * vz + c * wy * wz,
        a * uz * uz + b * vz * vz + c * wz * wz,
    )


@inlined
def overlap_along(s_1, s_2, d, n):  # type: ignore[no-untyped-def]
    """g(n) in m."""
    return math.sqrt(dot(times(s_1, n), n)) + math.sqrt(dot(times(s_2, n), n)) - dot(d, n)


@inlined
def touched(s_1, s_2, n):  # type: ignore[no-untyped-def]
    """Of both bodies at `n`: h, 1/h, and the points with that normal from the centres."""
    p, q = times(s_1, n), times(s_2, n)
    h_1, h_2 = math.sqrt(dot(p, n)), math.sqrt(dot(q, n))
    once = 1.0 / (h_1 * h_2)  # one division for both
    i, j = once * h_2, once * h_1
    return h_1, h_2, i, j, (p[0] * i, p[1] * i, p[2] * i), (q[0] * j, q[1] * j, q[2] * j)


@inlined
def radii_tensor(s_1, s_2, i, j, p, q):  # type: ignore[no-untyped-def]
    """W_1 + W_2 in m."""
    u, v = (p[0] * i, p[1] * i, p[2] * i), (q[0] * j, q[1] * j, q[2] * j)
    return (
        s_1[0] * i + s_2[0] * j - p[0] * u[0] - q[0] * v[0],
        s_1[1] * i + s_2[1] * j - p[0] * u[1] - q[0] * v[1],
        s_1[2] * i + s_2[2] * j - p[0] * u[2] - q[0] * v[2],
        s_1[3] * i + s_2[3] * j - p[1] * u[1] - q[1] * v[1],
        s_1[4] * i + s_2[4] * j - p[1] * u[2] - q[1] * v[2],
        s_1[5] * i + s_2[5] * j - p[2] * u[2] - q[2] * v[2],
    )


@inlined
def adjugate(m):  # type: ignore[no-untyped-def]
    """Of a symmetric tensor: its inverse times its determinant; and that."""
    xx, xy, xz = m[3] * m[5] - m[4] * m[4], m[2] * m[4] - m[1] * m[5], m[1] * m[4] - m[2] * m[3]
    yy, yz, zz = m[0] * m[5] - m[2] * m[2], m[1] * m[2] - m[0] * m[4], m[0] * m[3] - m[1] * m[1]
    return (xx, xy, xz, yy, yz, zz), m[0] * xx + m[1] * xy + m[2] * xz


@inlined
def downhill(w, g, n, off, length):  # type: ignore[no-untyped-def]
    """Newton's step of the normal against the gradient, times the determinant of its matrix; and that, which is `length` (m) times W - g's.

    The matrix is W - g across n and, so that it has an inverse, any length along n; `off` is S_1 n/h_1 + S_2 n/h_2 - d. No plane is needed.
    """
    k = length + g
    x, y, z = k * n[0], k * n[1], k * n[2]
    tensor, determinant = adjugate(
        (w[0] - g + x * n[0], w[1] + x * n[1], w[2] + x * n[2], w[3] - g + y * n[1], w[4] + y * n[2], w[5] - g + z * n[2])
    )
    return times(tensor, (off[0] - g * n[0], off[1] - g * n[1], off[2] - g * n[2])), determinant


@inlined
def look(s_1, s_2, d, n):  # type: ignore[no-untyped-def]
    """All there is at `n`: g; h_1, h_2, inverses; points from the centres; basis of the plane; gradient in it; xx, xy, yy of W_1 + W_2."""
    h_1, h_2, i, j, p, q = touched(s_1, s_2, n)
    e, f = across(n)
    off = (p[0] + q[0] - d[0], p[1] + q[1] - d[1], p[2] + q[2] - d[2])
    w = radii_tensor(s_1, s_2, i, j, p, q)
    we, wf = times(w, e), times(w, f)
    return h_1 + h_2 - dot(d, n), h_1, h_2, i, j, p, q, e, f, dot(off, e), dot(off, f), dot(we, e), dot(we, f), dot(wf, f)


@inlined
def pair_shape(trace_1, trace_2, mean_1, mean_2, i, j, determinant):  # type: ignore[no-untyped-def]
    """1/(2 sqrt(A B)) in m of the gap and B/A: A and B belong to (W_1^-1 + W_2^-1)/2, without an angle between principal directions.

    The traces are those of h W, i and j 1/h, and the determinant that of W_1 + W_2. det W = (a b c)^2/h^4, and the determinant of the sum
    of the inverses is det(W_1 + W_2)/(det W_1 det W_2).
    """
    root_1, root_2 = mean_1 * mean_1 * mean_1 * i * i, mean_2 * mean_2 * mean_2 * j * j  # of the determinants
    both = root_1 * root_2
    once = 1.0 / (both * math.sqrt(determinant))
    radius, t = both * both * once, 0.5 * (trace_1 * i * root_2 * root_2 + trace_2 * j * root_1 * root_1) * once
    t = max(t, 1.0)  # but for round-off
    root = t + math.sqrt(t * t - 1.0)
    return radius, root * root


@inlined
def trace_across(s, p):  # type: ignore[no-untyped-def]
    """That of h W in m2, p being the point S n/h."""
    return s[0] + s[3] + s[5] - dot(p, p)


@inlined
def wall_shape(s, mean, h, p):  # type: ignore[no-untyped-def]
    """`pair_shape` of one ellipsoid on a flat."""
    i = 1.0 / h
    root = mean * mean * mean * i * i
    t = max(0.5 * trace_across(s, p) * i / root, 1.0)
    root_of_ratio = t + math.sqrt(t * t - 1.0)
    return root, root_of_ratio * root_of_ratio


@inlined
def turned(n, e, f, x, y):  # type: ignore[no-untyped-def]
    """`n` turned towards x e + y f."""
    nx, ny, nz = n[0] + x * e[0] + y * f[0], n[1] + x * e[1] + y * f[1], n[2] + x * e[2] + y * f[2]
    i = 1.0 / math.sqrt(nx * nx + ny * ny + nz * nz)
    return nx * i, ny * i, nz * i


@inner
def settled(s_1, s_2, d, n, whole):  # type: ignore[no-untyped-def]
    """From `n` down to where g is least nearby, by Newton's method held back so that g never grows; n and g in m.

    Not `whole`: no further than to where the two are known to be apart.
    """
    g, h_1, h_2, _, _, _, _, e, f, gx, gy, xx, xy, yy = look(s_1, s_2, d, n)
    smallest = 4e-16 * (h_1 + h_2 + abs(g))
    for _ in range(MOST):
        if g < 0.0 and not whole:
            break
        a, b, c = xx - g, xy, yy - g
        mean, half = 0.5 * (a + c), math.sqrt(0.25 * (a - c) * (a - c) + b * b)
        least = 1e-3 * (mean + half) if mean + half > 0.0 else 1e-3 * (abs(mean) + half)
        shift = max(0.0, least - (mean - half))  # to a Hessian that leads down
        a, c = a + shift, c + shift
        determinant = a * c - b * b
        x, y = (b * gy - c * gx) / determinant, (b * gx - a * gy) / determinant
        length = math.sqrt(x * x + y * y)
        if not length > 0.0:
            break
        if length > LONGEST:
            x, y = LONGEST / length * x, LONGEST / length * y
        share, found, slope = 1.0, False, x * gx + y * gy
        trial, there = n, g
        for _ in range(HALVINGS):
            trial = turned(n, e, f, share * x, share * y)
            there = overlap_along(s_1, s_2, d, trial)
            if there <= g + 1e-4 * share * slope + smallest:
                found = True
                break
            share *= 0.5
        if not found:
            break
        n = trial
        g, h_1, h_2, _, _, _, _, e, f, gx, gy, xx, xy, yy = look(s_1, s_2, d, n)
        if shift == 0.0 and share == 1.0 and length < SETTLED:
            break
    return n, g


@inlined
def solved(s, d):  # type: ignore[no-untyped-def]
    """S^-1 d, of a positive tensor."""
    tensor, determinant = adjugate(s)
    x, y, z = times(tensor, d)
    i = 1.0 / determinant
    return x * i, y * i, z * i


@inlined
def between(s_1, s_2, share):  # type: ignore[no-untyped-def]
    """(1 - share) S_1 + share S_2."""
    k = 1.0 - share
    return (
        k * s_1[0] + share * s_2[0],
        k * s_1[1] + share * s_2[1],
        k * s_1[2] + share * s_2[2],
        k * s_1[3] + share * s_2[3],
        k * s_1[4] + share * s_2[4],
        k * s_1[5] + share * s_2[5],
    )


@inner
def dividing(s_1, s_2, d):  # type: ignore[no-untyped-def]
    """The normal of the plane in which both touch when swollen or shrunk alike: it divides them if any plane does (Perram & Wertheim 1985).

    It belongs to the maximum over x of x (1 - x) d ((1 - x) S_1 + x S_2)^-1 d, which is concave: the derivative is bracketed and halved.
    """
    low, high = 0.0, 1.0
    x = 0.5
    for _ in range(60):
        u = solved(between(s_1, s_2, x), d)
        rest = 1.0 - x
        if rest * rest * dot(times(s_1, u), u) > x * x * dot(times(s_2, u), u):
            low = x
        else:
            high = x
        x = 0.5 * (low + high)
    return unit(solved(between(s_1, s_2, x), d))


@inlined
def unit(v):  # type: ignore[no-untyped-def]
    """A vector brought to the length 1; any direction for one without length."""
    largest = max(abs(v[0]), abs(v[1]), abs(v[2]))
    if not largest > 0.0:
        return 0.0, 0.0, 1.0
    x, y, z = v[0] / largest, v[1] / largest, v[2] / largest
    i = 1.0 / math.sqrt(x * x + y * y + z * z)
    return x * i, y * i, z * i


@inlined
def direction(k, d):  # type: ignore[no-untyped-def]
    """One of `DIRECTIONS`, spread evenly over the half sphere towards `d`: of n and -n the one along d has the smaller g."""
    z = 1.0 - 2.0 * (k + 0.5) / (2.0 * DIRECTIONS)
    r = math.sqrt(1.0 - z * z)
    n = (r * math.cos(GOLDEN * k), r * math.sin(GOLDEN * k), z)
    return n if dot(d, n) >= 0.0 else (-n[0], -n[1], -n[2])


@inner
def searched(s_1, s_2, d):  # type: ignore[no-untyped-def]
    """The least g of all, for deep overlaps: from the best of many directions and from the dividing plane. n and g in m."""
    n, g = settled(s_1, s_2, d, dividing(s_1, s_2, d), True)
    if g <= 0.0:
        return n, g
    values = np.empty(DIRECTIONS)
    for k in range(DIRECTIONS):
        values[k] = overlap_along(s_1, s_2, d, direction(k, d))
    for _ in range(BEST):
        k = int(np.argmin(values))
        start = direction(k, d)
        trial, there = settled(s_1, s_2, d, start, True)
        if there < g:
            n, g = trial, there
        for other in range(DIRECTIONS):  # the next one is to start elsewhere
            if abs(dot(direction(other, d), start)) > 0.95:
                values[other] = np.inf
    return n, g


@kernel
def closest(s_1, s_2, d, n, sharpest, followed, whole):  # type: ignore[no-untyped-def]
    """The common normal n and g in m from the normal of the step before, or (0, 0, 0); see the top of the module for what is certain.

    sharpest: least radius of curvature in m of both, added. followed: whether they touched in the step before. whole: whether the
    distance counts of those that do not touch.
    """
    if not dot(n, n) > 0.5:
        n = unit(solved(between(s_1, s_2, 0.5), d))
    n, g = settled(s_1, s_2, d, n, whole)
    if g <= sharpest:
        return n, g
    if followed:
        found = look(s_1, s_2, d, n)
        if g <= DEEP * (found[1] + found[2]):
            return n, g
    return searched(s_1, s_2, d)


class Meeting(NamedTuple):
    """Of two ellipsoids."""

    overlap: float  # m; negative: their distance
    normal: FloatArray  # from the first to the second, shape (3,)
    point: FloatArray  # m, from the first centre, in the middle between the two surfaces, shape (3,)
    radius: float  # 1/(2 sqrt(A B)) of the gap A x^2 + B y^2 in m
    ratio: float  # B/A, at least 1


@kernel
def _meeting(axes_1, turn_1, axes_2, turn_2, d):  # type: ignore[no-untyped-def]
    s_1, s_2 = surface_tensor(axes_1, turn_1), surface_tensor(axes_2, turn_2)
    sharpest = min(axes_1) ** 2 / max(axes_1) + min(axes_2) ** 2 / max(axes_2)
    n, _ = closest(s_1, s_2, d, (0.0, 0.0, 0.0), sharpest, False, True)
    g, _, _, i, j, p, q, _, _, _, _, xx, xy, yy = look(s_1, s_2, d, n)
    mean_1, mean_2 = np.cbrt(axes_1[0] * axes_1[1] * axes_1[2]), np.cbrt(axes_2[0] * axes_2[1] * axes_2[2])
    radius, ratio = pair_shape(trace_across(s_1, p), trace_across(s_2, q), mean_1, mean_2, i, j, xx * yy - xy * xy)
    return g, n, (p[0] - 0.5 * g * n[0], p[1] - 0.5 * g * n[1], p[2] - 0.5 * g * n[2]), radius, ratio


def meeting(axes_1: npt.ArrayLike, turn_1: npt.ArrayLike, axes_2: npt.ArrayLike, turn_2: npt.ArrayLike, branch: npt.ArrayLike) -> Meeting:
    """Where two ellipsoids meet: half axes in m, unit quaternions (w, x, y, z), and `branch` (m) from the first centre to the second.

    >>> round(meeting((1.0, 1.0, 2.0), (1.0, 0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 2.9)).overlap, 12)
    0.1
    """
    given = (tuple(float(value) for value in np.asarray(row, dtype=float)) for row in (axes_1, turn_1, axes_2, turn_2, branch))
    overlap, normal, point, radius, ratio = _meeting(*given)
    return Meeting(float(overlap), np.array(normal), np.array(point), float(radius), float(ratio))
