"""Kogut & Etsion 2002: force and contact area of an elastic-perfectly plastic sphere on a rigid flat, as powers of the overlap.

Symbols: w overlap over the critical overlap d_c = (pi K H/(2 E*))^2 R, with the hardness H = 2.8 Y and K = 0.454 + 0.41 nu; F_c and A_c
Hertz's force and area at d_c. Fitted by the authors to finite elements for 1 <= w <= 110:

    F/F_c = 1.03 w^1.425, A/A_c = 0.93 w^1.136 for 1 <= w <= 6        F/F_c = 1.40 w^1.263, A/A_c = 0.94 w^1.146 beyond

The pieces do not meet: the force jumps by 3 % at w = 1 and by 1.7 % at w = 6, and it exceeds Hertz's up to w = 1.48, so that a contact
which turns back there gives up to 3 % more than it took. This is kept as published.

The paper says nothing of unloading. Here the body unloads from any state as the Hertzian one that has the same force and contact radius:
d_max - d_0 = 3 F/(4 E* a), F ~ (d - d_0)^1.5 (see `contactlaws.rivals.etsion` for the unloading that was published later).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from contactlaws.compiled import kernel
from contactlaws.dispatch import Law, register
from contactlaws.rivals.bounds import MATERIAL, at_least
from contactlaws.rivals.unloading import hertz, hertzian_recovery, part_left

#: factor and power of force and area in the first regime, the overlap where it ends, factor and power in the second
FORCE_1, POWER_1, AREA_1, AREA_POWER_1 = 1.03, 1.425, 0.93, 1.136
CHANGE, LAST = 6.0, 110.0
FORCE_2, POWER_2, AREA_2, AREA_POWER_2 = 1.40, 1.263, 0.94, 1.146


class KogutEtsion(NamedTuple):
    """One body of a given material; see the module.

    >>> law = KogutEtsion(1.0, 100.0, 0.3, 1.0)
    >>> limit = kogut_etsion_critical(law)
    >>> round(kogut_etsion_loading(law, 50.0 * limit) / kogut_etsion_loading(law, limit), 1)
    195.9
    """

    radius: float  # m
    reduced_modulus: float  # Pa; E/(1 - nu^2)
    poissons_ratio: float  # -
    yield_stress: float  # Pa


@kernel
def kogut_etsion_critical(law):  # type: ignore[no-untyped-def]
    """d_c in m."""
    pressure = 2.8 * law.yield_stress * (0.454 + 0.41 * law.poissons_ratio)
    ratio = 0.5 * math.pi * pressure / law.reduced_modulus
    return ratio * ratio * law.radius


@kernel
def kogut_etsion_loading(law, overlap):  # type: ignore[no-untyped-def]
    """Force in N of the first loading."""
    limit = kogut_etsion_critical(law)
    if overlap <= limit:
        return hertz(law.reduced_modulus, law.radius, overlap)
    w = overlap / limit
    ratio = FORCE_1 * w**POWER_1 if w <= CHANGE else FORCE_2 * w**POWER_2
    return hertz(law.reduced_modulus, law.radius, limit) * ratio


@kernel
def kogut_etsion_radius(law, overlap):  # type: ignore[no-untyped-def]
    """Contact radius in m on the first loading; A_c = pi R d_c."""
    limit = kogut_etsion_critical(law)
    if overlap <= limit:
        return math.sqrt(law.radius * overlap)
    w = overlap / limit
    ratio = AREA_1 * w**AREA_POWER_1 if w <= CHANGE else AREA_2 * w**AREA_POWER_2
    return math.sqrt(law.radius * limit * ratio)


@kernel
def kogut_etsion_work(law, overlap):  # type: ignore[no-untyped-def]
    """Integral of the loading in J."""
    limit = kogut_etsion_critical(law)
    if overlap <= limit:
        return 0.4 * hertz(law.reduced_modulus, law.radius, overlap) * overlap
    w = overlap / limit
    first = min(w, CHANGE)
    work = 0.4 + FORCE_1 / (POWER_1 + 1.0) * (first ** (POWER_1 + 1.0) - 1.0)
    if w > CHANGE:
        work += FORCE_2 / (POWER_2 + 1.0) * (w ** (POWER_2 + 1.0) - CHANGE ** (POWER_2 + 1.0))
    return work * hertz(law.reduced_modulus, law.radius, limit) * limit


@kernel
def kogut_etsion_stiffness(law, overlap):  # type: ignore[no-untyped-def]
    """Largest tangent in N/m of the pieces of the loading up to `overlap`; their jumps have none."""
    limit = kogut_etsion_critical(law)
    at_yield = 2.0 * law.reduced_modulus * math.sqrt(law.radius * min(overlap, limit))
    if overlap <= limit:
        return at_yield
    w = overlap / limit
    unit = hertz(law.reduced_modulus, law.radius, limit) / limit
    first = FORCE_1 * POWER_1 * min(w, CHANGE) ** (POWER_1 - 1.0)
    second = FORCE_2 * POWER_2 * w ** (POWER_2 - 1.0) if w > CHANGE else 0.0
    return max(at_yield, unit * max(first, second))


@kernel
def kogut_etsion_recovered(law, largest):  # type: ignore[no-untyped-def]
    """d_max - d_0 in m."""
    if largest <= kogut_etsion_critical(law):
        return largest
    return hertzian_recovery(law.reduced_modulus, kogut_etsion_loading(law, largest), kogut_etsion_radius(law, largest), largest)


@kernel
def kogut_etsion_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Loading, or Hertzian unloading from the largest overlap (the memory)."""
    if overlap <= 0.0:
        return 0.0, (0.0,)
    largest = max(overlap, state[0])
    force = kogut_etsion_loading(law, largest)
    if overlap < largest:
        left = part_left(largest, kogut_etsion_recovered(law, largest), overlap)
        force *= left * math.sqrt(left)
    return force, (largest,)


@kernel
def kogut_etsion_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """As published on the loading; Hertzian below."""
    if overlap <= 0.0:
        return 0.0
    largest = max(overlap, state[0])
    return kogut_etsion_radius(law, largest) * math.sqrt(part_left(largest, kogut_etsion_recovered(law, largest), overlap))


@kernel
def kogut_etsion_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored: 2/5 F_max (d_max - d_0) s^2.5. Dissipated: work of the loading less what can be got back; negative just past first yield."""
    largest = max(overlap, state[0])
    if largest <= 0.0:
        return 0.0, 0.0
    recovered = kogut_etsion_recovered(law, largest)
    recoverable = 0.4 * kogut_etsion_loading(law, largest) * recovered
    left = part_left(largest, recovered, overlap)
    dissipated = 0.0 if largest <= kogut_etsion_critical(law) else kogut_etsion_work(law, largest) - recoverable
    return recoverable * left * left * math.sqrt(left), dissipated


@kernel
def kogut_etsion_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """Unloading starts with 1.5 F/(d_max - d_0), which is 2 E* a but where all is recovered."""
    top = max(overlap, 0.0)
    if top <= 0.0:
        return 0.0
    limit = kogut_etsion_critical(law)
    unloading = 2.0 * law.reduced_modulus * kogut_etsion_radius(law, top)
    near_yield = min(top, CHANGE * limit)  # somewhere here 3 F/(4 E* a) may exceed the overlap, and 1.5 F/d is steeper than 2 E* a
    hertzian = 1.5 * FORCE_1 * hertz(law.reduced_modulus, law.radius, near_yield) / near_yield
    return max(kogut_etsion_stiffness(law, top), unloading, hertzian if top > limit else 0.0)


register(
    Law(
        "kogut_etsion",
        KogutEtsion,
        kogut_etsion_force,
        kogut_etsion_contact_radius,
        kogut_etsion_energy,
        kogut_etsion_stiffness_bound,
        ("largest_overlap",),
        "Kogut & Etsion 2002, J. Appl. Mech. 69, 657: force and area; Hertzian unloading from the same force and radius",
        at_least(MATERIAL),
    )
)
