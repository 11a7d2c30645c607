"""An elastic-perfectly plastic sphere up to large deformation: a fitted loading branch, and the unloading of Edmans & Sinka 2020.

Symbols: D overlap over radius, D_c the same at first yield, E Young's modulus over yield stress, nu Poisson's ratio.

Loading. Exactly elastic (`finite_size_force`) up to D_c, then F = F_el/[1 + (b (sqrt(D/D_c) - 1) exp(-q D - r D^2))^m]^(1/m): smooth at
first yield for m > 1; far beyond it proportional to the overlap, as plastic indentation is, with a factor for the flow of the whole body
at large overlap.

Unloading. Eqs. 2-4 of the paper: F = F_max s^alpha with s = 1 - (d_max - d) rho/R and rho = 1/D + phi E (g1 D + g2 D^-g3 + g4 nu). Eq. 5
gives D_c; as printed it has its two coefficients swapped, and its published constants may belong to one of three readings (`FIRST_YIELD`).
At first yield alpha is the exponent that gives back exactly the elastic energy; from there it goes with phi to 1 + (alpha_0 - 1) exp(-k D).

Contact radius. Loading: from the elastic to a plastic area as the force falls behind the elastic one. Unloading: (a/a_max)^2 = 1 - (1 -
s)^(1 + phi), Hertz's where elastic and the flat punch's of Mesarovic & Johnson 2000 where plastic.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contactlaws.compiled import kernel
from contactlaws.dispatch import Law, register
from contactlaws.elastic import (
    finite_size_area,
    finite_size_energy,
    finite_size_force,
    finite_size_stiffness,
    largest_finite_size_stiffness,
)

#: D_c = (2.8 pi (k0 + k1 nu)(1 - nu^2))^n / (2 E)^2: k0, k1, n of each reading of Eq. 5
FIRST_YIELD = {
    "corrected": (0.454, 0.41, 2.0),  # Chang, Etsion & Bogy: within 2 % of the exact pressure at first yield
    "printed": (0.41, 0.454, 2.0),
    "unsquared": (0.41, 0.454, 1.0),  # gives the 366 that the paper quotes for E = 200, D = 0.01
}
#: Table 1 of the paper
PUBLISHED = (2.9932, 0.1206, 0.4865, 0.2563, 0.3429)
#: for integrals of the loading branch: 12 panels of 8 points leave less than 1e-12 of the work
_NODES, _SHARES = np.polynomial.legendre.leggauss(8)
_PANELS = 12


class EdmansSinka(NamedTuple):
    """One body of a given material; see the module for the formulas. Good for overlaps up to half the radius, as far as its curves went."""

    radius: float  # m
    reduced_modulus: float  # Pa; E/(1 - nu^2)
    poissons_ratio: float  # -
    yield_stress: float  # Pa
    force_1: float  # elastic force, as in HertzFiniteSize
    force_2: float
    force_3: float
    area_1: float  # elastic contact area, as in HertzFiniteSize
    area_2: float
    flow: float  # b: how far the force falls behind the elastic one
    flow_decay: float  # q: how a finite body differs from indentation
    flow_decay_2: float  # r
    flow_sharpness: float  # m > 1: how fast
    plastic_area: float  # c0: a^2 = c0 R d exp(-c1 D) far beyond yield
    plastic_area_decay: float  # c1
    area_onset: float  # N: a^2 = A_el + (A_pl - A_el)(1 - F/F_el)^N
    exponent: float  # alpha_0 > 1: unloading exponent far beyond yield, for small overlap
    exponent_decay: float  # k >= 0: how it falls towards 1 with the overlap
    yield_factor: float  # k0 of FIRST_YIELD
    yield_factor_slope: float  # k1
    yield_power: float  # n
    gamma_1: float
    gamma_2: float
    gamma_3: float
    gamma_4: float
    gamma_5: float


@kernel
def first_yield(law):  # type: ignore[no-untyped-def]
    """D_c, Eq. 5 in the reading that the record carries."""
    nu = law.poissons_ratio
    pressure = 2.8 * math.pi * (law.yield_factor + law.yield_factor_slope * nu) * (1.0 - nu * nu)
    twice = 2.0 * law.reduced_modulus * (1.0 - nu * nu) / law.yield_stress
    return pressure**law.yield_power / (twice * twice)


@kernel
def plastic_part(law, depth, limit):  # type: ignore[no-untyped-def]
    """phi, Eq. 4: 0 up to first yield, towards 1 far beyond it."""
    if depth <= limit:
        return 0.0
    return 1.0 - limit / (law.gamma_5 * depth + (1.0 - law.gamma_5) * limit)


@kernel
def loading_ratio(law, depth, limit):  # type: ignore[no-untyped-def]
    """Force on the loading branch over the elastic force."""
    if depth <= limit:
        return 1.0
    behind = law.flow * (math.sqrt(depth / limit) - 1.0) * math.exp(-depth * (law.flow_decay + law.flow_decay_2 * depth))
    sharpness = law.flow_sharpness
    if behind > 1.0:  # the same formula, which does not overflow
        return (1.0 + behind**-sharpness) ** (-1.0 / sharpness) / behind
    return (1.0 + behind**sharpness) ** (-1.0 / sharpness)


@kernel
def loading_force(law, depth, limit):  # type: ignore[no-untyped-def]
    """Force in N on the loading branch."""
    return finite_size_force(law, depth * law.radius) * loading_ratio(law, depth, limit)


@kernel
def recovered_depth(law, depth, limit):  # type: ignore[no-untyped-def]
    """1/rho, Eqs. 1 and 3: the part of the overlap (over the radius) that unloading from `depth` gives back."""
    phi = plastic_part(law, depth, limit)
    stiffness = law.reduced_modulus * (1.0 - law.poissons_ratio**2) / law.yield_stress
    return 1.0 / (
        1.0 / depth + phi * stiffness * (law.gamma_1 * depth + law.gamma_2 * depth**-law.gamma_3 + law.gamma_4 * law.poissons_ratio)
    )


@kernel
def unloading_exponent(law, depth, limit):  # type: ignore[no-untyped-def]
    """alpha: at first yield F d/alpha' is the elastic energy for alpha' = alpha + 1."""
    overlap = limit * law.radius
    elastic = finite_size_force(law, overlap) * overlap / finite_size_energy(law, overlap) - 1.0
    plastic = 1.0 + (law.exponent - 1.0) * math.exp(-law.exponent_decay * depth)
    return elastic + (plastic - elastic) * plastic_part(law, depth, limit)


@kernel
def loading_work(law, depth, limit):  # type: ignore[no-untyped-def]
    """Work in J of the loading to `depth`: closed up to first yield, then Gauss quadrature in v with sqrt(D/D_c) = 1 + v^2."""
    work = finite_size_energy(law, min(depth, limit) * law.radius)
    if depth <= limit:
        return work
    panel = math.sqrt(math.sqrt(depth / limit) - 1.0) / _PANELS
    for i in range(_PANELS):
        for j in range(_NODES.size):
            v = panel * (i + 0.5 * (1.0 + _NODES[j]))
            root = 1.0 + v * v
            width = 0.5 * panel * _SHARES[j] * 4.0 * v * root * limit * law.radius
            work += width * loading_force(law, limit * root * root, limit)
    return work


@kernel
def edmans_sinka_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Loading branch, or unloading from the largest overlap (the memory)."""
    if overlap <= 0.0:
        return 0.0, (0.0,)
    largest = max(overlap, state[0])
    limit = first_yield(law)
    top = largest / law.radius
    if overlap >= largest or top <= limit:
        return loading_force(law, overlap / law.radius, limit), (largest,)
    left = 1.0 - (top - overlap / law.radius) / recovered_depth(law, top, limit)
    if left <= 0.0:
        return 0.0, (largest,)
    return loading_force(law, top, limit) * left ** unloading_exponent(law, top, limit), (largest,)


@kernel
def edmans_sinka_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """See the module; elastic up to first yield."""
    if overlap <= 0.0:
        return 0.0
    largest = max(overlap, state[0])
    limit = first_yield(law)
    top = largest / law.radius
    if top <= limit:
        return math.sqrt(finite_size_area(law, overlap))
    elastic = finite_size_area(law, largest)
    plastic = law.plastic_area * law.radius * largest * math.exp(-law.plastic_area_decay * top)
    area = elastic + (plastic - elastic) * (1.0 - loading_ratio(law, top, limit)) ** law.area_onset
    unloaded = min(1.0, (top - overlap / law.radius) / recovered_depth(law, top, limit))
    return math.sqrt(max(0.0, area * (1.0 - unloaded ** (1.0 + plastic_part(law, top, limit)))))


@kernel
def edmans_sinka_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored: what unloading gives back, F_max/(rho (alpha + 1)) s^(alpha + 1). Dissipated: work of the loading less all that can be got
    back.
    """
    largest = max(overlap, state[0])
    if largest <= 0.0:
        return 0.0, 0.0
    limit = first_yield(law)
    top = largest / law.radius
    if top <= limit:
        return finite_size_energy(law, max(overlap, 0.0)), 0.0
    recovered = recovered_depth(law, top, limit)
    power = unloading_exponent(law, top, limit) + 1.0
    recoverable = loading_force(law, top, limit) * recovered * law.radius / power
    left = max(0.0, 1.0 - (top - overlap / law.radius) / recovered)
    return recoverable * left**power, loading_work(law, top, limit) - recoverable


@kernel
def edmans_sinka_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """The steepest of loading and start of unloading, in 64 steps of the largest overlap from first yield to `overlap`.

    Loading, F = F_el r: over one step no steeper than the largest F_el' times the largest r, and what a growing r adds. Unloading starts
    with F_max alpha rho/R, which grows with the overlap for the published constants; otherwise the 64 steps find its maximum to within
    some 0.1 %.
    """
    limit = first_yield(law)
    top = max(overlap, 0.0) / law.radius
    largest = largest_finite_size_stiffness(law, min(top, limit) * law.radius)
    if top <= limit:
        return largest
    before, ratio, stiffness = limit, 1.0, finite_size_stiffness(law, limit * law.radius)
    for i in range(1, 65):
        depth = limit * (top / limit) ** (i / 64.0)
        after, elastic = loading_ratio(law, depth, limit), finite_size_stiffness(law, depth * law.radius)
        growth = max(0.0, after - ratio) / ((depth - before) * law.radius) * finite_size_force(law, depth * law.radius)
        loading = max(stiffness, elastic) * max(ratio, after) + growth
        steepness = unloading_exponent(law, depth, limit) / (recovered_depth(law, depth, limit) * law.radius)
        largest = max(largest, loading, loading_force(law, depth, limit) * steepness)
        before, ratio, stiffness = depth, after, elastic
    return largest


register(
    Law(
        "edmans_sinka",
        EdmansSinka,
        edmans_sinka_force,
        edmans_sinka_contact_radius,
        edmans_sinka_energy,
        edmans_sinka_stiffness_bound,
        ("largest_overlap",),
        "Edmans & Sinka 2020, Eqs. 2-5 (K of Chang, Etsion & Bogy unless said otherwise) on a loading branch fitted to finite elements",
    )
)
