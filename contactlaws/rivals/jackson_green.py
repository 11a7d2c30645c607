"""Jackson & Green 2005: force and contact area of an elastic-perfectly plastic hemisphere on a rigid flat, with a hardness that falls.

Symbols: w = d/d_c, d_c = (pi C Y/(2 E*))^2 R, C = 1.295 exp(0.736 nu); F_c and A_c Hertz's force and area at d_c; e_Y = Y/E*.

    Hertz for w <= 1.9; beyond
    A/A_c = w (w/1.9)^B with B = 0.14 exp(23 e_Y)
    F/F_c = exp(-w^(5/12)/4) w^1.5 + 4 H/(C Y) (1 - exp(-w^(5/9)/25)) w
    H/Y = 2.84 - 0.92 (1 - cos(pi a/R))

Fitted by the authors to finite elements up to a/R = 0.41; the pieces meet at w = 1.9 to half a per cent, a jump that is kept.

The paper says nothing of unloading. Here, as in Jackson, Green & Marghitu 2010 after Etsion et al., the body unloads as the Hertzian one
that has the same force and contact radius: d_max - d_0 = 3 F/(4 E* a).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from contactlaws.compiled import kernel
from contactlaws.dispatch import Law, register
from contactlaws.rivals.bounds import MATERIAL, at_least
from contactlaws.rivals.unloading import MARGIN, POINTS, SAMPLES, WEIGHTS, hertz, hertzian_recovery, part_left

ELASTIC, LARGEST_RADIUS = 1.9, 0.41
_PANELS = 12


class JacksonGreen(NamedTuple):
    """One body of a given material; see the module.

    >>> law = JacksonGreen(1.0, 1000.0, 0.3, 1.0)
    >>> limit = jackson_green_critical(law)
    >>> round(jackson_green_loading(law, 50.0 * limit) / hertz(law.reduced_modulus, law.radius, limit))
    203
    """

    radius: float  # m
    reduced_modulus: float  # Pa; E/(1 - nu^2)
    poissons_ratio: float  # -
    yield_stress: float  # Pa


@kernel
def jackson_green_critical(law):  # type: ignore[no-untyped-def]
    """d_c in m."""
    ratio = 0.5 * math.pi * 1.295 * math.exp(0.736 * law.poissons_ratio) * law.yield_stress / law.reduced_modulus
    return ratio * ratio * law.radius


@kernel
def jackson_green_radius(law, overlap):  # type: ignore[no-untyped-def]
    """Contact radius in m on the first loading."""
    limit = jackson_green_critical(law)
    area = law.radius * overlap
    if overlap > ELASTIC * limit:
        area *= (overlap / (ELASTIC * limit)) ** (0.14 * math.exp(23.0 * law.yield_stress / law.reduced_modulus))
    return math.sqrt(area)


@kernel
def jackson_green_loading(law, overlap):  # type: ignore[no-untyped-def]
    """Force in N of the first loading."""
    limit = jackson_green_critical(law)
    if overlap <= ELASTIC * limit:
        return hertz(law.reduced_modulus, law.radius, overlap)
    w = overlap / limit
    hardness = 2.84 - 0.92 * (1.0 - math.cos(math.pi * jackson_green_radius(law, overlap) / law.radius))
    plastic = 4.0 * hardness / (1.295 * math.exp(0.736 * law.poissons_ratio)) * (1.0 - math.exp(-(w ** (5.0 / 9.0)) / 25.0)) * w
    return hertz(law.reduced_modulus, law.radius, limit) * (math.exp(-0.25 * w ** (5.0 / 12.0)) * w * math.sqrt(w) + plastic)


@kernel
def jackson_green_work(law, overlap):  # type: ignore[no-untyped-def]
    """Integral of the loading in J: closed while elastic, then Gauss quadrature in the logarithm of the overlap."""
    limit = ELASTIC * jackson_green_critical(law)
    first = min(overlap, limit)
    work = 0.4 * hertz(law.reduced_modulus, law.radius, first) * first
    if overlap > limit:
        panel = math.log(overlap / limit) / _PANELS
        for i in range(_PANELS):
            for j in range(POINTS.size):
                depth = limit * math.exp(panel * (i + POINTS[j]))
                work += panel * WEIGHTS[j] * depth * jackson_green_loading(law, depth)
    return work


@kernel
def jackson_green_recovered(law, largest):  # type: ignore[no-untyped-def]
    """d_max - d_0 in m."""
    if largest <= ELASTIC * jackson_green_critical(law):
        return largest
    return hertzian_recovery(law.reduced_modulus, jackson_green_loading(law, largest), jackson_green_radius(law, largest), largest)


@kernel
def jackson_green_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Loading, or Hertzian unloading from the largest overlap (the memory)."""
    if overlap <= 0.0:
        return 0.0, (0.0,)
    largest = max(overlap, state[0])
    force = jackson_green_loading(law, largest)
    if overlap < largest:
        left = part_left(largest, jackson_green_recovered(law, largest), overlap)
        force *= left * math.sqrt(left)
    return force, (largest,)


@kernel
def jackson_green_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """As published on the loading; Hertzian below."""
    if overlap <= 0.0:
        return 0.0
    largest = max(overlap, state[0])
    return jackson_green_radius(law, largest) * math.sqrt(part_left(largest, jackson_green_recovered(law, largest), overlap))


@kernel
def jackson_green_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored: 2/5 F_max (d_max - d_0) s^2.5. Dissipated: work of the loading less what can be got back."""
    largest = max(overlap, state[0])
    if largest <= 0.0:
        return 0.0, 0.0
    recovered = jackson_green_recovered(law, largest)
    recoverable = 0.4 * jackson_green_loading(law, largest) * recovered
    left = part_left(largest, recovered, overlap)
    dissipated = 0.0 if largest <= ELASTIC * jackson_green_critical(law) else jackson_green_work(law, largest) - recoverable
    return recoverable * left * left * math.sqrt(left), dissipated


@kernel
def jackson_green_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """The steepest of loading (by differences) and start of unloading, at 64 overlaps beyond first yield."""
    top = max(overlap, 0.0)
    limit = ELASTIC * jackson_green_critical(law)
    largest = 2.0 * law.reduced_modulus * math.sqrt(law.radius * min(top, limit))
    if top <= limit:
        return largest
    for i in range(SAMPLES + 1):
        depth = limit * (top / limit) ** (i / SAMPLES) * (1.0 + 1e-6)
        force = jackson_green_loading(law, depth)
        loading = (jackson_green_loading(law, depth * (1.0 + 1e-6)) - force) / (1e-6 * depth)
        largest = max(largest, MARGIN * max(loading, 1.5 * force / jackson_green_recovered(law, depth)))
    return largest


register(
    Law(
        "jackson_green",
        JacksonGreen,
        jackson_green_force,
        jackson_green_contact_radius,
        jackson_green_energy,
        jackson_green_stiffness_bound,
        ("largest_overlap",),
        "Jackson & Green 2005, J. Tribol. 127, 343: force and area; Hertzian unloading from the same force and radius",
        at_least(MATERIAL),
    )
)
