"""EEPA (Thakur et al. 2014) without adhesion: a power of the overlap to load, the same power with a steeper factor to unload.

F = k1 d^n on the first loading, F = k2 (d^n - d_p^n) below the largest overlap, d_p = (1 - k1/k2)^(1/n) d_max. Written with k1 R^n, the
force at an overlap of one radius. The law says nothing of the contact radius.
"""

from __future__ import annotations

from typing import NamedTuple

from contactlaws.compiled import kernel
from contactlaws.dispatch import Law, register
from contactlaws.rivals.bounds import at_least
from contactlaws.rivals.unloading import unknown_contact_radius


class Eepa(NamedTuple):
    """One body; the three constants are fitted, none follows from a material.

    >>> round(float(eepa_separation(Eepa(1.0, 10.0, 4.0, 1.5), 0.1)), 5)
    0.08255
    """

    radius: float  # m
    force_at_radius: float  # N; k1 R^n
    stiffness_ratio: float  # k2/k1 > 1
    exponent: float  # n >= 1


@kernel
def eepa_separation(law, largest):  # type: ignore[no-untyped-def]
    """d_p in m."""
    return largest * (1.0 - 1.0 / law.stiffness_ratio) ** (1.0 / law.exponent)


@kernel
def eepa_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Loading, or unloading from the largest overlap (the memory)."""
    if overlap <= 0.0:
        return 0.0, (0.0,)
    largest = max(overlap, state[0])
    top = law.force_at_radius * (largest / law.radius) ** law.exponent
    if overlap >= largest:
        return top, (largest,)
    drop = 1.0 - (overlap / largest) ** law.exponent
    return max(0.0, top * (1.0 - law.stiffness_ratio * drop)), (largest,)


@kernel
def eepa_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored: integral of k2 (x^n - d_p^n) from d_p to d. Dissipated: k1 d_max^(n + 1)/(n + 1) less what can be got back."""
    largest = max(overlap, state[0])
    if largest <= 0.0:
        return 0.0, 0.0
    power = law.exponent + 1.0
    unit = law.force_at_radius * (largest / law.radius) ** law.exponent * largest  # k1 d_max^(n + 1)
    end = eepa_separation(law, largest) / largest
    now = min(1.0, max(end, overlap / largest))
    recoverable = law.stiffness_ratio * ((1.0 - end**power) / power - end**law.exponent * (1.0 - end))
    stored = law.stiffness_ratio * ((now**power - end**power) / power - end**law.exponent * (now - end))
    return unit * stored, unit * max(0.0, 1.0 / power - recoverable)


@kernel
def eepa_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """n k2 d^(n - 1) at the largest overlap."""
    depth = max(overlap, 0.0) / law.radius
    if depth <= 0.0:
        return 0.0
    return law.exponent * law.stiffness_ratio * law.force_at_radius * depth ** (law.exponent - 1.0) / law.radius


register(
    Law(
        "eepa",
        Eepa,
        eepa_force,
        unknown_contact_radius,
        eepa_energy,
        eepa_stiffness_bound,
        ("largest_overlap",),
        "Thakur et al. 2014, Granular Matter 16, 383: EEPA, without adhesion",
        at_least({"force_at_radius": 0.0, "stiffness_ratio": 1.0, "exponent": 1.0}),
    )
)
