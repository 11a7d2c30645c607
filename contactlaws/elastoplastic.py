"""Thornton's elastic-perfectly plastic sphere, in closed form."""

from __future__ import annotations

import math
from typing import NamedTuple

from contactlaws.compiled import kernel
from contactlaws.dispatch import Law, register


class Thornton(NamedTuple):
    """Hertz up to a limiting contact pressure, then a straight line; unloads as a flatter Hertzian body (Thornton 1997).

    Below the yield overlap d_Y = (pi p_Y/(2 E*))^2 R the law is Hertz's. Beyond it F = F_Y + pi p_Y R (d - d_Y). From the largest overlap
    d_* it unloads, and reloads, as a Hertzian body of the radius R_p = R F_Hertz(d_*)/F_*, which separates at d_p = d_* (1 - R/R_p).
    Good where the plastic zone is small against the body and the mean pressure stays near `yield_pressure`.

    >>> law = Thornton(radius=5e-6, reduced_modulus=151.47e9, yield_pressure=12.64e9)
    >>> round(thornton_yield_overlap(law) * 1e9, 2)
    85.91
    """

    radius: float  # m
    reduced_modulus: float  # Pa; E/(1 - nu^2) of the one body
    yield_pressure: float  # Pa; the limiting contact pressure, about 1.6 times the yield stress at first yield


@kernel
def thornton_yield_overlap(law):  # type: ignore[no-untyped-def]
    """First yield of the one body; of a pair of equal bodies it is twice that, as (pi p_Y/(2 E*/2))^2 R/2 says."""
    ratio = 0.5 * math.pi * law.yield_pressure / law.reduced_modulus
    return ratio * ratio * law.radius


@kernel
def hertzian_force(law, overlap):  # type: ignore[no-untyped-def]
    """The force if the body never yielded."""
    return 4.0 / 3.0 * law.reduced_modulus * math.sqrt(law.radius * overlap) * overlap


@kernel
def thornton_envelope(law, overlap):  # type: ignore[no-untyped-def]
    """Force of the first loading."""
    limit = thornton_yield_overlap(law)
    if overlap <= limit:
        return hertzian_force(law, overlap)
    return hertzian_force(law, limit) + math.pi * law.yield_pressure * law.radius * (overlap - limit)


@kernel
def thornton_recovered(law, largest):  # type: ignore[no-untyped-def]
    """Overlap d_* - d_p that is recovered on unloading from `largest`: R d_*/R_p."""
    if largest <= thornton_yield_overlap(law):
        return largest
    return largest * thornton_envelope(law, largest) / hertzian_force(law, largest)


@kernel
def thornton_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Thornton 1997; the memory is the largest overlap."""
    if overlap <= 0.0:
        return 0.0, (0.0,)
    largest = max(overlap, state[0])
    force = thornton_envelope(law, largest)
    if overlap < largest:
        recovered = thornton_recovered(law, largest)
        fraction = max(0.0, (overlap - (largest - recovered)) / recovered)
        force *= fraction * math.sqrt(fraction)
    return force, (largest,)


@kernel
def thornton_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """a^2 = R d on the envelope, R_p (d - d_p) below it; the two meet because R_p (d_* - d_p) = R d_*."""
    if overlap <= 0.0:
        return 0.0
    largest = max(overlap, state[0])
    recovered = thornton_recovered(law, largest)
    return math.sqrt(law.radius * largest * max(0.0, (overlap - (largest - recovered)) / recovered))


@kernel
def thornton_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored: 2/5 F (d - d_p), as for any Hertzian body. Dissipated: work of the first loading less what unloading gives back."""
    largest = max(overlap, state[0])
    if largest <= 0.0:
        return 0.0, 0.0
    force = thornton_envelope(law, largest)
    recovered = thornton_recovered(law, largest)
    recoverable = 0.4 * force * recovered
    fraction = max(0.0, (overlap - (largest - recovered)) / recovered)
    beyond = largest - thornton_yield_overlap(law)
    if beyond <= 0.0:
        dissipated = 0.0
    else:
        limit = largest - beyond
        at_yield = hertzian_force(law, limit)
        dissipated = 0.4 * at_yield * limit + 0.5 * (at_yield + force) * beyond - recoverable
    return recoverable * fraction * fraction * math.sqrt(fraction), dissipated


@kernel
def thornton_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """Unloading leaves the envelope with 2 E* a and a^2 = R d: the Hertzian tangent at the largest overlap, yielded or not."""
    return 2.0 * law.reduced_modulus * math.sqrt(law.radius * max(overlap, 0.0))


register(
    Law(
        "thornton",
        Thornton,
        thornton_force,
        thornton_contact_radius,
        thornton_energy,
        thornton_stiffness_bound,
        ("largest_overlap",),
        "Thornton 1997, J. Appl. Mech. 64, 383: loading line and unloading radius",
    )
)
