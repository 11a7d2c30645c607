"""Appendix A: principal curvatures of an ellipsoid from a chart of its surface, as printed and corrected.

Only to show what the misprint does: `contactlaws.ellipsoid` needs no chart, and is not singular where y z = 0, at x = 0 and at umbilics.
"""

from __future__ import annotations

import math

import numpy as np

from contactlaws.curve import FloatArray
from contactlaws.ellipsoid import curvature

Axes = tuple[float, float, float]


def curvatures(axes: Axes, point: FloatArray, as_printed: bool) -> list[float]:
    """Eqs. 61 to 68 at a point (m) with x y z != 0, in 1/m, the smaller first; `as_printed` with (EM - GL), else with (EN - GL)."""
    (a, b, c), (x, y, z) = axes, point.tolist()
    normal = math.sqrt(1.0 + a**4 * y**2 / (b**4 * x**2) + a**4 * z**2 / (c**4 * x**2))
    e, f, g = a**4 * y**2 / (b**4 * x**2) + 1.0, a**4 * y * z / (b**2 * c**2 * x**2), a**4 * z**2 / (c**4 * x**2) + 1.0
    low, m, n = np.array([a**4 * (c**2 - z**2), a**4 * y * z, a**4 * (b**2 - y**2)]) / (b**2 * c**2 * normal * x**3)
    middle = (e * m if as_printed else e * n) - g * low
    root = np.emath.sqrt(middle**2 - 4.0 * (e * m - f * low) * (f * n - g * m))

    def along(sign: float) -> float:
        angle = np.arctan(2.0 * (e * m - f * low) / (-middle + sign * root))
        cos, sin = np.cos(angle), np.sin(angle)
        value = (low * cos**2 + 2.0 * m * cos * sin + n * sin**2) / (e * cos**2 + 2.0 * f * cos * sin + g * sin**2)
        return float(np.real(value))

    return sorted(along(sign) for sign in (-1.0, 1.0))


def on_surface(axes: Axes, ray: Axes) -> FloatArray:
    """The point of an ellipsoid along a ray from its centre."""
    return np.array(ray) / math.sqrt(sum((x / a) ** 2 for x, a in zip(ray, axes, strict=True)))


def largest_error(axes: Axes, ray: Axes, as_printed: bool) -> float:
    """Of a principal curvature along `ray`, relative.

    >>> round(largest_error((1.0, 0.5, 0.8), (1.0, 1.0, 1.0), as_printed=True), 3)
    0.358
    """
    point = on_surface(axes, ray)
    found, exact = curvatures(axes, point, as_printed), curvature(axes, point).principal
    return max(abs(value / right - 1.0) for value, right in zip(found, exact, strict=True))
