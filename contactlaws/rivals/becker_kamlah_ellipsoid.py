"""Becker & Kamlah 2021 for two ellipsoids, and for one on a rigid flat: the sphere's law of another radius and another modulus.

The contact is Hertz's ellipse of the undeformed bodies. With R_e = 1/(2 sqrt(A B)), E_e and the factors f1, f2 of B/A the mean radius
c = sqrt(a b) and the elastic force are

    c^2 = R_e d f1^2/f2        F_H = 4/3 E_e sqrt(R_e) (d/f2)^1.5        p_0 = 2 E_e c/(pi R_e f1^3)      Eqs. 9, 10, 2

which are a sphere's of the radius R_e f1^2/f2 and the modulus E_e/(f1 f2), p_0 included. Loading (Eqs. 25 to 31) and unloading (Eqs. 43 to
49) are written in c, F_H and p_0 alone, so they are those of `contactlaws.rivals.becker_kamlah` with these two. The semi-axes keep the
ratio of Hertz's ellipse. What the shape adds is lambda_max and epsilon_max, by Eq. 54 from R_e/(r_I + r_J).

A rigid flat has no mean radius, and the paper does not say what to take. Here it is the mirror image: a body that meets its own image
across the flat has the same force and pressure at twice the overlap. Of this pair R_e is half of the body's R on the flat, and r_I + r_J is
2 r. So R_e/(r_I + r_J) = R/(4 r) with the body's own R and r, and a sphere has 1/4, on a flat as on its like.

Kept as published: at unloading the contact jumps in size by beta; where R_e/(r_I + r_J) is above .18 the force exceeds Hertz's just past
yield, and above .35 more can be got back there than was put in; all constants are those of one material.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from contactlaws.compiled import inlined, kernel
from contactlaws.contact_ellipse import exact_factors, fast_mean_factors
from contactlaws.ellipsoid import Gap
from contactlaws.errors import Problem, require
from contactlaws.rivals.becker_kamlah import (
    EXPONENT,
    FIRST,
    PRESSURE_CONSTANTS,
    RADIUS_CONSTANTS,
    BeckerKamlah,
    becker_kamlah_contact_radius,
    becker_kamlah_energy,
    becker_kamlah_force,
    becker_kamlah_recovered,
    becker_kamlah_stiffness_bound,
    levelling,
)
from contactlaws.shaped import ShapedLaw, register

_levelling = inlined(levelling)


class BeckerKamlahEllipsoid(NamedTuple):
    """A material, and how its contacts harden with their shape: Eqs. 52 and 53, of the authors' one material unless fitted.

    `reduced_modulus` is that of what meets: E/(1 - nu^2) of a body on a rigid flat, 1/(1/E_1' + 1/E_2') of a pair (Eq. 3).
    """

    reduced_modulus: float  # Pa
    yield_stress: float  # Pa; of a pair the smaller
    pressure_scale: float = PRESSURE_CONSTANTS[0]  # m
    pressure_rate: float = PRESSURE_CONSTANTS[1]  # o
    pressure_limit: float = PRESSURE_CONSTANTS[2]  # p
    radius_scale: float = RADIUS_CONSTANTS[0]  # s
    radius_rate: float = RADIUS_CONSTANTS[1]  # t
    radius_limit: float = RADIUS_CONSTANTS[2]  # u
    exponent: float = EXPONENT  # n


class EllipseContact(NamedTuple):
    """A contact of constant shape; `law` is a registered law, whose contact radius is c and whose overlap is the whole approach."""

    law: BeckerKamlah
    axes: float  # b_c/a_c, at most 1


@inlined
def becker_kamlah_circle(law, radius, relative_radius, mean_radius_factor, approach_factor):  # type: ignore[no-untyped-def]
    """The sphere's law with the same c and F at every overlap.

    radius: R_e in m. relative_radius: R_e/(r_I + r_J). mean_radius_factor, approach_factor: f1, f2.
    """
    return BeckerKamlah(
        radius * mean_radius_factor * mean_radius_factor / approach_factor,
        law.reduced_modulus / (mean_radius_factor * approach_factor),
        law.yield_stress,
        _levelling(relative_radius, law.pressure_scale, law.pressure_rate, law.pressure_limit),
        _levelling(relative_radius, law.radius_scale, law.radius_rate, law.radius_limit),
        law.exponent,
    )


def contact_of(law: BeckerKamlahEllipsoid, gap: Gap, *mean_radii: float) -> EllipseContact:
    """The contact of two bodies with these mean radii (abc)^(1/3) in m, or of one on a rigid flat; f1 and f2 by the exact integrals.

    gap: of the two undeformed surfaces (`contactlaws.ellipsoid.gap`), the flat's curvature being zero. Raises `InputError`.

    >>> contact = contact_of(BeckerKamlahEllipsoid(75.7, 7.9), Gap(1.0, 1.0, None), 1.0, 1.0)  # equal spheres of radius 1
    >>> round(contact.law.radius, 12), round(contact.law.pressure_ratio, 3), round(contact.law.radius_ratio, 3), contact.axes
    (0.5, 2.751, 2.905, 1.0)
    """
    require(_problems(law, gap, mean_radii))
    radius, factors = gap.effective_radius, exact_factors(gap.larger / gap.smaller)
    found = becker_kamlah_circle(law, radius, relative_radius(radius, *mean_radii), factors.mean_radius, factors.approach)
    return EllipseContact(BeckerKamlah(*found), factors.axes)


def relative_radius(radius: float, *mean_radii: float) -> float:
    """R_e/(r_I + r_J) of two bodies; of one body on a rigid flat that of the body and its mirror image, R_e/(4 r). All in m.

    >>> relative_radius(0.5, 1.0, 1.0), relative_radius(1.0, 1.0)
    (0.25, 0.25)
    """
    return radius / (sum(mean_radii) if len(mean_radii) == 2 else 4.0 * mean_radii[0])


def _problems_of_material(law: BeckerKamlahEllipsoid) -> Iterator[Problem]:
    for name in ("reduced_modulus", "yield_stress"):
        value = getattr(law, name)
        if not (math.isfinite(value) and value > 0.0):
            yield Problem(name, value, "must be a positive finite number", "give it in Pa")


def _problems(law: BeckerKamlahEllipsoid, gap: Gap, mean_radii: tuple[float, ...]) -> list[Problem]:
    found = list(_problems_of_material(law))
    if len(mean_radii) not in (1, 2) or not all(math.isfinite(radius) and radius > 0.0 for radius in mean_radii):
        found.append(Problem("mean_radii", mean_radii, "must be one or two positive lengths", "give (abc)^(1/3) of each body, in m"))
    if not (0.0 < gap.smaller <= gap.larger < math.inf):
        found.append(Problem("gap", (gap.smaller, gap.larger), "must be convex: 0 < A <= B", "give curvatures in 1/m, outwards positive"))
    if found:
        return found
    ratio = relative_radius(gap.effective_radius, *mean_radii)
    constants = {
        "lambda_max": (levelling(ratio, law.pressure_scale, law.pressure_rate, law.pressure_limit), FIRST),
        "epsilon_max": (levelling(ratio, law.radius_scale, law.radius_rate, law.radius_limit), 1.0),
        "exponent": (law.exponent, 1.0),
    }
    return [
        Problem(name, value, f"must be finite, and above {least:g}", f"the constants must hold at R_e/(r_I + r_J) = {ratio:.3g}")
        for name, (value, least) in constants.items()
        if not (math.isfinite(value) and (value >= least if name == "exponent" else value > least))
    ]


@kernel
def becker_kamlah_separation(law, largest):  # type: ignore[no-untyped-def]
    """delta_p in m of a `BeckerKamlah` that was pressed to `largest` (m): Eq. 34 with Eq. 44."""
    return largest - becker_kamlah_recovered(law, largest)


@kernel
def becker_kamlah_semi_axes(law, axes, overlap, state):  # type: ignore[no-untyped-def]
    """a_c and b_c in m (Eq. 8): a b = c^2, b/a = `axes`."""
    mean, root = becker_kamlah_contact_radius(law, overlap, state), math.sqrt(axes)
    return mean / root, mean * root


# One body on a rigid flat whose shape is only known where it touches: shape = (R in m, B/A, (abc)^(1/3) in m); f1 and f2 within 4e-6. Of a
# pair taken as one body at a share of its overlap, with R_e and r_1 r_2/(r_1 + r_2) over that share, lambda_max and epsilon_max are those
# at R_e (r_1 + r_2)/(4 r_1 r_2): Eq. 54 where the two mean radii are equal, as in all of the paper; spheres have 1/4 whatever their radii.


@inlined
def becker_kamlah_shaped(law, shape):  # type: ignore[no-untyped-def]
    """The sphere's law at this shape."""
    mean_radius_factor, approach_factor = fast_mean_factors(shape[1])
    return becker_kamlah_circle(law, shape[0], shape[0] / (4.0 * shape[2]), mean_radius_factor, approach_factor)


@kernel
def becker_kamlah_shaped_force(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """Force in N and new memory (the largest overlap), while the shape stays."""
    return becker_kamlah_force(becker_kamlah_shaped(law, shape), overlap, 0.0, 0.0, memory)


@kernel
def becker_kamlah_shaped_contact_radius(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """c = sqrt(a_c b_c) in m."""
    return becker_kamlah_contact_radius(becker_kamlah_shaped(law, shape), overlap, memory)


@kernel
def becker_kamlah_shaped_stored(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """What can be got back, in J."""
    return becker_kamlah_energy(becker_kamlah_shaped(law, shape), overlap, memory)[0]


@kernel
def becker_kamlah_shaped_stiffness_bound(law, shape, overlap):  # type: ignore[no-untyped-def]
    """Largest tangent in N/m over all histories up to `overlap`."""
    return becker_kamlah_stiffness_bound(becker_kamlah_shaped(law, shape), overlap)


def _problems_of_record(law: BeckerKamlahEllipsoid) -> Iterator[Problem]:
    """What makes it unusable at some shape: lambda_max and epsilon_max are between their values at no radius and at an infinite one."""
    yield from _problems_of_material(law)
    ends = {
        "pressure_limit": (law.pressure_limit, law.pressure_scale, law.pressure_rate, FIRST),
        "radius_limit": (law.radius_limit, law.radius_scale, law.radius_rate, 1.0),
    }
    for name, (limit, scale, rate, least) in ends.items():
        if not (least < limit < math.inf and limit + scale > least and scale < math.inf and -math.inf < rate <= 0.0):
            yield Problem(name, limit, f"must leave more than {least:g} at every shape, and level", "the rate must not be positive")
    if not 1.0 <= law.exponent < math.inf:
        yield Problem("exponent", law.exponent, "must be 1 or more", "the authors have 1.8")


register(
    ShapedLaw(
        "becker_kamlah_ellipsoid",
        BeckerKamlahEllipsoid,
        becker_kamlah_shaped_force,
        becker_kamlah_shaped_contact_radius,
        becker_kamlah_shaped_stored,
        becker_kamlah_shaped_stiffness_bound,
        ("largest overlap",),
        "Becker & Kamlah 2021: Eqs. 24-31, 43-49 and 54, as corrected; a rigid flat as a mirror",
        _problems_of_record,
    )
)
