"""Loading branch of the whole-range law: force, contact area and work. `law` is the record, D = depth the overlap over the radius.

Plastic limit P: the lesser of what indentation of a half-space takes (similarity: p = 2.84 Y on a^2 = 2.86 R d, f = 8.12 D) and what
upsetting of the whole body takes (a bar of equal volume at yield, 2/(3 (1 - D)), towards D = 1), each with the finite body's factor.
Force: with s = f_el/P and z what s exceeds its value at first yield by, f_el/f = 1 + z^2 (z + a)/(z^2 + (a + b) z + c): exactly elastic
before yield, the same slope there, towards P far beyond. The lag b, the onset c and the bend a go from indentation to upsetting.
"""

from __future__ import annotations

import math

import numpy as np

from contactlaws.compiled import kernel

#: similarity regime of the fully plastic indentation by a sphere: mean pressure over Y, a^2/(R d), and their product
PRESSURE, AREA = 2.84, 2.86
INDENTATION = PRESSURE * AREA
#: the onset stays above, so that the slope is continuous at yield
LEAST_ONSET = 0.001
#: for integrals of the loading branch: 12 panels of 8 points leave less than 1e-12 of the work
_NODES, _SHARES = np.polynomial.legendre.leggauss(8)
_PANELS = 12


@kernel
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


@kernel
def plastic_limit(law, depth):  # type: ignore[no-untyped-def]
    """P, and the share of upsetting in it, from 0 (indentation) to 1. An eighth power and root are cheap and sharp enough."""
    h = 1.0 - depth
    local = INDENTATION * depth / (h * (1.0 + law.indentation_1 * math.sqrt(depth) + law.indentation_2 * depth))
    whole = (1.0 - h * (law.upsetting_1 + h * (law.upsetting_2 + h * law.upsetting_3))) / (1.5 * h)
    ratio = local / whole
    ratio *= ratio
    ratio *= ratio
    return local / math.sqrt(math.sqrt(math.sqrt(1.0 + ratio * ratio))), ratio / (1.0 + ratio)


@kernel
def elastic_share(law, depth, elastic, limit, upset):  # type: ignore[no-untyped-def]
    """phi = f/f_el beyond yield, from the elastic force, the plastic limit and the share of upsetting."""
    z = elastic / limit - law.yield_load
    lag = law.lag + upset * (law.lag_upset - law.lag + law.lag_upset_depth * depth)
    onset = max(LEAST_ONSET, law.onset + upset * upset * (law.onset_upset + law.onset_upset_depth * depth))
    bend = upset * max(0.0, law.bend_upset)
    above = z * (z + bend + lag) + onset
    return above / (above + z * z * (z + bend))


@kernel
def loading(law, depth):  # type: ignore[no-untyped-def]
    """f, phi and the share of upsetting."""
    elastic = elastic_load(law, depth)
    limit, upset = plastic_limit(law, depth)
    if depth <= law.yield_depth:
        return elastic, 1.0, upset
    phi = elastic_share(law, depth, elastic, limit, upset)
    return elastic * phi, phi, upset


@kernel
def loading_load(law, depth):  # type: ignore[no-untyped-def]
    """f on the loading branch."""
    elastic = elastic_load(law, depth)
    if depth <= law.yield_depth:
        return elastic
    limit, upset = plastic_limit(law, depth)
    return elastic * elastic_share(law, depth, elastic, limit, upset)


@kernel
def turned(upset, turn):  # type: ignore[no-untyped-def]
    """A share from 0 to 1 that turns earlier (turn > 1) or later than the share of upsetting in the force."""
    weight = max(0.01, turn) * upset
    return weight / (1.0 - upset + weight)


@kernel
def loading_area(law, depth, phi, upset):  # type: ignore[no-untyped-def]
    """(a/R)^2 on the loading branch: from the elastic to the plastic one as the force falls behind the elastic one."""
    elastic = elastic_area(law, depth)
    if phi >= 1.0:
        return elastic
    h = 1.0 - depth
    local = AREA * depth / (h * (1.0 + law.spread_1 * math.sqrt(depth) + law.spread_2 * depth))
    whole = (1.0 - h * (law.widening_1 + h * (law.widening_2 + h * law.widening_3))) / (1.5 * h)
    ratio = local / whole
    ratio *= ratio
    ratio *= ratio
    plastic = local / math.sqrt(math.sqrt(math.sqrt(1.0 + ratio * ratio)))
    power = law.growth + turned(upset, law.turn_area) * (law.growth_upset - law.growth + law.growth_upset_depth * depth)
    return elastic + (plastic - elastic) * (1.0 - phi) ** power


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
