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

#: half angle up to which the series below are exact to round-off
SMALL = 0.1


class Shapes(NamedTuple):
    """Ellipsoids as the kernels see them, beside what `forces.Bodies` has of spheres; its spin is made of these."""

    axes: FloatArray  # m, half axes, shape (n, 3)
    orientation: FloatArray  # unit quaternions, shape (n, 4)
    momentum: FloatArray  # kg m2/s, angular, in the laboratory, shape (n, 3)
    inertia: FloatArray  # kg m2, about the principal axes, shape (n, 3)
    surface: FloatArray  # m2, see contactlaws.ellipsoid_gap; shape (n, 6)
    bounding: FloatArray  # m, the largest half axis, shape (n,)
    sharpest: FloatArray  # m, the least radius of curvature, shape (n,)


def inertia_of(mass: FloatArray, axes: FloatArray) -> FloatArray:
    """kg m2 about the principal axes of solid ellipsoids: m (b^2 + c^2)/5 and so on, shape (n, 3)."""
    squares = axes**2
    return 0.2 * mass[:, None] * (squares.sum(axis=1, keepdims=True) - squares)


def shapes_of(axes: FloatArray, orientation: FloatArray, mass: FloatArray, spin: FloatArray) -> Shapes:
    """Ellipsoids that turn with `spin` (1/s, in the laboratory), shape (n, 3)."""
    inertia, turns = inertia_of(mass, axes), matrices(orientation)
    momentum = np.einsum("nab,nb,ncb,nc->na", turns, inertia, turns, spin)
    surface = np.zeros((len(axes), 6))
    place_surfaces(axes, orientation, surface)
    return Shapes(axes, orientation, momentum, inertia, surface, axes.max(axis=1), axes.min(axis=1) ** 2 / axes.max(axis=1))


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
    return float(0.5 * np.sum(own**2 / shapes.inertia))


@inlined
def half_turn(angle):  # type: ignore[no-untyped-def]
    """Cosine and sine of half an angle."""
    x = 0.5 * angle
    if abs(x) > SMALL:
        return math.cos(x), math.sin(x)
    y = x * x
    c = 1.0 + y * (-1.0 / 2.0 + y * (1.0 / 24.0 + y * (-1.0 / 720.0 + y * (1.0 / 40320.0 - y / 3628800.0))))
    s = 1.0 + y * (-1.0 / 6.0 + y * (1.0 / 120.0 + y * (-1.0 / 5040.0 + y * (1.0 / 362880.0 - y / 39916800.0))))
    return c, s * x


@inlined
def freely(w, x, y, z, a, b, c, ia, ib, ic, dt):  # type: ignore[no-untyped-def]
    """Turn a free body for `dt` (s): quaternion, momentum in its own frame (a, b, c), inverse moments of inertia."""
    co, si = half_turn(0.5 * dt * a * ia)
    w, x, y, z = w * co - x * si, x * co + w * si, y * co + z * si, z * co - y * si
    cd, sd = co * co - si * si, 2.0 * co * si
    b, c = b * cd + c * sd, c * cd - b * sd
    co, si = half_turn(0.5 * dt * b * ib)
    w, x, y, z = w * co - y * si, x * co - z * si, y * co + w * si, z * co + x * si
    cd, sd = co * co - si * si, 2.0 * co * si
    c, a = c * cd + a * sd, a * cd - c * sd
    co, si = half_turn(dt * c * ic)
    w, x, y, z = w * co - z * si, x * co + y * si, y * co - x * si, z * co + w * si
    cd, sd = co * co - si * si, 2.0 * co * si
    a, b = a * cd + b * sd, b * cd - a * sd
    co, si = half_turn(0.5 * dt * b * ib)
    w, x, y, z = w * co - y * si, x * co - z * si, y * co + w * si, z * co + x * si
    cd, sd = co * co - si * si, 2.0 * co * si
    c, a = c * cd + a * sd, a * cd - c * sd
    co, si = half_turn(0.5 * dt * a * ia)
    w, x, y, z = w * co - x * si, x * co + w * si, y * co + z * si, z * co - y * si
    i = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    return w * i, x * i, y * i, z * i


@kernel
def turn(orientation, momentum, inertia, axes, surface, spin, torque, before, fade, after, dt, begin, end):  # type: ignore[no-untyped-def]
    """Kick the bodies `begin` to `end` for `before` (s), let their spin fade by a factor, kick for `after`, turn for `dt`.

    `torque` holds one sum (N m) per thread. Writes spins and surfaces that belong to the new state; returns what the drag took, J.
    """
    taken = 0.0
    for i in range(begin, end):
        w, x, y, z = orientation[i, 0], orientation[i, 1], orientation[i, 2], orientation[i, 3]
        ux, uy, uz = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)
        vx, vy, vz = 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)
        wx, wy, wz = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)
        tx, ty, tz = torque[0, i, 0], torque[0, i, 1], torque[0, i, 2]
        for t in range(1, len(torque)):
            tx, ty, tz = tx + torque[t, i, 0], ty + torque[t, i, 1], tz + torque[t, i, 2]
        ia, ib, ic = 1.0 / inertia[i, 0], 1.0 / inertia[i, 1], 1.0 / inertia[i, 2]
        lx, ly, lz = momentum[i, 0] + before * tx, momentum[i, 1] + before * ty, momentum[i, 2] + before * tz
        if fade != 1.0:
            a, b, c = lx * ux + ly * uy + lz * uz, lx * vx + ly * vy + lz * vz, lx * wx + ly * wy + lz * wz
            taken += 0.5 * (a * a * ia + b * b * ib + c * c * ic) * (1.0 - fade * fade)
        lx, ly, lz = lx * fade + after * tx, ly * fade + after * ty, lz * fade + after * tz
        momentum[i, 0], momentum[i, 1], momentum[i, 2] = lx, ly, lz
        a, b, c = lx * ux + ly * uy + lz * uz, lx * vx + ly * vy + lz * vz, lx * wx + ly * wy + lz * wz
        if dt > 0.0:
            w, x, y, z = freely(w, x, y, z, a, b, c, ia, ib, ic, dt)
            orientation[i, 0], orientation[i, 1], orientation[i, 2], orientation[i, 3] = w, x, y, z
            ux, uy, uz = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)
            vx, vy, vz = 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)
            wx, wy, wz = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)
            s = surface_tensor((axes[i, 0], axes[i, 1], axes[i, 2]), (w, x, y, z))
            for k in range(6):
                surface[i, k] = s[k]
            a, b, c = lx * ux + ly * uy + lz * uz, lx * vx + ly * vy + lz * vz, lx * wx + ly * wy + lz * wz
        a, b, c = a * ia, b * ib, c * ic
        spin[i, 0], spin[i, 1], spin[i, 2] = a * ux + b * vx + c * wx, a * uy + b * vy + c * wy, a * uz + b * vz + c * wz
    return taken


@kernel
def place_surfaces(axes, orientation, surface):  # type: ignore[no-untyped-def]
    """Write the surface tensor (m2) of every body into `surface`, shape (n, 6)."""
    for i in range(len(axes)):
        s = surface_tensor(
            (axes[i, 0], axes[i, 1], axes[i, 2]), (orientation[i, 0], orientation[i, 1], orientation[i, 2], orientation[i, 3])
        )
        for k in range(6):
            surface[i, k] = s[k]
