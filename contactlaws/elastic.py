"""Elastic laws: no memory, nothing dissipated."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contactlaws.compiled import inlined, kernel
from contactlaws.dispatch import Law, register


class Hertz(NamedTuple):
    """A parabolic elastic body on a rigid flat (Hertz 1882): F = 4/3 E* sqrt(R) d^1.5. Good to 1 % for d < 5e-4 R, 5 % for d < 1e-2 R.

    >>> law = Hertz(radius=5e-6, reduced_modulus=151.47e9)
    >>> force, _ = hertz_force(law, 5e-8, 0.0, 0.0, ())
    >>> round(force * 1e3, 3)
    5.049
    """

    radius: float  # m
    reduced_modulus: float  # Pa; E/(1 - nu^2) of the one body


@kernel
def hertz_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Hertz 1882."""
    if overlap <= 0.0:
        return 0.0, state
    return 4.0 / 3.0 * law.reduced_modulus * math.sqrt(law.radius * overlap) * overlap, state


@kernel
def hertz_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """a^2 = R d."""
    return math.sqrt(law.radius * max(overlap, 0.0))


@kernel
def hertz_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored 8/15 E* sqrt(R) d^2.5, dissipated none."""
    x = max(overlap, 0.0)
    return 8.0 / 15.0 * law.reduced_modulus * math.sqrt(law.radius * x) * x * x, 0.0


@kernel
def hertz_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """dF/dd = 2 E* sqrt(R d)."""
    return 2.0 * law.reduced_modulus * math.sqrt(law.radius * max(overlap, 0.0))


register(Law("hertz", Hertz, hertz_force, hertz_contact_radius, hertz_energy, hertz_stiffness_bound, (), "Hertz 1882"))


class HertzFiniteSize(NamedTuple):
    """Hertz times a polynomial in the overlap over the radius, for a body that is no half-space.

    F = F_Hertz (1 + c1 sqrt(D) + c2 D + c3 D^3) and a^2 = R d (1 + b1 sqrt(D) + b2 D^2) with D = d/R. The coefficients are fitted to an
    elastic reference curve and depend on Poisson's ratio only; all zero is Hertz. These powers meet elastic finite-element curves up to D
    = 0.5 within 1 % in force; neighbouring powers (sqrt(D), D, D^1.5) miss by 4 % and cannot be told apart.

    >>> law = HertzFiniteSize(5e-6, 151.47e9, 0.0, 1.0, 0.0, 0.0, 0.0)
    >>> force, _ = hertz_finite_size_force(law, 5e-8, 0.0, 0.0, ())
    >>> round(force * 1e3, 3)
    5.099
    """

    radius: float  # m
    reduced_modulus: float  # Pa; E/(1 - nu^2) of the one body
    force_1: float  # c1, factor of sqrt(D)
    force_2: float  # c2, factor of D
    force_3: float  # c3, factor of D^3
    area_1: float  # b1, factor of sqrt(D)
    area_2: float  # b2, factor of D^2


#: c1, c2, c3, b1, b2 of `HertzFiniteSize` for a sphere, as polynomials in Poisson's ratio, constant first: what
#: `python -m calibration.finite_size_fit` finds
FINITE_SIZE = (
    (-0.0137909, 1.97628, -0.362552, -4.49909),
    (1.59388, -3.16954, 0.404837, 4.58357),
    (-0.463062, 25.6856, 2.35874, -45.0285),
    (-0.116611, 1.18095, -0.836957),
    (0.54447, -1.10627, 7.43961),
)


def finite_size_factors(poissons_ratio: float) -> tuple[float, float, float, float, float]:
    """c1, c2, c3, b1 and b2 of `HertzFiniteSize` for a sphere of any material, up to an overlap of 0.3 radii.

    Up to 0.1 radii the force is within 0.15 % of finite elements for Poisson's ratios from 0.3 on, 0.3 % at 0.2 and 0.8 % at 0; up to 0.3
    radii within 0.6 %, and 1.4 % at 0. The contact radius is within 0.7 %.
    """
    c1, c2, c3, b1, b2 = (float(np.polynomial.polynomial.polyval(poissons_ratio, row)) for row in FINITE_SIZE)
    return c1, c2, c3, b1, b2


@inlined
def finite_size_force(law, overlap):  # type: ignore[no-untyped-def]
    """Force in N of any record that has the fields of `HertzFiniteSize`; `overlap` must not be negative."""
    t = math.sqrt(overlap * (1.0 / law.radius))  # of many contacts, one division
    factor = 1.0 + t * (law.force_1 + t * (law.force_2 + t**4 * law.force_3))
    return 4.0 / 3.0 * law.reduced_modulus * law.radius * t * overlap * factor


@kernel
def finite_size_energy(law, overlap):  # type: ignore[no-untyped-def]
    """Integral of `finite_size_force` from 0, term by term."""
    t = math.sqrt(overlap / law.radius)
    factor = 2.0 / 5.0 + t * (law.force_1 / 3.0 + t * (law.force_2 * 2.0 / 7.0 + t**4 * law.force_3 * 2.0 / 11.0))
    return 4.0 / 3.0 * law.reduced_modulus * law.radius * t * overlap * overlap * factor


@kernel
def finite_size_stiffness(law, overlap):  # type: ignore[no-untyped-def]
    """Derivative of `finite_size_force`."""
    t = math.sqrt(overlap / law.radius)
    factor = 1.5 + t * (2.0 * law.force_1 + t * (2.5 * law.force_2 + t**4 * 4.5 * law.force_3))
    return 4.0 / 3.0 * law.reduced_modulus * law.radius * t * factor


@kernel
def finite_size_area(law, overlap):  # type: ignore[no-untyped-def]
    """Contact radius squared in m2."""
    t = math.sqrt(overlap / law.radius)
    return law.radius * overlap * max(0.0, 1.0 + t * (law.area_1 + t**3 * law.area_2))


@kernel
def largest_finite_size_stiffness(law, overlap):  # type: ignore[no-untyped-def]
    """Largest tangent from 0 to `overlap`: the tangent itself where it grows, else the largest of 33 along the way."""
    largest = finite_size_stiffness(law, overlap)
    for i in range(1, 33):
        largest = max(largest, finite_size_stiffness(law, overlap * i / 33.0))
    return largest


@kernel
def hertz_finite_size_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Hertz with the finite-size factor."""
    if overlap <= 0.0:
        return 0.0, state
    return finite_size_force(law, overlap), state


@kernel
def hertz_finite_size_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """a^2 = R d (1 + b1 sqrt(D) + b2 D^2)."""
    return math.sqrt(finite_size_area(law, max(overlap, 0.0)))


@kernel
def hertz_finite_size_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """All stored, nothing dissipated."""
    return finite_size_energy(law, max(overlap, 0.0)), 0.0


@kernel
def hertz_finite_size_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """The largest tangent up to `overlap`."""
    return largest_finite_size_stiffness(law, max(overlap, 0.0))


register(
    Law(
        "hertz_finite_size",
        HertzFiniteSize,
        hertz_finite_size_force,
        hertz_finite_size_contact_radius,
        hertz_finite_size_energy,
        hertz_finite_size_stiffness_bound,
        (),
        "Hertz 1882, with a factor fitted to elastic finite-element curves",
    )
)
