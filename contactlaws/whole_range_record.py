"""The record of the whole-range law, and how its coefficients follow from the material and the global constants.

Symbols: D overlap over radius, h = 1 - D, E Young's modulus over yield stress, nu Poisson's ratio, f = F/(pi R^2 Y). What depends on the
material alone is computed once, here; what depends on the overlap is in `whole_range_loading` and `whole_range_unloading`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from contactlaws.compiled import kernel
from contactlaws.whole_range_loading import BAR, INDENTATION, elastic_factor, plastic_limit

#: p0/Y at first yield in Hertz's field (von Mises): a parabola in nu through the exact 1.2993, 1.4453, 1.6128, 1.8061 at nu = 0, .15, .3,
#: .45, met within .11 %, within .24 % up to .4999; `contactlaws.pair.pressure_at_yield` finds it exactly, which is no work for a kernel
FIRST_YIELD = (1.2993, 0.8963, 0.5014)

#: the onset of a fit stays above: at 0 the slope would break at yield
LEAST_ONSET = 1e-4


class Constants(NamedTuple):
    """The global constants: one set for all materials. Names ending in _nu multiply nu, in _nu2 its square; u is a share of upsetting."""

    # elastic force over Hertz's: 1 + f1 t + f2 t^2 + f3 t^6, t = sqrt(D)
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
    area_2: float
    area_3: float
    area_3_nu: float
    # first yield: 1/D_Y = 1/X + y1 + y2/sqrt(X), X what Hertz's field says
    yield_1: float
    yield_2: float
    # plastic limit: 8.85 D/(1 - D) (1 + l1 t + l2 D + l3 D^2)/(1 + m1 t + m2 D + m3 D^2); l3 is what makes a bar of it at D = 1
    limit_over_1: float
    limit_over_2: float
    limit_under_1: float
    limit_under_2: float
    limit_under_3: float
    # beyond yield: u = 1/2 at D = turn; lag b of indentation, with t, and what upsetting adds; onset c/(1 + k u^2 D); bend a of indentation
    turn: float
    lag: float
    lag_nu: float
    lag_root: float
    lag_upset: float
    lag_upset_depth: float
    lag_upset_depth_nu: float
    lag_upset_yield: float
    onset: float
    onset_nu: float
    onset_upset_depth: float
    bend: float
    # plastic area: 2.94 D/(1 - D) (1 + j1 t + j2 D^2)/(1 + j3 D^2); (1 - phi)^N of the way there, N with u (its own turn), nu and phi
    spread_1: float
    spread_2: float
    spread_3: float
    growth: float
    growth_turn: float
    growth_upset_nu: float
    growth_phi: float
    # plastic recovery: factors of indentation, with (1 - 2 nu)^4 and t, and of upsetting; u with its own turn; a dip on the way to elastic
    recovery: float
    recovery_nu: float
    recovery_depth: float
    recovery_upset: float
    recovery_turn: float
    dip: float
    dip_upset: float
    # how the elastic part fades: phi exp(-M ln(1/phi)^q), M with D^2, q with u (its own turn); a swelling by upsetting
    fading: float
    fading_depth: float
    fading_depth_nu: float
    fading_power: float
    fading_power_upset: float
    fading_turn: float
    swell: float
    swell_end: float
    # shape of the unloading: phi^share of the elastic one; A and B from plastic (u with its own turn) to elastic by mix; a dip of A between
    share: float
    shape_turn: float
    mix: float
    mix_nu: float
    mix_power: float
    round: float
    round_nu: float
    round_phi: float
    round_dip: float
    round_upset: float
    round_upset_depth: float
    round_elastic: float
    round_elastic_depth: float
    slope: float
    slope_upset: float
    slope_elastic: float


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
    limit_over_1: float  # plastic limit: l1 to l3
    limit_over_2: float
    limit_over_3: float
    limit_under_1: float  # m1 to m3
    limit_under_2: float
    limit_under_3: float
    turn_2: float  # 1/turn^2
    lag: float  # b, indentation
    lag_root: float
    lag_upset: float  # b, what upsetting adds
    lag_upset_depth: float
    onset: float  # c
    onset_upset_depth: float  # k
    bend: float  # a
    spread_1: float  # plastic area: j1 to j3
    spread_2: float
    spread_3: float
    growth: float  # N
    growth_turn: float
    growth_upset: float
    growth_phi: float
    compliance: float  # exp(Y/E) - 1
    recovery: float  # factors of w_pl
    recovery_depth: float
    recovery_upset: float
    recovery_turn: float
    dip: float
    dip_upset: float
    fading: float  # M
    fading_depth: float
    fading_power: float  # q
    fading_power_upset: float
    fading_turn: float
    swell: float
    swell_end: float
    share: float
    shape_turn: float
    mix: float
    mix_power: float
    round: float  # A
    round_phi: float
    round_dip: float
    round_upset: float
    round_upset_depth: float
    round_elastic: float
    round_elastic_depth: float
    slope: float  # B
    slope_upset: float
    slope_elastic: float


WholeRangeCompact = NamedTuple("WholeRangeCompact", list(WholeRange.__annotations__.items()))  # type: ignore[misc]
WholeRangeCompact.__doc__ = "`WholeRange` made from at most 20 constants: make it with `contactlaws.whole_range.whole_range_compact`."


class Limit(NamedTuple):
    """The plastic limit of the force: l1 to l3, m1 to m3."""

    limit_over_1: float
    limit_over_2: float
    limit_over_3: float
    limit_under_1: float
    limit_under_2: float
    limit_under_3: float


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
    force_1 = nu * (k.force_1_nu + nu * k.force_1_nu2)
    force_2 = k.force_2 + nu * (k.force_2_nu + nu * k.force_2_nu2)
    force_3 = k.force_3 + nu * (k.force_3_nu + nu * k.force_3_nu2)
    root = hertz_yield_root(e, nu)
    depth = 1.0 / (1.0 / (root * root) + k.yield_2 / root + k.yield_1)
    load = stiffness * depth * math.sqrt(depth) * elastic_factor(force_1, force_2, force_3, math.sqrt(depth))
    limit_over_3 = BAR / INDENTATION * (1.0 + k.limit_under_1 + k.limit_under_2 + k.limit_under_3) - 1.0 - k.limit_over_1 - k.limit_over_2
    limit = Limit(k.limit_over_1, k.limit_over_2, limit_over_3, k.limit_under_1, k.limit_under_2, k.limit_under_3)
    first = load / plastic_limit(limit, depth)
    squeezed = 1.0 - 2.0 * nu
    squeezed *= squeezed
    squeezed *= squeezed
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
        k.area_1 + nu * k.area_1_nu,
        k.area_2,
        k.area_3 + nu * k.area_3_nu,
        depth,
        first,
        k.limit_over_1,
        k.limit_over_2,
        limit_over_3,
        k.limit_under_1,
        k.limit_under_2,
        k.limit_under_3,
        1.0 / (k.turn * k.turn),
        k.lag + nu * k.lag_nu,
        k.lag_root,
        k.lag_upset + first * k.lag_upset_yield,
        k.lag_upset_depth + nu * k.lag_upset_depth_nu,
        max(LEAST_ONSET, k.onset + nu * k.onset_nu),
        max(0.0, k.onset_upset_depth),
        k.bend,
        k.spread_1,
        k.spread_2,
        k.spread_3,
        k.growth,
        k.growth_turn,
        nu * k.growth_upset_nu,
        k.growth_phi,
        math.expm1(e),
        k.recovery + squeezed * k.recovery_nu,
        k.recovery_depth,
        k.recovery_upset,
        k.recovery_turn,
        k.dip,
        k.dip_upset,
        k.fading,
        k.fading_depth + nu * k.fading_depth_nu,
        k.fading_power,
        k.fading_power_upset,
        k.fading_turn,
        k.swell,
        k.swell_end,
        k.share,
        k.shape_turn,
        max(0.0, k.mix + nu * k.mix_nu),
        k.mix_power,
        k.round + squeezed * k.round_nu,
        k.round_phi,
        k.round_dip,
        k.round_upset,
        k.round_upset_depth,
        k.round_elastic,
        k.round_elastic_depth,
        k.slope,
        k.slope_upset,
        k.slope_elastic,
    )
