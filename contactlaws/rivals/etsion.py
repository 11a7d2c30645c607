"""Etsion, Kligerman & Kadin 2005: how an elastic-plastic sphere unloads, on the loading of Kogut & Etsion 2002.

With w = d_max/d_c (Eqs. 6 and 9 as Edmans & Sinka 2020 write them; fitted by the authors for w <= 170):

    d_0/d_max = (1 - w^-0.28)(1 - w^-0.69)        F = F_max s^(1.5 w^-0.0331)        a^2 = a_max^2 s^(w^-0.12)

with s = (d - d_0)/(d_max - d_0). At w = 1 all three are Hertz's. The loading keeps its jumps (see `contactlaws.rivals.kogut_etsion`).
"""

from __future__ import annotations

from typing import NamedTuple

from contactlaws.compiled import kernel
from contactlaws.dispatch import Law, register
from contactlaws.rivals.bounds import MATERIAL, at_least
from contactlaws.rivals.kogut_etsion import (
    CHANGE,
    kogut_etsion_critical,
    kogut_etsion_loading,
    kogut_etsion_radius,
    kogut_etsion_stiffness,
    kogut_etsion_work,
)
from contactlaws.rivals.unloading import MARGIN, SAMPLES, part_left

LAST = 170.0


class Etsion(NamedTuple):
    """One body of a given material; see the module.

    >>> law = Etsion(1.0, 100.0, 0.3, 1.0)
    >>> round(etsion_recovered(law, 100.0 * kogut_etsion_critical(law)) / kogut_etsion_critical(law), 2)
    30.56
    """

    radius: float  # m
    reduced_modulus: float  # Pa; E/(1 - nu^2)
    poissons_ratio: float  # -
    yield_stress: float  # Pa


@kernel
def etsion_recovered(law, largest):  # type: ignore[no-untyped-def]
    """d_max - d_0 in m, Eq. 9."""
    limit = kogut_etsion_critical(law)
    if largest <= limit:
        return largest
    w = largest / limit
    return largest * (1.0 - (1.0 - w**-0.28) * (1.0 - w**-0.69))


@kernel
def etsion_exponent(law, largest):  # type: ignore[no-untyped-def]
    """Power of the force, Eq. 6."""
    limit = kogut_etsion_critical(law)
    return 1.5 if largest <= limit else 1.5 * (largest / limit) ** -0.0331


@kernel
def etsion_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Loading, or unloading from the largest overlap (the memory)."""
    if overlap <= 0.0:
        return 0.0, (0.0,)
    largest = max(overlap, state[0])
    force = kogut_etsion_loading(law, largest)
    if overlap < largest:
        force *= part_left(largest, etsion_recovered(law, largest), overlap) ** etsion_exponent(law, largest)
    return force, (largest,)


@kernel
def etsion_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """a^2 = a_max^2 s^(w^-0.12)."""
    if overlap <= 0.0:
        return 0.0
    largest = max(overlap, state[0])
    w = max(1.0, largest / kogut_etsion_critical(law))
    return kogut_etsion_radius(law, largest) * part_left(largest, etsion_recovered(law, largest), overlap) ** (0.5 * w**-0.12)


@kernel
def etsion_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored: F_max (d_max - d_0) s^(n + 1)/(n + 1). Dissipated: work of the loading less what can be got back."""
    largest = max(overlap, state[0])
    if largest <= 0.0:
        return 0.0, 0.0
    recovered, power = etsion_recovered(law, largest), etsion_exponent(law, largest) + 1.0
    recoverable = kogut_etsion_loading(law, largest) * recovered / power
    dissipated = 0.0 if largest <= kogut_etsion_critical(law) else kogut_etsion_work(law, largest) - recoverable
    return recoverable * part_left(largest, recovered, overlap) ** power, dissipated


@kernel
def etsion_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """The steeper of loading and start of unloading, n F/(d_max - d_0), which has its maximum at the end or at a jump."""
    top = max(overlap, 0.0)
    largest = kogut_etsion_stiffness(law, top)
    limit = kogut_etsion_critical(law)
    if top <= limit:
        return largest
    for i in range(SAMPLES + 2):
        depth = min(top, CHANGE * limit) if i > SAMPLES else limit * (top / limit) ** (i / SAMPLES)
        slope = etsion_exponent(law, depth) * kogut_etsion_loading(law, depth) / etsion_recovered(law, depth)
        largest = max(largest, MARGIN * slope)
    return largest


register(
    Law(
        "etsion",
        Etsion,
        etsion_force,
        etsion_contact_radius,
        etsion_energy,
        etsion_stiffness_bound,
        ("largest_overlap",),
        "Etsion, Kligerman & Kadin 2005, Int. J. Solids Struct. 42, 3716: unloading; loading of Kogut & Etsion 2002",
        at_least(MATERIAL),
    )
)
