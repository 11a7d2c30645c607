"""Loading branch of the whole-range law: force, contact area and work. `law` is the record, D = depth the overlap over the radius.

Plastic limit P: from the indentation of a half-space (similarity: p = 3.01 Y on a^2 = 2.94 R d, f = 8.85 D) at D = 0 to the upsetting of
the whole body (a bar of equal volume at yield, 2/(3 (1 - D))) at D = 1, one ratio of polynomials of sqrt(D) and D in between.
Force: with s = f_el/P and z what s exceeds its value at first yield by, f_el/f = 1 + z^2 (z + a)/(z^2 + (a + b) z + c): exactly elastic
before yield, the same slope there, towards P far beyond. The bend a, the lag b and the onset c go from indentation to upsetting.
Area: from the elastic to the plastic one as the force falls behind the elastic one. One root and three divisions make a force.
"""

from __future__ import annotations

import math

import numpy as np

from contactlaws.compiled import inlined, kernel

#: similarity regime of the fully plastic indentation by a sphere: mean pressure over Y, a^2/(R d), and their product; what
#: `cases.verification.similarity` extrapolates to D = 0 (Mesarovic & Fleck 1999 and others: about 3 and 2.9)
PRESSURE, AREA = 3.01, 2.94
INDENTATION = PRESSURE * AREA
#: force over pi R^2 Y of a bar of the sphere's volume at yield, times 1 - D
BAR = 2.0 / 3.0
#: the power of the growing area stays above, so that it does not jump at yield
LEAST_GROWTH = 0.1
#: for integrals of the loading branch: 12 panels of 8 points leave less than 1e-12 of the work
_NODES, _SHARES = np.polynomial.legendre.leggauss(8)
_PANELS = 12


@inlined
def elastic_factor(one, two, three, t):  # type: ignore[no-untyped-def]
    """1 + one t + two t^2 + three t^6: what a finite body adds to Hertz, t = sqrt(D)."""
    square = t * t
    return 1.0 + one * t + square * (two + square * square * three)


@kernel
def elastic_load(law, depth):  # type: ignore[no-untyped-def]
    """f of the body that never yields."""
    t = math.sqrt(depth)
    return law.stiffness * t * depth * elastic_factor(law.force_1, law.force_2, law.force_3, t)


@kernel
def elastic_area(law, depth):  # type: ignore[no-untyped-def]
    """(a/R)^2 of the body that never yields."""
    return depth * max(0.0, elastic_factor(law.area_1, law.area_2, law.area_3, math.sqrt(depth)))


@kernel
def elastic_work(law, depth):  # type: ignore[no-untyped-def]
    """Integral of `elastic_load` from 0, term by term."""
    t = math.sqrt(depth)
    factor = 2.0 / 5.0 + t * (law.force_1 / 3.0 + t * (law.force_2 * 2.0 / 7.0 + t**4 * law.force_3 * 2.0 / 11.0))
    return law.stiffness * t * depth * depth * factor


@kernel
def elastic_slope(law, depth):  # type: ignore[no-untyped-def]
    """Derivative of `elastic_load`."""
    t = math.sqrt(depth)
    return law.stiffness * t * (1.5 + t * (2.0 * law.force_1 + t * (2.5 * law.force_2 + t**4 * 4.5 * law.force_3)))


@inlined
def limit_parts(law, depth, t):  # type: ignore[no-untyped-def]
    """P (1 - D)/(8.85 D) as dividend and divisor, t = sqrt(D)."""
    over = 1.0 + law.limit_over_1 * t + depth * (law.limit_over_2 + depth * law.limit_over_3)
    return over, 1.0 + law.limit_under_1 * t + depth * (law.limit_under_2 + depth * law.limit_under_3)


@kernel
def plastic_limit(law, depth):  # type: ignore[no-untyped-def]
    """P of the force."""
    over, under = limit_parts(law, depth, math.sqrt(depth))
    return INDENTATION * depth * over / ((1.0 - depth) * under)


@inlined
def part_of_elastic(law, size, t, z, bend_more, lag_more, onset_less):  # type: ignore[no-untyped-def]
    """f/f_el beyond yield as dividend and divisor. size: the depth that indentation and upsetting are told apart by, t its square root.

    The last three are what another shape than the sphere's changes: added to bend and lag, and the factor that divides the onset.
    """
    power = size * size * law.turn_2
    power *= power
    upset = power / (1.0 + power)
    lag = law.lag + law.lag_root * t + upset * (law.lag_upset + law.lag_upset_depth * size) + lag_more
    early = (1.0 + law.onset_upset_depth * upset * upset * size) * onset_less  # the onset is divided by it: it stays positive
    bend = law.bend * (1.0 - upset) + bend_more
    above = early * z * (z + bend + lag) + law.onset
    return above, above + early * z * z * (z + bend)


@inlined
def loading_load(law, depth):  # type: ignore[no-untyped-def]
    """f on the loading branch. The elastic force over the plastic limit is formed by one division: this is the force of every contact."""
    t = math.sqrt(depth)
    factor = elastic_factor(law.force_1, law.force_2, law.force_3, t)
    elastic = law.stiffness * t * depth * factor
    if depth <= law.yield_depth:
        return elastic
    over, under = limit_parts(law, depth, t)
    z = law.stiffness / INDENTATION * t * (1.0 - depth) * factor * under / over - law.yield_load
    part, whole = part_of_elastic(law, depth, t, z, 0.0, 0.0, 1.0)
    return elastic * part / whole


@kernel
def loading(law, depth):  # type: ignore[no-untyped-def]
    """f and phi = f/f_el."""
    if depth <= law.yield_depth:
        return elastic_load(law, depth), 1.0
    load = loading_load(law, depth)
    return load, load / elastic_load(law, depth)


@kernel
def share(depth, half, power):  # type: ignore[no-untyped-def]
    """Of upsetting, from 0 (indentation) to 1: 1/2 at the depth `half`, the steeper the higher the power."""
    ratio = (depth / half) ** power
    return ratio / (1.0 + ratio)


@kernel
def loading_area(law, depth, phi):  # type: ignore[no-untyped-def]
    """(a/R)^2 on the loading branch: (1 - phi)^N of the way from the elastic to the plastic one."""
    return area_beyond_yield(law, depth, depth, phi, elastic_area(law, depth))


@inlined
def area_beyond_yield(law, depth, size, phi, elastic):  # type: ignore[no-untyped-def]
    """(a/R)^2 from the elastic one; `size` is the depth that indentation and upsetting are told apart by."""
    if phi >= 1.0:
        return elastic
    over = 1.0 + law.spread_1 * math.sqrt(size) + law.spread_2 * size * size
    plastic = AREA * depth * over / ((1.0 - size) * (1.0 + law.spread_3 * size * size))
    growth = law.growth + share(size, law.growth_turn, 4) * law.growth_upset + law.growth_phi * phi
    return elastic + (plastic - elastic) * (1.0 - phi) ** max(LEAST_GROWTH, growth)


@kernel
def loading_work(law, depth):  # type: ignore[no-untyped-def]
    """Work over pi R^3 Y of the loading to `depth`: closed up to first yield, then Gauss quadrature in v with sqrt(D/D_Y) = 1 + v^2."""
    limit = law.yield_depth
    work = elastic_work(law, min(depth, limit))
    if depth <= limit:
        return work
    panel = math.sqrt(math.sqrt(depth / limit) - 1.0) / _PANELS
    for i in range(_PANELS):
        for j in range(_NODES.size):
            v = panel * (i + 0.5 * (1.0 + _NODES[j]))
            root = 1.0 + v * v
            work += 0.5 * panel * _SHARES[j] * 4.0 * v * root * limit * loading_load(law, limit * root * root)
    return work
