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
from contactlaws.compiled import inlined, kernel
from contactlaws.errors import Problem, require
from contactlaws.material import Material, problems_with
from contactlaws.prony import PronyViscoelastic, Relaxation, problems_with_series, together


class Body(NamedTuple):
    """One sphere: what a law on a flat is made for."""

    material: Material
    radius: float  # m


def effective(material_1: Material, radius_1: float, material_2: Material, radius_2: float, share: float = 0.5) -> Body:
    """The body whose law, at the `share` of the pair's overlap, is the law of spheres 1 and 2; its density is None.

    With R and E* of the pair (1/R = 1/R1 + 1/R2, 1/E* = 1/E1' + 1/E2', E' = E/(1 - nu^2)) it has the radius R/share and the reduced modulus
    E*/share; yield stress and Poisson's ratio are those of the sphere that yields first, where `pressure_at_yield` times the yield stress
    is the smaller. For any share this is exact at small overlap in three limits: elastic (Hertz with both curvatures), at first yield,
    and fully plastic, where only the softer sphere flows and a^2 grows with R d whichever it is (Storakers, Biwa & Larsson 1997, Int. J.
    Solids Struct. 34, 3061). Unloading starts with the stiffness 2 E* a. Two equal spheres are given back unchanged.

    share = 1/2, the default, is two equal bodies: `pair_force` and the particle simulations take its law as it is. Where one sphere is much
    harder and larger than the other, `share_of_softer` is far better at large overlap; its law takes that share.

    Bounds, shown by `python -m cases.verification.pairs`: a rigid sphere pressed into one of E/Y = 10 to 500, where the curved interface
    counts the most, up to .3 of the softer radius, by finite elements good to 6 %. With `share_of_softer` the force is within 12 % for any
    ratio of the radii, the overlap left after unloading within 6 % of the overlap. With 1/2 the same while the hard sphere is no larger;
    if it is, the law is too stiff beyond .05 of the softer radius: at .3 of it by 9 to 40 % (twice the radius), 15 to 75 % (four times),
    22 to 120 % (a flat). Two bodies each pressed as on a flat, in series, are too stiff by 16 to 450 %. Raises `InputError`.

    >>> ball, plate = Material(210e9, 0.3, 2e9), Material(70e9, 0.33, 0.3e9)
    >>> body = effective(ball, 2e-3, plate, 1e-3)
    >>> round(body.radius * 1e3, 4), body.material.poissons_ratio, body.material.yield_stress
    (1.3333, 0.33, 300000000.0)
    >>> round(body.material.reduced_modulus / 1e9, 2)
    117.21
    """
    require(_problems_of_pair(material_1, radius_1, material_2, radius_2, share))
    modulus = 1.0 / (1.0 / material_1.reduced_modulus + 1.0 / material_2.reduced_modulus)
    first = min(material_1, material_2, key=first_yield_pressure)
    nu = first.poissons_ratio
    if first.yield_stress is None:  # no sphere yields: the softer counts the more
        nu = modulus * sum(m.poissons_ratio / m.reduced_modulus for m in (material_1, material_2))
    material = Material(modulus / share * (1.0 - nu * nu), nu, first.yield_stress)
    return Body(material, radius_1 * radius_2 / ((radius_1 + radius_2) * share))


class BodyInTime(NamedTuple):
    """One viscoelastic sphere: what `contactlaws.maxwell_zener_ting.maxwell_zener_ting` makes a law of."""

    modulus: Relaxation  # Pa; reduced
    radius: float  # m
    poissons_ratio: float  # of the finite-size part


def effective_in_time(material_1: PronyViscoelastic, radius_1: float, material_2: PronyViscoelastic, radius_2: float) -> BodyInTime:
    """`effective`, at the share 1/2, of two viscoelastic spheres: their creep compliances (1 - nu^2)/E add, which makes one series of both.

    Exact at small overlaps while the contact grows, and on a first retreat: the surfaces of both follow the same pressure. An elastic
    sphere is one without relaxation times. Raises `InputError`.

    >>> pvdf, steel = PronyViscoelastic(1.77e9, 0.43, (1.8,), (0.2285,)), PronyViscoelastic(210e9, 0.3, (), ())
    >>> body = effective_in_time(pvdf, 5e-6, steel, 5e-6)
    >>> round(body.modulus.fractions[0], 4), round(body.modulus.times[0], 4)
    (0.2269, 1.8038)
    """
    problems = [
        problem._replace(name=f"material_{number}: {problem.name}")
        for number, material in (("1", material_1), ("2", material_2))
        for problem in problems_with_series(material)
    ]
    require(problems)
    at_once = (material_1.instantaneous, material_2.instantaneous)
    require(_problems_of_pair(at_once[0], radius_1, at_once[1], radius_2, 0.5))
    modulus = together(material_1.reduced, material_2.reduced)
    ratio = modulus.instantaneous * sum(m.poissons_ratio / m.reduced_modulus for m in at_once)
    return BodyInTime(modulus.scaled(2.0), 2.0 * radius_1 * radius_2 / (radius_1 + radius_2), ratio)


def share_of_softer(material_1: Material, radius_1: float, material_2: Material, radius_2: float) -> float:
    """The share of the overlap at which the softer sphere's own size comes into the law: 1/2 to 1, for `effective`.

    Softer is the sphere that yields first, of two that never yield the one of the smaller reduced modulus. If the other is rigid and no
    smaller, the interface lies where the two undeformed spheres meet, and the share is R_other/(R1 + R2): 1/2 for equal radii, 1 for a
    rigid flat, where the law is the softer sphere's own. A smaller rigid sphere sinks in, and 1/2 stays better. In between, the share goes
    linearly with the ratio of the pressures of first yield (of the moduli), to 1/2 for two spheres of one material. Raises `InputError`.

    >>> share_of_softer(Material(70e9, 0.3, 0.3e9), 1e-3, Material(1e20, 0.3), 3e-3)
    0.75
    """
    require(_problems_of_pair(material_1, radius_1, material_2, radius_2, 0.5))
    spheres = ((material_1, radius_1), (material_2, radius_2))
    yields = any(material.yield_stress is not None for material, _ in spheres)
    strength = [first_yield_pressure(material) if yields else material.reduced_modulus for material, _ in spheres]
    soft, hard = (0, 1) if strength[0] <= strength[1] else (1, 0)
    if spheres[hard][1] <= spheres[soft][1]:
        return 0.5
    between = spheres[hard][1] / (radius_1 + radius_2)
    return 0.5 + (between - 0.5) * (1.0 - strength[soft] / strength[hard])


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


def _problems_of_pair(material_1: Material, radius_1: float, material_2: Material, radius_2: float, share: float) -> Iterator[Problem]:
    for number, material, radius in (("1", material_1, radius_1), ("2", material_2, radius_2)):
        for problem in problems_with(material):
            yield problem._replace(name=f"material_{number}: {problem.name}")
        if not (math.isfinite(radius) and radius > 0.0):
            remedy = "give it in m; a flat is a sphere of a very large radius"
            yield Problem(f"radius_{number}", radius, "must be a positive length", remedy)
    if not 0.0 < share <= 1.0:
        yield Problem("share", share, "must lie in (0, 1]", "1/2 is two equal bodies, share_of_softer another choice")


@kernel
def pair_scale(law, radius_i, radius_j, share=0.5):  # type: ignore[no-untyped-def]
    """Radius of the pair's equivalent body, R_i R_j/((R_i + R_j) share), over the law's; 1 for the radii that `effective` was given."""
    return radius_i * radius_j / ((radius_i + radius_j) * share * law.radius)


@kernel
def wall_scale(law, radius):  # type: ignore[no-untyped-def]
    """The same of a sphere on a rigid flat, whose share is 1: all of the overlap is the sphere's."""
    return radius / law.radius


@inlined
def pair_force(law, scale, overlap, rate, dt, state, share=0.5):  # type: ignore[no-untyped-def]
    """Force in N between two spheres whose centres are `overlap` (m) closer than the sum of their radii, and the new memory.

    `share` of the overlap is that of the body whose law it is (see `effective`): 1/2 of two equal spheres, 1 of one on a rigid flat.
    """
    part = share / scale
    force, state = dispatch.normal_force(law, overlap * part, rate * part, dt, state)
    return scale * scale * force, state


@kernel
def pair_contact_radius(law, scale, overlap, state, share=0.5):  # type: ignore[no-untyped-def]
    """Contact radius in m of the pair."""
    return scale * dispatch.contact_radius(law, share * overlap / scale, state)


@kernel
def pair_energy(law, scale, overlap, state, share=0.5):  # type: ignore[no-untyped-def]
    """Stored and dissipated energy in J of both bodies together."""
    stored, dissipated = dispatch.energy(law, share * overlap / scale, state)
    factor = scale * scale * scale / share
    return factor * stored, factor * dissipated


@kernel
def pair_stiffness_bound(law, scale, overlap, share=0.5):  # type: ignore[no-untyped-def]
    """Largest tangent stiffness in N/m of the pair, over all histories that stay at or below `overlap`."""
    return share * scale * dispatch.stiffness_bound(law, share * overlap / scale)
