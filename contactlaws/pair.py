"""From one body on a rigid flat to a pair: the only place where the two conventions meet.

Two equal spheres of radius R that approach by `overlap` are each a body on a flat at overlap/2. Spheres of one material and radii R1, R2
meet like two equal spheres of radius 2 R1 R2/(R1 + R2): exact for Hertz and for plasticity that is small against the radius. A law belongs
to a body of radius `law.radius`; another radius is reached by scaling lengths by s, forces by s^2, energies by s^3 (no material length).
Spheres of two materials meet like two equal spheres of a third, `effective`: a law made for that one is the law of the pair.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from contactlaws import dispatch
from contactlaws.compiled import kernel
from contactlaws.errors import Problem, require
from contactlaws.material import Material, problems_with


class Body(NamedTuple):
    """One sphere: what a law on a flat is made for."""

    material: Material
    radius: float  # m


def effective(material_1: Material, radius_1: float, material_2: Material, radius_2: float) -> Body:
    """The body of which two equal ones meet like sphere 1 and sphere 2; its density is None.

    Radius 2 R1 R2/(R1 + R2) and reduced modulus 2 E1' E2'/(E1' + E2'), E' = E/(1 - nu^2): Hertz with both curvatures, so elastic contact
    and the stiffness at which unloading starts (2 E* a for the pair) are exact at small overlap. Yield stress and Poisson's ratio are those
    of the sphere that yields first (`pressure_at_yield` times its yield stress is the smaller): first yield is exact, and so is the fully
    plastic force at small overlap, where only the softer sphere flows (Storakers, Biwa & Larsson 1997, Int. J. Solids Struct. 34, 3061: a^2
    grows with R d whichever sphere flows, and for perfect plasticity the pressure is that of the softer). Two spheres of one material
    and radius are given back unchanged. Raises `InputError`.

    >>> ball, plate = Material(210e9, 0.3, 2e9), Material(70e9, 0.33, 0.3e9)
    >>> body = effective(ball, 2e-3, plate, 1e-3)
    >>> round(body.radius * 1e3, 4), body.material.poissons_ratio, body.material.yield_stress
    (1.3333, 0.33, 300000000.0)
    >>> round(body.material.reduced_modulus / 1e9, 2)
    117.21
    """
    require((*_problems_of("1", material_1, radius_1), *_problems_of("2", material_2, radius_2)))
    reduced = 2.0 / (1.0 / material_1.reduced_modulus + 1.0 / material_2.reduced_modulus)
    first = min(material_1, material_2, key=first_yield_pressure)
    nu = first.poissons_ratio
    if first.yield_stress is None:  # no sphere yields: the softer counts the more
        nu = 0.5 * reduced * sum(m.poissons_ratio / m.reduced_modulus for m in (material_1, material_2))
    material = Material(reduced * (1.0 - nu * nu), nu, first.yield_stress)
    return Body(material, 2.0 * radius_1 * radius_2 / (radius_1 + radius_2))


def first_yield_pressure(material: Material) -> float:
    """Largest contact pressure in Pa at which a sphere of this material first yields; infinite if it never does."""
    return math.inf if material.yield_stress is None else pressure_at_yield(material.poissons_ratio) * material.yield_stress


def pressure_at_yield(poissons_ratio: float) -> float:
    """Largest contact pressure over yield stress at first yield: von Mises on the axis of the Hertz field (Johnson 1985, Eq. 3.45).

    >>> [round(pressure_at_yield(nu), 4) for nu in (0.0, 0.15, 0.3, 0.45)]
    [1.2993, 1.4453, 1.6128, 1.8061]
    """

    def difference(depth: float) -> float:
        """|sigma_z - sigma_r| over the largest pressure, depth over contact radius."""
        return abs((1.0 + poissons_ratio) * (1.0 - depth * math.atan(1.0 / depth)) - 1.5 / (1.0 + depth * depth))

    low, high = 0.1, 1.0  # it rises and falls once in between, for all Poisson's ratios
    for _ in range(80):
        third = (high - low) / 3.0
        low, high = (low, high - third) if difference(low + third) > difference(high - third) else (low + third, high)
    return 1.0 / difference(0.5 * (low + high))


def _problems_of(number: str, material: Material, radius: float) -> Iterator[Problem]:
    for problem in problems_with(material):
        yield problem._replace(name=f"material_{number}: {problem.name}")
    if not (math.isfinite(radius) and radius > 0.0):
        yield Problem(f"radius_{number}", radius, "must be a positive length", "give it in m; a flat is a sphere of a very large radius")


@kernel
def pair_scale(law, radius_i, radius_j):  # type: ignore[no-untyped-def]
    """Ratio of the equivalent equal spheres' radius to the law's radius."""
    return 2.0 * radius_i * radius_j / ((radius_i + radius_j) * law.radius)


@kernel
def pair_force(law, scale, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Force in N between two spheres whose centres are `overlap` (m) closer than the sum of their radii, and the new memory."""
    half = 0.5 / scale
    force, state = dispatch.normal_force(law, overlap * half, rate * half, dt, state)
    return scale * scale * force, state


@kernel
def pair_contact_radius(law, scale, overlap, state):  # type: ignore[no-untyped-def]
    """Contact radius in m of the pair."""
    return scale * dispatch.contact_radius(law, 0.5 * overlap / scale, state)


@kernel
def pair_energy(law, scale, overlap, state):  # type: ignore[no-untyped-def]
    """Stored and dissipated energy in J of both bodies together."""
    stored, dissipated = dispatch.energy(law, 0.5 * overlap / scale, state)
    factor = 2.0 * scale * scale * scale
    return factor * stored, factor * dissipated


@kernel
def pair_stiffness_bound(law, scale, overlap):  # type: ignore[no-untyped-def]
    """Largest tangent stiffness in N/m of the pair, over all histories that stay at or below `overlap`."""
    return 0.5 * scale * dispatch.stiffness_bound(law, 0.5 * overlap / scale)
