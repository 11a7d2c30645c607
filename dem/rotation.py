"""Rigid bodies that turn: unit quaternions, and the free top by rotations about its own axes.

The state is the angular momentum L in the laboratory, which nothing but a torque changes: it is kept to the last bit while a body turns
freely. In the body's frame, a turn about one principal axis at the rate that belongs to its share of the energy is exact; five of them,
half, half, whole, half, half, make a step of second order that is symplectic, so that the energy does not drift (Dullweber, Leimkuhler &
McLachlan 1997). Angles are exact however large. Quaternions are (w, x, y, z), from the body to the laboratory.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.compiled import inlined, kernel
from contactlaws.ellipsoid_gap import surface_tensor

FloatArray = npt.NDArray[np.float64]

#: turn of a common normal in a step, times a/c, up to which one step of Newton's method is enough. What is left of the turn is some a/c
#: times its square: with this the direction of a force is right to 1e-6, as the step goes to zero with its square
CLOSE = 1e-3
#: half angle up to which the series below are exact to round-off
SMALL = 0.02


class Shapes(NamedTuple):
    """Ellipsoids as the kernels see them, beside what `forces.Bodies` has of spheres; its spin is made of these."""

    axes: FloatArray  # m, half axes, shape (n, 3)
    orientation: FloatArray  # unit quaternions, shape (n, 4)
    momentum: FloatArray  # kg m2/s, angular, in the laboratory, shape (n, 3)
    ease: FloatArray  # 1/(kg m2), inverse moments of inertia about the principal axes, shape (n, 3)
    surface: FloatArray  # S in m2, see contactlaws.ellipsoid_gap; m, the largest half axis a; m, the least radius of curvature c^2/a;
    # (CLOSE c/a)^2; shape (n, 6 + 3): what a pair asks of its bodies, in one place
    turned: FloatArray  # m, shape (1,): bound of how far any two surfaces have come nearer by turning, since the list of pairs was made


def inertia_of(mass: FloatArray, axes: FloatArray) -> FloatArray:
    """kg m2 about the principal axes of solid ellipsoids: m (b^2 + c^2)/5 and so on, shape (n, 3)."""
    squares = axes**2
    return 0.2 * mass[:, None] * (squares.sum(axis=1, keepdims=True) - squares)


def shapes_of(axes: FloatArray, orientation: FloatArray, mass: FloatArray, spin: FloatArray) -> Shapes:
    """Ellipsoids that turn with `spin` (1/s, in the laboratory), shape (n, 3)."""
    inertia, turns = inertia_of(mass, axes), matrices(orientation)
    momentum = np.einsum("nab,nb,ncb,nc->na", turns, inertia, turns, spin)
    long, short = axes.max(axis=1), axes.min(axis=1)
    surface = np.column_stack([np.zeros((len(axes), 6)), long, short * short / long, (CLOSE * short / long) ** 2])
    place_surfaces(axes, orientation, surface)
    return Shapes(axes, orientation, momentum, 1.0 / inertia, surface, np.zeros(1))


def matrices(orientation: FloatArray) -> FloatArray:
    """Rotation matrices of unit quaternions, columns the bodies' axes in the laboratory, shape (n, 3, 3).

    >>> matrices(np.array([[np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]])).round(15)[0, :, 0] + 0.0  # a quarter turn about z
    array([0., 1., 0.])
    """
    w, x, y, z = orientation.T
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def rotational_energy(shapes: Shapes) -> float:
    """Kinetic energy of the turning, J: what is exact of the state, not half a step late."""
    own = np.einsum("nab,na->nb", matrices(shapes.orientation), shapes.momentum)
    return float(0.5 * np.sum(own**2 * shapes.ease))


@inlined
def small_turn(angle):  # type: ignore[no-untyped-def]
    """Cosine and sine of half an angle below `SMALL`."""
    x = 0.5 * angle
    y = x * x
    return 1.0 + y * (-1.0 / 2.0 + y * (1.0 / 24.0 - y * (1.0 / 720.0))), x * (
        1.0 + y * (-1.0 / 6.0 + y * (1.0 / 120.0 - y * (1.0 / 5040.0)))
    )


@inlined
def any_turn(angle):  # type: ignore[no-untyped-def]
    """Cosine and sine of half an angle."""
    return math.cos(0.5 * angle), math.sin(0.5 * angle)


def _splitting(half_turn):  # type: ignore[no-untyped-def]
    """The free top with small angles or any."""

    @inlined
    def about(w, x, y, z, b, c, angle):  # type: ignore[no-untyped-def]
        """Turn by an angle about the body's axis x: quaternion, and the momenta b and c along y and z. In turn, so about any axis."""
        co, si = half_turn(angle)
        cd, sd = co * co - si * si, 2.0 * co * si
        return w * co - x * si, x * co + w * si, y * co + z * si, z * co - y * si, b * cd + c * sd, c * cd - b * sd

    @inlined
    def freely(w, x, y, z, a, b, c, ia, ib, ic, dt):  # type: ignore[no-untyped-def]
        """Turn a free body for `dt` (s): quaternion, momentum in its own frame (a, b, c), inverse moments of inertia."""
        w, x, y, z, b, c = about(w, x, y, z, b, c, 0.5 * dt * a * ia)
        w, y, z, x, c, a = about(w, y, z, x, c, a, 0.5 * dt * b * ib)
        w, z, x, y, a, b = about(w, z, x, y, a, b, dt * c * ic)
        w, y, z, x, c, a = about(w, y, z, x, c, a, 0.5 * dt * b * ib)
        w, x, y, z, _, _ = about(w, x, y, z, b, c, 0.5 * dt * a * ia)
        i = 1.5 - 0.5 * (w * w + x * x + y * y + z * z)  # 1/sqrt so near to 1
        return w * i, x * i, y * i, z * i

    return freely


freely_a_little = _splitting(small_turn)
freely = _splitting(any_turn)


@inlined
def axes_of(w, x, y, z):  # type: ignore[no-untyped-def]
    """The body's axes in the laboratory."""
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
        (2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
        (2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


#: rows of a block of bodies: quaternion; torque; momentum in the laboratory and in the body; inverse moments; half axes; what comes of it
Q, T, L, OWN, EASE, AXES, SURFACE, SPIN, FAST, TAKEN, SWEPT = 0, 4, 7, 10, 13, 16, 19, 25, 28, 29, 30
ROWS, BLOCK = 31, 64


@inlined
def kick(buf, size, before, fade, after):  # type: ignore[no-untyped-def]
    """Momenta after both kicks, in the laboratory and in the body; what the drag took."""
    for q in range(size):
        u, v, w = axes_of(buf[Q, q], buf[Q + 1, q], buf[Q + 2, q], buf[Q + 3, q])
        ia, ib, ic = buf[EASE, q], buf[EASE + 1, q], buf[EASE + 2, q]
        lx, ly, lz = buf[L, q] + before * buf[T, q], buf[L + 1, q] + before * buf[T + 1, q], buf[L + 2, q] + before * buf[T + 2, q]
        a, b, c = lx * u[0] + ly * u[1] + lz * u[2], lx * v[0] + ly * v[1] + lz * v[2], lx * w[0] + ly * w[1] + lz * w[2]
        buf[TAKEN, q] = 0.5 * (a * a * ia + b * b * ib + c * c * ic) * (1.0 - fade * fade)
        lx, ly, lz = lx * fade + after * buf[T, q], ly * fade + after * buf[T + 1, q], lz * fade + after * buf[T + 2, q]
        buf[L, q], buf[L + 1, q], buf[L + 2, q] = lx, ly, lz
        a, b, c = lx * u[0] + ly * u[1] + lz * u[2], lx * v[0] + ly * v[1] + lz * v[2], lx * w[0] + ly * w[1] + lz * w[2]
        buf[OWN, q], buf[OWN + 1, q], buf[OWN + 2, q] = a, b, c
        most = max(ia, max(ib, ic))
        buf[FAST, q] = (a * a + b * b + c * c) * most * most  # no part of the spin is larger, squared
        # a tangent plane moves no faster than its point of contact is off the line from the centre along the normal: a - c at most
        off = max(buf[AXES, q], max(buf[AXES + 1, q], buf[AXES + 2, q])) - min(buf[AXES, q], min(buf[AXES + 1, q], buf[AXES + 2, q]))
        buf[SWEPT, q] = buf[FAST, q] * off * off


@inlined
def drift(buf, size, dt):  # type: ignore[no-untyped-def]
    """Quaternions after `dt` (s) of small turns."""
    for q in range(size):
        turned = freely_a_little(
            buf[Q, q], buf[Q + 1, q], buf[Q + 2, q], buf[Q + 3, q], buf[OWN, q], buf[OWN + 1, q], buf[OWN + 2, q],
            buf[EASE, q], buf[EASE + 1, q], buf[EASE + 2, q], dt,
        )  # fmt: skip
        buf[Q, q], buf[Q + 1, q], buf[Q + 2, q], buf[Q + 3, q] = turned


@inlined
def follow_turns(buf, size):  # type: ignore[no-untyped-def]
    """Spins and surfaces that belong to quaternions and momenta."""
    for q in range(size):
        u, v, w = axes_of(buf[Q, q], buf[Q + 1, q], buf[Q + 2, q], buf[Q + 3, q])
        lx, ly, lz = buf[L, q], buf[L + 1, q], buf[L + 2, q]
        a = (lx * u[0] + ly * u[1] + lz * u[2]) * buf[EASE, q]
        b = (lx * v[0] + ly * v[1] + lz * v[2]) * buf[EASE + 1, q]
        c = (lx * w[0] + ly * w[1] + lz * w[2]) * buf[EASE + 2, q]
        buf[SPIN, q], buf[SPIN + 1, q] = a * u[0] + b * v[0] + c * w[0], a * u[1] + b * v[1] + c * w[1]
        buf[SPIN + 2, q] = a * u[2] + b * v[2] + c * w[2]
        a, b, c = buf[AXES, q] * buf[AXES, q], buf[AXES + 1, q] * buf[AXES + 1, q], buf[AXES + 2, q] * buf[AXES + 2, q]
        buf[SURFACE, q] = a * u[0] * u[0] + b * v[0] * v[0] + c * w[0] * w[0]
        buf[SURFACE + 1, q] = a * u[0] * u[1] + b * v[0] * v[1] + c * w[0] * w[1]
        buf[SURFACE + 2, q] = a * u[0] * u[2] + b * v[0] * v[2] + c * w[0] * w[2]
        buf[SURFACE + 3, q] = a * u[1] * u[1] + b * v[1] * v[1] + c * w[1] * w[1]
        buf[SURFACE + 4, q] = a * u[1] * u[2] + b * v[1] * v[2] + c * w[1] * w[2]
        buf[SURFACE + 5, q] = a * u[2] * u[2] + b * v[2] * v[2] + c * w[2] * w[2]


@kernel
def turn(orientation, momentum, ease, axes, surface, spin, torque, before, fade, after, dt, begin, end):  # type: ignore[no-untyped-def]
    """Kick the bodies `begin` to `end` for `before` (s), let their spin fade by a factor, kick for `after`, turn for `dt`.

    `torque` holds one sum (N m) per thread. Writes spins and surfaces that belong to the new state; returns what the drag took, J, and the
    largest speed of any tangent plane, squared, at most. Bodies are taken in blocks, and each pass over a block is without a branch, so
    that the compiler makes it several bodies wide.
    """
    buf, taken, swept = np.empty((ROWS, BLOCK)), 0.0, 0.0
    start, last = np.uint64(begin), np.uint64(end)
    while start < last:
        size = min(np.uint64(BLOCK), last - start)
        for q in range(size):
            i = start + q
            for k in range(4):
                buf[Q + k, q] = orientation[i, k]
            for k in range(3):
                t = torque[0, i, k]
                for part in range(1, len(torque)):
                    t += torque[part, i, k]
                buf[T + k, q], buf[L + k, q], buf[EASE + k, q], buf[AXES + k, q] = t, momentum[i, k], ease[i, k], axes[i, k]
        kick(buf, size, before, fade, after)
        if dt > 0.0:
            most = 0.0
            for q in range(size):
                most = max(most, buf[FAST, q])
            if 0.25 * dt * dt * most < SMALL * SMALL:
                drift(buf, size, dt)
            else:
                for q in range(size):
                    turned = freely(
                        buf[Q, q], buf[Q + 1, q], buf[Q + 2, q], buf[Q + 3, q], buf[OWN, q], buf[OWN + 1, q], buf[OWN + 2, q],
                        buf[EASE, q], buf[EASE + 1, q], buf[EASE + 2, q], dt,
                    )  # fmt: skip
                    buf[Q, q], buf[Q + 1, q], buf[Q + 2, q], buf[Q + 3, q] = turned
        follow_turns(buf, size)
        for q in range(size):
            i = start + q
            taken += buf[TAKEN, q]
            swept = max(swept, buf[SWEPT, q])
            for k in range(4):
                orientation[i, k] = buf[Q + k, q]
            for k in range(3):
                momentum[i, k], spin[i, k] = buf[L + k, q], buf[SPIN + k, q]
            for k in range(6):
                surface[i, k] = buf[SURFACE + k, q]
        start += size
    return taken, swept


@kernel
def place_surfaces(axes, orientation, surface):  # type: ignore[no-untyped-def]
    """Write the surface tensor (m2) of every body into the first columns of `surface`, shape (n, 6 or more)."""
    for i in range(len(axes)):
        s = surface_tensor(
            (axes[i, 0], axes[i, 1], axes[i, 2]), (orientation[i, 0], orientation[i, 1], orientation[i, 2], orientation[i, 3])
        )
        for k in range(6):
            surface[i, k] = s[k]
