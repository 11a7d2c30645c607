"""Becker & Kamlah 2021 for spheres: Thornton's law with a contact pressure that grows from first yield to full plasticity.

One body on a flat, c^2 = R d the squared contact radius, c_Y the same at first yield, where the largest pressure is p_Y = 1.6 Y:

    F = F_Y + pi lambda Y (c^2 - c_Y^2)                                                        Eqs. 25, 31
    lambda = l - (l - 1.6) [(e c_Y - c)/((e - 1) c_Y)]^n for c <= e c_Y, lambda = l beyond     Eq. 28, l = lambda_max, e = epsilon_max

Unloading (Eqs. 43-49, with d - d_p where Eq. 42 prints d): with F_t = F_Y + pi p_Y (c^2 - c_Y^2), Thornton's force at the largest overlap,
d_max - d_p = d_max F_t/F_Hertz and F = F_max s^1.5. The Hertzian body that unloads so has beta = F_max/F_t times the contact radius of the
loading: the contact radius jumps when unloading starts, as the authors say, and `contact_radius` shows it.

Eq. 54 gives l = 2.751, e = 2.905 for equal spheres of the authors' one material (NMC, E/Y = 18); they depend strongly on E/Y. An elliptical
contact follows the same formulas with another radius and modulus: `contactlaws.rivals.becker_kamlah_ellipsoid`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from contactlaws.compiled import kernel
from contactlaws.dispatch import Law, register
from contactlaws.rivals.bounds import MATERIAL, at_least
from contactlaws.rivals.unloading import MARGIN, POINTS, SAMPLES, WEIGHTS, hertz, part_left

#: largest pressure over yield stress at first yield
FIRST = 1.6
#: Eq. 53: m, o, p of lambda_max and s, t, u of epsilon_max
PRESSURE_CONSTANTS, RADIUS_CONSTANTS = (1.05, -4.62, 2.42), (8.19, -6.14, 1.14)
#: n; section 4, below Eq. 51
EXPONENT = 1.8


def levelling(relative_radius: float, scale: float, rate: float, limit: float) -> float:
    """Eq. 52: what lambda_max and epsilon_max are at R_e/(r_I + r_J)."""
    return scale * math.exp(rate * relative_radius) + limit


#: Eq. 54 for equal spheres, R_e/r = 1/4
PUBLISHED = {
    "pressure_ratio": levelling(0.25, *PRESSURE_CONSTANTS),
    "radius_ratio": levelling(0.25, *RADIUS_CONSTANTS),
    "exponent": EXPONENT,
}
#: overlap over radius to which the authors' curves went
LAST = 0.15
_PANELS = 6


class BeckerKamlah(NamedTuple):
    """One body; the constants are those of Eq. 54 or fitted.

    >>> law = BeckerKamlah(1.0, 151.47, 7.9, **PUBLISHED)
    >>> limit = becker_kamlah_yield_overlap(law)
    >>> round(becker_kamlah_loading(law, 50.0 * limit) / becker_kamlah_loading(law, limit))
    127
    """

    radius: float  # m
    reduced_modulus: float  # Pa; E/(1 - nu^2)
    yield_stress: float  # Pa
    pressure_ratio: float  # lambda_max > 1.6
    radius_ratio: float  # epsilon_max > 1
    exponent: float  # n >= 1


@kernel
def becker_kamlah_yield_overlap(law):  # type: ignore[no-untyped-def]
    """First yield of the one body, (pi p_Y/(2 E*))^2 R."""
    ratio = 0.5 * math.pi * FIRST * law.yield_stress / law.reduced_modulus
    return ratio * ratio * law.radius


@kernel
def becker_kamlah_pressure(law, ratio):  # type: ignore[no-untyped-def]
    """lambda at c = `ratio` c_Y."""
    behind = max(0.0, (law.radius_ratio - ratio) / (law.radius_ratio - 1.0))
    return law.pressure_ratio - (law.pressure_ratio - FIRST) * behind**law.exponent


@kernel
def becker_kamlah_above_yield(law, overlap, limit, pressure):  # type: ignore[no-untyped-def]
    """F_Y + pi lambda Y (c^2 - c_Y^2) in N."""
    plastic = math.pi * pressure * law.yield_stress * law.radius * (overlap - limit)
    return hertz(law.reduced_modulus, law.radius, limit) + plastic


@kernel
def becker_kamlah_loading(law, overlap):  # type: ignore[no-untyped-def]
    """Force in N of the first loading."""
    limit = becker_kamlah_yield_overlap(law)
    if overlap <= limit:
        return hertz(law.reduced_modulus, law.radius, overlap)
    return becker_kamlah_above_yield(law, overlap, limit, becker_kamlah_pressure(law, math.sqrt(overlap / limit)))


@kernel
def becker_kamlah_work(law, overlap):  # type: ignore[no-untyped-def]
    """Integral of the loading in J: Gauss quadrature in c up to full plasticity, where c is linear in the quadrature's variable."""
    limit = becker_kamlah_yield_overlap(law)
    first = min(overlap, limit)
    work = 0.4 * hertz(law.reduced_modulus, law.radius, first) * first
    if overlap <= limit:
        return work
    full = limit * law.radius_ratio * law.radius_ratio
    end = min(overlap, full)
    span = math.sqrt(end / limit) - 1.0
    for i in range(_PANELS):
        for j in range(POINTS.size):  # panels crowd towards full plasticity, where the pressure ends as a power
            u = (i + POINTS[j]) / _PANELS
            ratio = 1.0 + span * (1.0 - (1.0 - u) ** 3)
            width = WEIGHTS[j] / _PANELS * span * 3.0 * (1.0 - u) ** 2 * 2.0 * ratio * limit
            work += width * becker_kamlah_loading(law, limit * ratio * ratio)
    if overlap > full:
        work += 0.5 * (becker_kamlah_loading(law, full) + becker_kamlah_loading(law, overlap)) * (overlap - full)
    return work


@kernel
def becker_kamlah_recovered(law, largest):  # type: ignore[no-untyped-def]
    """d_max - d_p in m: Thornton's, for the pressure at first yield."""
    limit = becker_kamlah_yield_overlap(law)
    if largest <= limit:
        return largest
    return largest * becker_kamlah_above_yield(law, largest, limit, FIRST) / hertz(law.reduced_modulus, law.radius, largest)


@kernel
def becker_kamlah_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Loading, or Hertzian unloading from the largest overlap (the memory)."""
    if overlap <= 0.0:
        return 0.0, (0.0,)
    largest = max(overlap, state[0])
    force = becker_kamlah_loading(law, largest)
    if overlap < largest:
        left = part_left(largest, becker_kamlah_recovered(law, largest), overlap)
        force *= left * math.sqrt(left)
    return force, (largest,)


@kernel
def becker_kamlah_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """c on the loading; on the unloading that of the Hertzian body, larger by beta = F_max/F_t from the start."""
    if overlap <= 0.0:
        return 0.0
    largest = max(overlap, state[0])
    limit = becker_kamlah_yield_overlap(law)
    if overlap >= largest or largest <= limit:
        return math.sqrt(law.radius * overlap)
    beta = becker_kamlah_loading(law, largest) / becker_kamlah_above_yield(law, largest, limit, FIRST)
    return beta * math.sqrt(law.radius * largest * part_left(largest, becker_kamlah_recovered(law, largest), overlap))


@kernel
def becker_kamlah_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored: 2/5 F_max (d_max - d_p) s^2.5. Dissipated: work of the loading less what can be got back."""
    largest = max(overlap, state[0])
    if largest <= 0.0:
        return 0.0, 0.0
    recovered = becker_kamlah_recovered(law, largest)
    recoverable = 0.4 * becker_kamlah_loading(law, largest) * recovered
    left = part_left(largest, recovered, overlap)
    dissipated = 0.0 if largest <= becker_kamlah_yield_overlap(law) else becker_kamlah_work(law, largest) - recoverable
    return recoverable * left * left * math.sqrt(left), dissipated


@kernel
def becker_kamlah_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """Unloading starts with beta 2 E* c; the loading is no steeper than pi Y R (lambda + (c^2 - c_Y^2) dlambda/d(c^2))."""
    top = max(overlap, 0.0)
    limit = becker_kamlah_yield_overlap(law)
    largest = 2.0 * law.reduced_modulus * math.sqrt(law.radius * min(top, limit))
    if top <= limit:
        return largest
    for i in range(SAMPLES + 1):
        depth = limit * (top / limit) ** (i / SAMPLES)
        ratio = math.sqrt(depth / limit)
        behind = max(0.0, (law.radius_ratio - ratio) / (law.radius_ratio - 1.0))
        slope = (law.pressure_ratio - FIRST) * law.exponent * behind ** (law.exponent - 1.0) / (law.radius_ratio - 1.0)
        growth = becker_kamlah_pressure(law, ratio) + 0.5 * slope * (ratio * ratio - 1.0) / ratio
        loading = math.pi * law.yield_stress * law.radius * growth
        unloading = 1.5 * becker_kamlah_loading(law, depth) / becker_kamlah_recovered(law, depth)
        largest = max(largest, MARGIN * max(loading, unloading))
    return largest


register(
    Law(
        "becker_kamlah",
        BeckerKamlah,
        becker_kamlah_force,
        becker_kamlah_contact_radius,
        becker_kamlah_energy,
        becker_kamlah_stiffness_bound,
        ("largest_overlap",),
        "Becker & Kamlah 2021, sphere limit: Eqs. 25-31 and 43-49, with d - d_p in Eq. 42 and R_e in Eq. 38",
        at_least({**MATERIAL, "pressure_ratio": FIRST, "radius_ratio": 1.0 + 1e-9, "exponent": 1.0}),
    )
)
