"""One contact of ellipsoids that keeps its place: what its law says along a path of overlaps, contact ellipse included.

Bodies are pressed along the first of their axes, against a rigid flat or each other; for contacts anywhere else the discrete-element
kernels find place and shape by themselves (`contactlaws.ellipsoid_gap`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws import shaped
from contactlaws.contact_ellipse import exact_factors, slender_problems
from contactlaws.ellipsoid import FloatArray, curvature, gap
from contactlaws.errors import Problem, require
from contactlaws.hertz_ellipse import HertzEllipse
from contactlaws.material import Material
from contactlaws.pair import effective
from contactlaws.whole_range_ellipsoid import WholeRangeEllipsoid, whole_range_ellipsoid

Axes = tuple[float, float, float]


class Path(NamedTuple):
    """Along a path of overlaps; arrays of one length."""

    overlap: FloatArray  # m; approach of the two bodies, or of the body's centre and the flat
    force: FloatArray  # N
    contact_radius: FloatArray  # m; sqrt(a_c b_c)
    semi_axes: FloatArray  # m; a_c >= b_c, shape (n, 2)


class EllipsoidContact(NamedTuple):
    """A contact of constant shape; make it with `on_flat` or `of_pair`."""

    law: object  # a registered shaped law
    shape: tuple[float, float, float]  # of the one body that the law is of, see `contactlaws.shaped`
    share: float  # of the overlap that is this body's
    axes: float  # b_c/a_c of Hertz's ellipse, which the contact keeps
    mean_radius: float  # m; of the bodies, for overlaps relative to it: of a pair that of both together

    def along(self, overlap: npt.ArrayLike) -> Path:
        """Forces and contact areas along a path that begins untouched, or with its first overlap as the largest so far; any unit steps."""
        path = np.atleast_1d(np.asarray(overlap, dtype=float))
        if not np.isfinite(path).all():
            require([Problem("overlap", "not finite", "must be numbers", "give the path in m")])
        memory, rows = shaped.untouched(self.law), []
        for depth in path * self.share:
            force, memory = shaped.force(self.law, self.shape, max(float(depth), 0.0), memory)
            rows.append((force, shaped.contact_radius(self.law, self.shape, max(float(depth), 0.0), memory)))
        force, radius = np.array(rows).T
        semi_axes = radius[:, None] * np.array([self.axes**-0.5, self.axes**0.5])
        return Path(path, force, radius, semi_axes)


def on_flat(material: Material, axes: Axes) -> EllipsoidContact:
    """An ellipsoid with these semi-axes (m) on a rigid flat across the first. Raises `InputError`.

    >>> contact = on_flat(Material(142e9, 0.25, 7.9e9), (5e-6, 6e-6, 4e-6))
    >>> path = contact.along(np.array([0.1, 0.2, 0.15]) * 1e-6)
    >>> bool(path.force[2] < path.force[0])  # unloaded from .2 um, .15 um bear less than .1 um did before
    False
    """
    require(_problems(axes))
    tensor = _at_the_pole(axes)
    return _contact(ellipsoid_law(material), tensor, np.zeros((3, 3)), _mean(axes), 1.0, _mean(axes))


def of_pair(material_1: Material, axes_1: Axes, material_2: Material, axes_2: Axes, angle: float = 0.0) -> EllipsoidContact:
    """Two ellipsoids pressed along their first axes (m), the second axes at an `angle` (radians) to each other. Raises `InputError`.

    Two unlike materials count as one, `contactlaws.pair.effective`; radii of curvature and mean radii as in `contactlaws.shaped`.
    """
    require([*_problems(axes_1), *_problems(axes_2, "other_axes")])
    mean_1, mean_2, share = _mean(axes_1), _mean(axes_2), 0.5
    turn = np.array([[1.0, 0.0, 0.0], [0.0, math.cos(angle), -math.sin(angle)], [0.0, math.sin(angle), math.cos(angle)]])
    body = effective(material_1, mean_1, material_2, mean_2, share)
    other = turn @ _at_the_pole(axes_2) @ turn.T
    mean = mean_1 * mean_2 / ((mean_1 + mean_2) * share)
    return _contact(ellipsoid_law(body.material), _at_the_pole(axes_1), other, mean, share, mean_1 + mean_2)


def ellipsoid_law(material: Material) -> HertzEllipse | WholeRangeEllipsoid:
    """The law of ellipsoids of a material: the whole-range one, or Hertz's if it does not yield."""
    return HertzEllipse(float(material.reduced_modulus)) if material.yield_stress is None else whole_range_ellipsoid(material)


def _contact(law: object, one: FloatArray, other: FloatArray, mean: float, share: float, both: float) -> EllipsoidContact:
    between = gap(one, other, np.array([1.0, 0.0, 0.0]))
    ratio = between.larger / between.smaller
    return EllipsoidContact(law, (between.effective_radius / share, ratio, mean), share, exact_factors(ratio).axes, both)


def _at_the_pole(axes: Axes) -> FloatArray:
    return curvature(axes, (axes[0], 0.0, 0.0)).tensor


def _mean(axes: Axes) -> float:
    return math.cbrt(math.prod(axes))


def _problems(axes: Axes, name: str = "axes") -> list[Problem]:
    if len(axes) != 3 or not all(math.isfinite(axis) and axis > 0.0 for axis in axes):
        return [Problem(name, axes, "must be three positive lengths", "give the semi-axes in m, that of the load first")]
    return list(slender_problems(name, axes))
