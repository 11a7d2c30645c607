"""The record of the whole-range law, and how its coefficients follow from the material and the global constants.

Symbols: D overlap over radius, h = 1 - D, E Young's modulus over yield stress, nu Poisson's ratio, f = F/(pi R^2 Y). What depends on the
material alone is computed once, here; what depends on the overlap is in `whole_range_loading` and `whole_range_unloading`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from contactlaws.compiled import kernel
from contactlaws.whole_range_loading import elastic_factor, plastic_limit

#: p0/Y at first yield in Hertz's field (von Mises): a parabola in nu through the exact 1.2993, 1.4453, 1.6128, 1.8061 at nu = 0, .15, .3,
#: .45, met within .1 %
FIRST_YIELD = (1.2993, 0.8963, 0.5014)


class Constants(NamedTuple):
    """The global constants: one set for all materials. Names ending in _nu multiply nu, in _nu2 its square."""

    # elastic force over Hertz's: 1 + f1 t + f2 t^2 + f3 t^6, t = sqrt(D)
    force_1: float
    force_1_nu: float
    force_1_nu2: float
    force_2: float
    force_2_nu: float
    force_2_nu2: float
    force_3: float
    force_3_nu: float
    force_3_nu2: float
    # elastic area over R d: 1 + g1 t + g2 t^2 + g3 t^6
    area_1: float
    area_1_nu: float
    area_1_nu2: float
    area_2: float
    area_2_nu: float
    area_2_nu2: float
    area_3: float
    area_3_nu: float
    area_3_nu2: float
    # first yield: 1/D_Y = 1/X + y1 + y2/sqrt(X), X what Hertz's field says
    yield_1: float
    yield_2: float
    # plastic limit: indentation 8.12 D/(1 + i1 t + i2 D), upsetting 2/(3 h) (1 - h (u1 + u2 h + u3 h^2))
    indentation_1: float
    indentation_2: float
    upsetting_1: float
    upsetting_2: float
    upsetting_3: float
    # between the two: width c and sharpness m of the transition, for indentation (no suffix) and for upsetting
    width: float
    width_nu: float
    width_upset: float
    width_upset_nu: float
    width_upset_depth: float
    width_upset_depth_nu: float
    width_upset_yield: float
    sharpness: float
    sharpness_nu: float
    sharpness_upset: float
    sharpness_upset_nu: float
    sharpness_upset_depth: float
    sharpness_upset_depth_nu: float
    sharpness_upset_yield: float
    # plastic area: indentation 2.86 D/(1 + j1 t + j2 D), upsetting 2/(3 h) (1 - h (v1 + v2 h + v3 h^2)); onset (1 - phi)^N
    spread_1: float
    spread_2: float
    widening_1: float
    widening_2: float
    widening_3: float
    onset: float
    onset_nu: float
    onset_upset: float
    # recovery: exp(-D h (r0 + r1 nu + r2 nu^2)/(1 + r3 D)); share of the elastic one phi^M
    recovery: float
    recovery_nu: float
    recovery_nu2: float
    recovery_depth: float
    fading: float
    fading_nu: float
    fading_upset: float
    # shape of the unloading: x1, x2 by mechanism, with phi and the depth
    round: float
    round_phi: float
    round_phi2: float
    round_upset: float
    round_upset_phi: float
    round_upset_depth: float
    slope: float
    slope_phi: float
    slope_phi2: float
    slope_upset: float
    slope_upset_phi: float
    slope_upset_depth: float


class WholeRange(NamedTuple):
    """One body of a given material: make it with `contactlaws.whole_range.whole_range`. Symbols as in the modules."""

    radius: float  # m
    youngs_modulus: float  # Pa
    poissons_ratio: float  # -
    yield_stress: float  # Pa
    force_unit: float  # N; pi R^2 Y
    stiffness: float  # 4 E/(3 pi (1 - nu^2)): Hertz's f over D^1.5
    force_1: float  # elastic force: f1, f2, f3
    force_2: float
    force_3: float
    area_1: float  # elastic area: g1, g2, g3
    area_2: float
    area_3: float
    yield_depth: float  # D_Y
    yield_load: float  # s_Y: elastic force over plastic limit at first yield
    indentation_1: float
    indentation_2: float
    upsetting_1: float
    upsetting_2: float
    upsetting_3: float
    width: float  # c, indentation
    width_upset: float  # c, upsetting
    width_upset_depth: float
    sharpness: float  # m, indentation
    sharpness_upset: float  # m, upsetting
    sharpness_upset_depth: float
    spread_1: float
    spread_2: float
    widening_1: float
    widening_2: float
    widening_3: float
    onset: float  # N, indentation
    onset_upset: float  # N, upsetting
    compliance: float  # exp(Y/E) - 1
    punch: float  # 2 (1 - nu^2): Mesarovic & Johnson's recovery of a flat contact
    recovery: float
    recovery_depth: float
    fading: float  # M, indentation
    fading_upset: float  # M, upsetting
    round: float
    round_phi: float
    round_phi2: float
    round_upset: float
    round_upset_phi: float
    round_upset_depth: float
    slope: float
    slope_phi: float
    slope_phi2: float
    slope_upset: float
    slope_upset_phi: float
    slope_upset_depth: float


@kernel
def hertz_yield_root(compliance, poissons_ratio):  # type: ignore[no-untyped-def]
    """sqrt(D) at first yield in Hertz's field: pi p0/(2 E*), from Y/E."""
    pressure = FIRST_YIELD[0] + poissons_ratio * (FIRST_YIELD[1] + poissons_ratio * FIRST_YIELD[2])
    return 0.5 * math.pi * pressure * (1.0 - poissons_ratio * poissons_ratio) * compliance


@kernel
def coefficients(constants, radius, youngs_modulus, poissons_ratio, yield_stress):  # type: ignore[no-untyped-def]
    """The values of the record, in its order. SI units; nothing is checked here."""
    k, nu = constants, poissons_ratio
    e = yield_stress / youngs_modulus
    stiffness = 4.0 / (3.0 * math.pi * e * (1.0 - nu * nu))
    force_1 = k.force_1 + nu * (k.force_1_nu + nu * k.force_1_nu2)
    force_2 = k.force_2 + nu * (k.force_2_nu + nu * k.force_2_nu2)
    force_3 = k.force_3 + nu * (k.force_3_nu + nu * k.force_3_nu2)
    root = hertz_yield_root(e, nu)
    depth = 1.0 / (1.0 / (root * root) + k.yield_2 / root + k.yield_1)
    load = stiffness * depth * math.sqrt(depth) * elastic_factor(force_1, force_2, force_3, math.sqrt(depth))
    share = load / plastic_limit(k, depth)[0]
    return (
        radius,
        youngs_modulus,
        nu,
        yield_stress,
        math.pi * radius * radius * yield_stress,
        stiffness,
        force_1,
        force_2,
        force_3,
        k.area_1 + nu * (k.area_1_nu + nu * k.area_1_nu2),
        k.area_2 + nu * (k.area_2_nu + nu * k.area_2_nu2),
        k.area_3 + nu * (k.area_3_nu + nu * k.area_3_nu2),
        depth,
        share,
        k.indentation_1,
        k.indentation_2,
        k.upsetting_1,
        k.upsetting_2,
        k.upsetting_3,
        k.width + nu * k.width_nu,
        k.width_upset + nu * k.width_upset_nu + share * k.width_upset_yield,
        k.width_upset_depth + nu * k.width_upset_depth_nu,
        k.sharpness + nu * k.sharpness_nu,
        k.sharpness_upset + nu * k.sharpness_upset_nu + share * k.sharpness_upset_yield,
        k.sharpness_upset_depth + nu * k.sharpness_upset_depth_nu,
        k.spread_1,
        k.spread_2,
        k.widening_1,
        k.widening_2,
        k.widening_3,
        k.onset + nu * k.onset_nu,
        k.onset_upset + nu * k.onset_nu,
        math.expm1(e),
        2.0 * (1.0 - nu * nu),
        k.recovery + nu * (k.recovery_nu + nu * k.recovery_nu2),
        k.recovery_depth,
        k.fading + nu * k.fading_nu,
        k.fading_upset,
        k.round,
        k.round_phi,
        k.round_phi2,
        k.round_upset,
        k.round_upset_phi,
        k.round_upset_depth,
        k.slope,
        k.slope_phi,
        k.slope_phi2,
        k.slope_upset,
        k.slope_upset_phi,
        k.slope_upset_depth,
    )
