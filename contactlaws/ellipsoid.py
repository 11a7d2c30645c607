"""Curvatures of an ellipsoid at any point of its surface, and what two such surfaces make of the gap between them.

Everything is in the tangent plane, from the level function x^2/a^2 + y^2/b^2 + z^2/c^2 - 1: the curvature tensor is its Hessian projected
across the normal, over the length of its gradient. No chart of the surface is needed, so no point is special: neither those on the axes nor
umbilics (Becker & Kamlah 2021, appendix A, uses a chart and is singular there).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.errors import Problem, require

FloatArray = npt.NDArray[np.float64]


class Curvature(NamedTuple):
    """Of a surface at a point; principal directions at an umbilic are any two across each other."""

    normal: FloatArray  # outwards, shape (3,)
    tensor: FloatArray  # 1/m, symmetric, shape (3, 3); positive where convex, zero along the normal
    principal: tuple[float, float]  # 1/m, the smaller first
    directions: FloatArray  # their unit vectors as rows, shape (2, 3)


class Gap(NamedTuple):
    """Between two surfaces that touch: A x^2 + B y^2 over the common tangent plane."""

    smaller: float  # A in 1/m
    larger: float  # B in 1/m
    directions: FloatArray  # unit vectors of x and y as rows, shape (2, 3)

    @property
    def effective_radius(self) -> float:
        """1/(2 sqrt(A B)) in m."""
        return 0.5 / math.sqrt(self.smaller * self.larger)


def tangent_basis(normal: FloatArray) -> FloatArray:
    """Two unit vectors across a unit vector and across each other, as rows; without a direction at which it fails (Duff et al. 2017)."""
    x, y, z = normal.tolist()
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return np.array([[1.0 + sign * x * x * a, sign * b, -sign * x], [b, sign + y * y * a, -y]])


def _principal(tensor: FloatArray, normal: FloatArray) -> tuple[tuple[float, float], FloatArray]:
    """Eigenvalues, the smaller first, and directions of a symmetric tensor in the plane across `normal`."""
    basis = tangent_basis(normal)
    (xx, xy), (_, yy) = (basis @ tensor @ basis.T).tolist()
    mean, half, angle = 0.5 * (xx + yy), math.hypot(0.5 * (xx - yy), xy), 0.5 * math.atan2(2.0 * xy, xx - yy)
    along = math.cos(angle) * basis[0] + math.sin(angle) * basis[1]
    return (mean - half, mean + half), np.stack([np.cross(along, normal), along])


def curvature(axes: tuple[float, float, float], point: npt.ArrayLike) -> Curvature:
    """At `point` (m) on the ellipsoid with these half axes (m); a point off the surface is taken along its ray from the centre.

    Raises `InputError` for axes that are not positive, and at the centre.

    >>> curvature((1.0, 2.0, 4.0), (1.0, 0.0, 0.0)).principal  # a/c^2, a/b^2
    (0.0625, 0.25)
    """
    squares, place = np.array(axes, dtype=float) ** 2, np.array(point, dtype=float)
    level = float(np.sum(place * place / squares)) if np.all(squares > 0.0) else 0.0
    if not (np.isfinite(squares).all() and min(axes) > 0.0 and level > 0.0 and math.isfinite(level)):
        require(
            [Problem("axes, point", (tuple(axes), place.tolist()), "must be positive lengths and a point off the centre", "give both in m")]
        )
    gradient = place / math.sqrt(level) / squares  # half of it, as the Hessian below
    length = float(np.linalg.norm(gradient))
    normal = gradient / length
    across = np.eye(3) - np.outer(normal, normal)
    tensor = across @ np.diag(1.0 / squares) @ across / length
    return Curvature(normal, tensor, *_principal(tensor, normal))


def bluntness(half_axes: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Least and largest effective radius over mean radius, as in `contactlaws.shaped`, of any contacts of ellipsoids: shape (n,) each.

    half_axes: in m, shape (n, 3). On a flat the ratio is 1/sqrt(K) over the mean radius, largest at the end of the shortest axis; bodies
    that meet crossed come down to one over the mean curvature, least at the end of the longest. Between two bodies it lies within both.

    >>> least, largest = bluntness([(1.0, 1.0, 1.0), (1.0, 2.0, 2.0)])
    >>> least.round(3), largest.round(3)
    (array([1.   , 0.504]), array([1.  , 2.52]))
    """
    axes = np.asarray(half_axes, dtype=float)
    mean, short, long = np.cbrt(axes.prod(axis=1)), axes.min(axis=1), axes.max(axis=1)
    mean_curvature = 0.5 * long * ((axes**-2.0).sum(axis=1) - long**-2.0)
    return 1.0 / (mean * mean_curvature), (mean / short) ** 2


def gap(one: FloatArray, other: FloatArray, normal: FloatArray) -> Gap:
    """Of two surfaces by their curvature tensors (1/m) in one frame, at a point with the common `normal`; a flat's is zero.

    Half the sum of the tensors: the angle between their principal directions is in it.
    """
    (smaller, larger), directions = _principal(0.5 * (one + other), normal)
    return Gap(smaller, larger, directions)
