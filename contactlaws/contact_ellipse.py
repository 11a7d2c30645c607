"""Where two curved bodies touch without friction and adhesion, elastic and small: Hertz's ellipse, exactly and fast.

Near the contact the gap between the bodies is A x^2 + B y^2, A <= B. The contact is an ellipse with the longer axis a along x. With
R_e = 1/(2 sqrt(A B)) force, approach and the mean radius c = sqrt(a b) are those of spheres, but for two factors of B/A alone:

    F = 4/3 E* sqrt(R_e) (d/f2)^1.5        c = f1 (3 F R_e/(4 E*))^(1/3)

Hertz's integrals (Johnson 1985, Eqs. 4.25 to 4.28) are Carlson's, A : B : d = R_D(0, b^2, a^2)/3 : R_D(0, a^2, b^2)/3 : R_F(0, a^2, b^2).
In this form nothing cancels where the ellipse is nearly a circle, and a circle is not a special case.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq
from scipy.special import elliprd, elliprf

from contactlaws.compiled import inlined
from contactlaws.errors import Problem, require

#: of `fast_factors`: numerators and denominators of f1 and f2 in tanh(ln(B/A)/4)^2, and of -ln(b/a)/ln(B/A) in ln(B/A)^2;
#: `python -m calibration.contact_ellipse_fit`
FIRST = (-2.0 / 9.0, -0.2006302, 0.2148497, 0.7965379, -1.323653)
SECOND = (-2.0 / 9.0, 0.2922283, -0.07512299, -1.649346, 0.6529754)
AXES = (2.0 / 3.0, 0.04216186, 0.0004209211, 0.06787015, 0.0007540586)
#: up to which curvature ratio these hold
FAST_UP_TO = 100.0
#: largest ratio of half axes, with room for round-off: no ratio of curvatures on an ellipsoid is larger than its square
MOST_SLENDER = math.sqrt(FAST_UP_TO) * (1.0 + 1e-12)


class Factors(NamedTuple):
    """What the ratio of curvatures makes of Hertz's spheres."""

    mean_radius: float  # f1
    approach: float  # f2
    axes: float  # b/a, at most 1


def slender_problems(name: str, half_axes: npt.ArrayLike) -> Iterator[Problem]:
    """Yield a `Problem` if one of these ellipsoids is too slender for `fast_factors`; positive, in any unit, shape (3,) or (n, 3)."""
    half = np.asarray(half_axes, dtype=float)
    slender = float((half.max(axis=-1) / half.min(axis=-1)).max(initial=1.0))
    if slender > MOST_SLENDER:
        bound = f"is the largest ratio of half axes; contacts are known up to {MOST_SLENDER:g}"
        yield Problem(name, slender, bound, "take less slender bodies")


def _of_axes(k: float) -> tuple[float, float, float]:
    """A, B and d of an ellipse with the axes 1 and k, all over the same factor: 3 F/(4 pi E*)."""
    return 2.0 / 3.0 * float(elliprd(0.0, k * k, 1.0)), 2.0 / 3.0 * float(elliprd(0.0, 1.0, k * k)), 2.0 * float(elliprf(0.0, 1.0, k * k))


def exact_factors(ratio: float) -> Factors:
    """The factors at B/A = `ratio`, which may be below 1 (the axes are then exchanged), to some 1e-14. Raises `InputError`.

    >>> [round(value, 5) for value in exact_factors(2.0)]
    [0.99344, 0.99339, 0.6306]
    """
    if not (math.isfinite(ratio) and ratio > 0.0):
        require([Problem("ratio", ratio, "must be a positive finite number", "it is the larger curvature of the gap over the smaller")])
    q = max(ratio, 1.0 / ratio)

    def missing(logarithm: float) -> float:
        a, b, _ = _of_axes(math.exp(logarithm))
        return math.log(b / a) - math.log(q)

    # b/a lies between q^(-2/3), for nearly a circle, and 1/q
    low, high = -math.log(q) * (1.0 + 1e-12), -0.5 * math.log(q)
    k = 1.0 if q == 1.0 else math.exp(brentq(missing, low, high, xtol=1e-15, rtol=4.0 * np.finfo(float).eps))
    a, b, approach = _of_axes(k)
    radius = 0.5 / math.sqrt(a * b)
    return Factors(math.sqrt(k) / math.cbrt(math.pi * radius), float(approach) / math.cbrt(math.pi / math.sqrt(radius)) ** 2, k)


@inlined
def fast_mean_factors(ratio):  # type: ignore[no-untyped-def]
    """f1 and f2 of `fast_factors`, all that forces and mean radii ask for: roots and divisions alone, so several contacts at a time."""
    root = math.sqrt(ratio)
    t = (root - 1.0) / (root + 1.0)
    z = t * t
    mean_radius = 1.0 + z * (FIRST[0] + z * (FIRST[1] + z * FIRST[2])) / (1.0 + z * (FIRST[3] + z * FIRST[4]))
    return mean_radius, 1.0 + z * (SECOND[0] + z * (SECOND[1] + z * SECOND[2])) / (1.0 + z * (SECOND[3] + z * SECOND[4]))


@inlined
def fast_factors(ratio):  # type: ignore[no-untyped-def]
    """f1, f2 and b/a within 4e-6 of `exact_factors` for ratios from .01 to 100, and right to second order around a circle."""
    mean_radius, approach = fast_mean_factors(ratio)
    x = math.log(ratio)
    y = x * x
    power = (AXES[0] + y * (AXES[1] + y * AXES[2])) / (1.0 + y * (AXES[3] + y * AXES[4]))
    return mean_radius, approach, math.exp(-abs(x) * power)


def hale(ratio: float) -> tuple[float, float]:
    """f1 and f2 as published by Hale (1999) and used in Becker & Kamlah (2021), Eq. 4 corrected: a rival, .4 % off up to ratios of 20.

    >>> hale(1.0)
    (1.0, 1.0)
    """
    q = max(ratio, 1.0 / ratio)
    return 1.0 - (q**0.0602 - 1.0) ** 1.456, 1.0 - (q**0.0684 - 1.0) ** 1.531
