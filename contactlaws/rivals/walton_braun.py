"""Walton & Braun 1986: a straight line to load, a steeper one to unload.

F = k1 d on the first loading, F = k2 (d - d_0) below the largest overlap, with k2 = r k1 + S F_max. With S = 0 the coefficient of
restitution is sqrt(k1/k2) at every speed; with S > 0 it falls with the speed. The law says nothing of the contact radius.
"""

from __future__ import annotations

from typing import NamedTuple

from contactlaws.compiled import kernel
from contactlaws.dispatch import Law, register
from contactlaws.rivals.bounds import at_least
from contactlaws.rivals.unloading import straight_energy, straight_force, unknown_contact_radius


class WaltonBraun(NamedTuple):
    """One body; the three constants are fitted, none follows from a material.

    >>> float(walton_braun_recovered(WaltonBraun(1.0, 10.0, 4.0, 0.0), 0.1))
    0.025
    """

    radius: float  # m
    loading_stiffness: float  # N/m; k1
    stiffness_ratio: float  # r >= 1: k2/k1 at vanishing force
    stiffening: float  # 1/m; S >= 0: k2 = k1 r + S F_max, with F_max = k1 d_max


@kernel
def walton_braun_unloading_stiffness(law, largest):  # type: ignore[no-untyped-def]
    """k2 in N/m."""
    return law.loading_stiffness * (law.stiffness_ratio + law.stiffening * largest)


@kernel
def walton_braun_recovered(law, largest):  # type: ignore[no-untyped-def]
    """d_max - d_0 = F_max/k2 in m."""
    return law.loading_stiffness * largest / walton_braun_unloading_stiffness(law, largest)


@kernel
def walton_braun_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Loading, or unloading from the largest overlap (the memory)."""
    if overlap <= 0.0:
        return 0.0, (0.0,)
    largest = max(overlap, state[0])
    return straight_force(law.loading_stiffness, walton_braun_recovered(law, largest), largest, overlap), (largest,)


@kernel
def walton_braun_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Two triangles."""
    largest = max(overlap, state[0])
    if largest <= 0.0:
        return 0.0, 0.0
    return straight_energy(law.loading_stiffness, walton_braun_recovered(law, largest), largest, overlap)


@kernel
def walton_braun_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """k2 at the largest overlap."""
    return walton_braun_unloading_stiffness(law, max(overlap, 0.0))


register(
    Law(
        "walton_braun",
        WaltonBraun,
        walton_braun_force,
        unknown_contact_radius,
        walton_braun_energy,
        walton_braun_stiffness_bound,
        ("largest_overlap",),
        "Walton & Braun 1986, J. Rheol. 30, 949: unloading stiffness constant or growing with the largest force",
        at_least({"loading_stiffness": 0.0, "stiffness_ratio": 1.0}),
    )
)
