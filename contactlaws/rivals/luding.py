"""Luding 2008 without cohesion: linear loading, and an unloading stiffness that grows with the overlap up to a limit.

F = k1 d on the first loading, F = k2 (d - d_0) below the largest overlap, k2 = k1 + (k_p - k1) min(1, d_max/d*), d_0 = (1 - k1/k2) d_max.
d* is the overlap at which the stiffness stops growing, not that of first yield. The law says nothing of the contact radius.
"""

from __future__ import annotations

from typing import NamedTuple

from contactlaws.compiled import kernel
from contactlaws.dispatch import Law, register
from contactlaws.rivals.bounds import at_least
from contactlaws.rivals.unloading import straight_energy, straight_force, unknown_contact_radius


class Luding(NamedTuple):
    """One body; the three constants are fitted, none follows from a material.

    >>> float(luding_unloading_stiffness(Luding(1.0, 10.0, 5.0, 0.2), 0.1))
    30.0
    """

    radius: float  # m
    loading_stiffness: float  # N/m; k1
    stiffness_ratio: float  # k_p/k1 >= 1: largest unloading stiffness over the loading one
    saturation_overlap: float  # m; d*


@kernel
def luding_unloading_stiffness(law, largest):  # type: ignore[no-untyped-def]
    """k2 in N/m."""
    return law.loading_stiffness * (1.0 + (law.stiffness_ratio - 1.0) * min(1.0, largest / law.saturation_overlap))


@kernel
def luding_recovered(law, largest):  # type: ignore[no-untyped-def]
    """d_max - d_0 = k1/k2 d_max in m."""
    return law.loading_stiffness * largest / luding_unloading_stiffness(law, largest)


@kernel
def luding_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Loading, or unloading from the largest overlap (the memory)."""
    if overlap <= 0.0:
        return 0.0, (0.0,)
    largest = max(overlap, state[0])
    return straight_force(law.loading_stiffness, luding_recovered(law, largest), largest, overlap), (largest,)


@kernel
def luding_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Two triangles."""
    largest = max(overlap, state[0])
    if largest <= 0.0:
        return 0.0, 0.0
    return straight_energy(law.loading_stiffness, luding_recovered(law, largest), largest, overlap)


@kernel
def luding_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """k2 at the largest overlap."""
    return luding_unloading_stiffness(law, max(overlap, 0.0))


register(
    Law(
        "luding",
        Luding,
        luding_force,
        unknown_contact_radius,
        luding_energy,
        luding_stiffness_bound,
        ("largest_overlap",),
        "Luding 2008, Granular Matter 10, 235: linear hysteretic law, without cohesion",
        at_least({"loading_stiffness": 0.0, "stiffness_ratio": 1.0, "saturation_overlap": 0.0}),
    )
)
