"""Hertz's law of an elliptical contact: elastic, small, no friction; the shape of the contact comes with every call."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from contactlaws.compiled import inlined, kernel
from contactlaws.contact_ellipse import fast_mean_factors
from contactlaws.errors import Problem
from contactlaws.shaped import ShapedLaw, register


class HertzEllipse(NamedTuple):
    """An elastic body with two curvatures on a rigid flat (Hertz 1882): F = 4/3 E* sqrt(R) (d/f2)^1.5, see `contactlaws.contact_ellipse`.

    >>> law = HertzEllipse(reduced_modulus=151.47e9)
    >>> force, _ = hertz_ellipse_force(law, (5e-6, 1.0, 5e-6), 5e-8, ())  # a sphere
    >>> round(force * 1e3, 3)
    5.049
    """

    reduced_modulus: float  # Pa; E/(1 - nu^2) of the one body


@inlined
def hertz_ellipse_force(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """4/3 E* sqrt(R) (d/f2)^1.5."""
    x = max(overlap, 0.0) / fast_mean_factors(shape[1])[1]
    return 4.0 / 3.0 * law.reduced_modulus * math.sqrt(shape[0] * x) * x, memory


@inlined
def hertz_ellipse_contact_radius(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """c = f1 (3 F R/(4 E*))^(1/3) = f1 sqrt(R d/f2)."""
    mean_radius, approach = fast_mean_factors(shape[1])
    return mean_radius * math.sqrt(shape[0] * max(overlap, 0.0) / approach)


@kernel
def hertz_ellipse_stored(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """2/5 F d: all of it can be got back."""
    push, _ = hertz_ellipse_force(law, shape, overlap, memory)
    return 0.4 * push * max(overlap, 0.0)


@kernel
def hertz_ellipse_stiffness_bound(law, shape, overlap):  # type: ignore[no-untyped-def]
    """dF/dd = 2 E* sqrt(R d/f2^3)."""
    approach = fast_mean_factors(shape[1])[1]
    return 2.0 * law.reduced_modulus * math.sqrt(shape[0] * max(overlap, 0.0) / (approach * approach * approach))


def _problems(law: HertzEllipse) -> Iterator[Problem]:
    if not (isinstance(law.reduced_modulus, float) and 0.0 < law.reduced_modulus < math.inf):
        yield Problem("reduced_modulus", law.reduced_modulus, "must be a positive finite float", "give E/(1 - nu^2) in Pa")


register(
    ShapedLaw(
        "hertz_ellipse",
        HertzEllipse,
        hertz_ellipse_force,
        hertz_ellipse_contact_radius,
        hertz_ellipse_stored,
        hertz_ellipse_stiffness_bound,
        (),
        "Hertz 1882; Johnson 1985, Eqs. 4.25 to 4.28",
        _problems,
    )
)
