"""Forces beside the normal one: friction, rolling resistance, a damper. Small records, given to a contact by role.

Friction is Mindlin & Deresiewicz (1953) in increments: the tangential force grows by 8 G* a per way slipped by the two surfaces, 1/G* =
(2 - nu_i)/G_i + (2 - nu_j)/G_j, and never exceeds the friction coefficient times the normal force. When the contact shrinks the force
shrinks with its radius (Thornton & Randall 1988); without that, a path of loading, shearing, unloading and shearing back would gain energy
(Elata & Berryman 1996). Rolling resistance is the same with the relative turn instead of the slip (Ai, Chen, Rotter & Ooi 2011, model C).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from contactlaws.compiled import inlined
from contactlaws.errors import Problem, require
from contactlaws.material import Material, problems_with
from contactlaws.rivals.hertz_spring_dashpot import damping_ratio

#: smaller than any squared force; keeps a division by the force of an open contact from being 0/0
SMALLEST = 1e-300


class Mindlin(NamedTuple):
    """Friction of a pair; made by `mindlin`, or of its numbers."""

    shear_modulus: float  # Pa; G* of the pair: for two equal bodies G/(2 (2 - nu))
    friction: float  # coefficient
    shrinking: bool = True  # whether the force shrinks with the contact radius
    turning: bool = True  # whether the force turns with the spheres about the line of centres


class Rolling(NamedTuple):
    """Resistance to rolling: a moment of stiffness 8 G* a R^2, at most `friction` R F, R being R_i R_j/(R_i + R_j)."""

    friction: float


class Damper(NamedTuple):
    """A force sqrt(5) z sqrt(4/3 E* a m) d' against the approach: Hertz's spring then returns the restitution that z was made for."""

    reduced_modulus: float  # Pa; E* of the pair: for two equal bodies E/(2 (1 - nu^2))
    ratio: float  # z


def mindlin(friction: float, material_1: Material, material_2: Material | None = None) -> Mindlin:
    """Friction of spheres of one material or of two; a rigid partner is one of a very large modulus. Raises `InputError`.

    >>> round(mindlin(0.5, Material(142e9, 0.25)).shear_modulus / (142e9 / 2.5 / 3.5), 12)
    1.0
    """
    pair = (material_1, material_2 or material_1)
    require([*(problem for material in pair for problem in problems_with(material)), *_problems("friction", friction, math.inf)])
    nu, modulus = zip(*((m.poissons_ratio, m.youngs_modulus) for m in pair), strict=True)
    return Mindlin(1.0 / sum(2.0 * (2.0 - n) * (1.0 + n) / e for n, e in zip(nu, modulus, strict=True)), friction)


def rolling(friction: float) -> Rolling:
    """Rolling resistance; raises `InputError` for a coefficient below 0."""
    require(_problems("rolling friction", friction, math.inf))
    return Rolling(friction)


def damper(restitution: float, material_1: Material, material_2: Material | None = None) -> Damper:
    """The damper with which elastic spheres part at `restitution` (0 < e <= 1) times the speed at which they met; the force ends at 0.

    On a law that dissipates by itself it takes its share on top. Raises `InputError`.
    """
    pair = (material_1, material_2 or material_1)
    wrong = [problem for material in pair for problem in problems_with(material)]
    if not 0.0 < restitution <= 1.0:
        wrong.append(Problem("restitution", restitution, "must lie in (0, 1]", "1 is no damper; 0 no damper can reach"))
    require(wrong)
    return Damper(1.0 / sum(1.0 / material.reduced_modulus for material in pair), damping_ratio(restitution, pull=False))


def _problems(name: str, value: float, most: float) -> Iterator[Problem]:
    if not (math.isfinite(value) and 0.0 <= value <= most):
        yield Problem(name, value, "must be a finite number, 0 or more", "leave the role out for none")


@inlined
def damper_force(law, contact_radius, mass, rate):  # type: ignore[no-untyped-def]
    """Force in N against an approach at `rate` (m/s) of spheres of the reduced `mass` (kg)."""
    return math.sqrt(5.0 * 4.0 / 3.0 * law.reduced_modulus * contact_radius * mass) * law.ratio * rate


@inlined
def tangential_stiffness(law, contact_radius):  # type: ignore[no-untyped-def]
    """8 G* a in N/m."""
    return 8.0 * law.shear_modulus * contact_radius


@inlined
def dragged(stiffness, limit, radius, radius_before, turn, n, way, old):  # type: ignore[no-untyped-def]
    """A force (or moment) in the contact's plane after a `way` (or angle), both vectors; and the work done on it.

    `old` is the force before: it is brought into the plane across the unit vector `n`, turned about it by the angle `turn`, and keeps its
    length, less as the contact's `radius` shrinks. The result is at most `limit`. Squares are compared: one root and one division for each
    length.
    """
    out = old[0] * n[0] + old[1] * n[1] + old[2] * n[2]
    x, y, z = old[0] - out * n[0], old[1] - out * n[1], old[2] - out * n[2]
    before = old[0] * old[0] + old[1] * old[1] + old[2] * old[2]
    left, had = min(radius, radius_before) ** 2, radius_before * radius_before
    length = math.sqrt(before * left / max((x * x + y * y + z * z) * had * (1.0 + turn * turn), SMALLEST))
    x, y, z = length * x, length * y, length * z
    x, y, z = x + turn * (n[1] * z - n[2] * y), y + turn * (n[2] * x - n[0] * z), z + turn * (n[0] * y - n[1] * x)
    out = way[0] * n[0] + way[1] * n[1] + way[2] * n[2]
    wx, wy, wz = way[0] - out * n[0], way[1] - out * n[1], way[2] - out * n[2]
    fx, fy, fz = x + stiffness * wx, y + stiffness * wy, z + stiffness * wz
    most = math.sqrt(min(1.0, limit * limit / max(fx * fx + fy * fy + fz * fz, SMALLEST)))
    fx, fy, fz = most * fx, most * fy, most * fz
    return (fx, fy, fz), 0.5 * ((x + fx) * wx + (y + fy) * wy + (z + fz) * wz)
