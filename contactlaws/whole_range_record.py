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

#: beyond this D a body yields, whatever its modulus: only those with E/Y below 1 come that far
LATEST_YIELD = 0.59


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
    # first yield: 1/D_Y = 1/X + y1 + y2/sqrt(X), X what Hertz's field says
    yield_1: float
    yield_2: float
    # plastic limit: indentation 8.12 D/[h (1 + i1 t + i2 D)], upsetting 2/(3 h) (1 - h (u1 + u2 h + u3 h^2))
    indentation_1: float
    indentation_2: float
    upsetting_1: float
    upsetting_2: float
    upsetting_3: float
    # beyond yield: lag b and onset c for indentation (no suffix) and for upsetting; a for upsetting only
    lag: float
    lag_nu: float
    lag_upset: float
    lag_upset_depth: float
    lag_upset_depth_nu: float
    lag_upset_yield: float
    onset: float
    onset_upset: float
    onset_upset_nu: float
    onset_upset_depth: float
    onset_upset_depth_nu: float
    onset_upset_yield: float
    bend_upset: float
    bend_upset_nu: float
    bend_upset_yield: float
    # the share u of upsetting in what follows the force: q u/(1 - u + q u)
    turn_area: float
    turn_recovery: float
    turn_shape: float
    # plastic area: indentation 2.86 D/[h (1 + j1 t + j2 D)], upsetting 2/(3 h) (1 - h (v1 + v2 h + v3 h^2)); (1 - phi)^N of the way
    spread_1: float
    spread_2: float
    widening_1: float
    widening_2: float
    widening_3: float
    growth: float
    growth_upset: float
    growth_upset_depth: float
    growth_upset_yield: float
    # recovery: exp(-D h (r0 + r1 nu + r2 nu^2)/(1 + r3 D)); share of the elastic one exp(-M r^(5/8)), r = 1/phi - 1
    recovery: float
    recovery_nu: float
    recovery_nu2: float
    recovery_depth: float
    fading: float
    fading_upset: float
    fading_upset_depth: float
    fading_upset_yield: float
    # shape of the unloading: share of the elastic one 1/(1 + k r^(5/8))^2; x1, x2 by mechanism, with phi and the depth
    share: float
    share_upset: float
    round: float
    round_upset: float
    round_upset_nu: float
    round_upset_phi: float
    round_upset_depth: float
    slope_phi: float
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
    lag: float  # b, indentation
    lag_upset: float  # b, upsetting
    lag_upset_depth: float
    onset: float  # c, indentation
    onset_upset: float  # c, upsetting
    onset_upset_depth: float
    bend_upset: float  # a
    turn_area: float
    turn_recovery: float
    turn_shape: float
    spread_1: float
    spread_2: float
    widening_1: float
    widening_2: float
    widening_3: float
    growth: float  # N, indentation
    growth_upset: float  # N, upsetting
    growth_upset_depth: float
    compliance: float  # exp(Y/E) - 1
    recovery: float
    recovery_depth: float
    fading: float  # M, indentation
    fading_upset: float  # M, upsetting
    fading_upset_depth: float
    share: float  # k, indentation
    share_upset: float  # k, upsetting
    round: float
    round_upset: float
    round_upset_phi: float
    round_upset_depth: float
    slope_phi: float
    slope_upset: float
    slope_upset_phi: float
    slope_upset_depth: float


WholeRangeCompact = NamedTuple("WholeRangeCompact", list(WholeRange.__annotations__.items()))  # type: ignore[misc]
WholeRangeCompact.__doc__ = "`WholeRange` made from at most 20 constants: make it with `contactlaws.whole_range.whole_range_compact`."


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
    depth = min(1.0 / (1.0 / (root * root) + k.yield_2 / root + k.yield_1), LATEST_YIELD)
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
        k.area_3 + nu * k.area_3_nu,
        depth,
        share,
        k.indentation_1,
        k.indentation_2,
        k.upsetting_1,
        k.upsetting_2,
        k.upsetting_3,
        k.lag + nu * k.lag_nu,
        k.lag_upset + share * k.lag_upset_yield,
        k.lag_upset_depth + nu * k.lag_upset_depth_nu,
        k.onset,
        k.onset_upset + nu * k.onset_upset_nu + share * k.onset_upset_yield,
        k.onset_upset_depth + nu * k.onset_upset_depth_nu,
        k.bend_upset + nu * k.bend_upset_nu + share * k.bend_upset_yield,
        k.turn_area,
        k.turn_recovery,
        k.turn_shape,
        k.spread_1,
        k.spread_2,
        k.widening_1,
        k.widening_2,
        k.widening_3,
        k.growth,
        k.growth_upset + share * k.growth_upset_yield,
        k.growth_upset_depth,
        math.expm1(e),
        k.recovery + nu * (k.recovery_nu + nu * k.recovery_nu2),
        k.recovery_depth,
        k.fading,
        k.fading_upset + share * k.fading_upset_yield,
        k.fading_upset_depth,
        k.share,
        k.share_upset,
        k.round,
        k.round_upset + nu * k.round_upset_nu,
        k.round_upset_phi,
        k.round_upset_depth,
        k.slope_phi,
        k.slope_upset,
        k.slope_upset_phi,
        k.slope_upset_depth,
    )
