"""Unloading of the whole-range law: the recovered overlap, the shape of the branch, and its work. `law` is the record.

From the largest depth D, s falls from 1 to 0 while the overlap w (over the radius) is recovered. Everything depends on D, nu and
phi = f/f_el there. w goes from D (elastic) to the plastic w_pl, which is Mesarovic & Johnson's 2 (1 - nu^2) F/(pi a E) for a contact small
against the body (times a factor near 1: the pressure is not as even as they took it) and the springback of a bar of equal volume for a
deep one. The shape is a share of the elastic branch itself, and for the rest s^(A + B s). The area of the contact follows from the slope of
that: a contact has the stiffness 2 E* a whatever the surfaces in it (Bulychev, Alekhin & Shorshorov 1975; Pharr, Oliver & Brotzen 1992).
"""

from __future__ import annotations

import math

import numpy as np

from contactlaws.compiled import inlined, kernel
from contactlaws.whole_range_loading import elastic_area, elastic_load, share

#: the exponent of the rest of the shape stays above: a smaller one would begin with an infinite slope
LEAST_ROUND = 1.0
#: the factor by which the elastic part of the recovery fades stays above, and the power: below 1/2, where fits take it for indentation, the
#: recovered overlap leaves the elastic one with a vertical tangent (by half a thousandth within .1 % of the overlap of first yield)
LEAST_FADING, LEAST_POWER = 0.1, 0.3
#: the elastic area is the power of that by its slope between this and its inverse
MOST_POWER = 1.5
#: for the work of the shape, in v with s = v^3: leaves less than 1e-9 of it
_NODES, _SHARES = np.polynomial.legendre.leggauss(16)


@kernel
def plastic_recovery(law, height, size, load, phi, area, upset):  # type: ignore[no-untyped-def]
    """w_pl: Mesarovic & Johnson's and the bar's added in squares, each with its factor. height: what is left of the half height, of 1."""
    punch = 2.0 * (1.0 - law.poissons_ratio * law.poissons_ratio * height * height)
    local = law.recovery * (1.0 - law.recovery_depth * math.sqrt(size))
    factor = local + upset * (law.recovery_upset - local)
    dip = phi * (1.0 - phi) * (law.dip * phi + upset * law.dip_upset)
    return law.compliance * load * height * height * math.sqrt(punch * punch / area + 2.25) * factor * (1.0 - dip)


@kernel
def recovered_depth(law, depth, load, phi, area):  # type: ignore[no-untyped-def]
    """w: the overlap over the radius that unloading from `depth` gives back."""
    if phi >= 1.0:
        return depth
    return recovered_beyond_yield(law, depth, 1.0 - depth, depth, load, phi, area)


@kernel
def recovered_beyond_yield(law, depth, height, size, load, phi, area):  # type: ignore[no-untyped-def]
    """w; `height` as in `plastic_recovery`, `size` the depth that indentation and upsetting are told apart by."""
    upset = share(size, law.recovery_turn, 4)
    plastic = min(depth, plastic_recovery(law, height, size, load, phi, area, upset))
    power = max(LEAST_POWER, law.fading_power + share(size, law.fading_turn, 4) * law.fading_power_upset)
    fading = max(LEAST_FADING, law.fading + law.fading_depth * size * size)
    # phi: the plastic part falls no faster, so it is what is left of a stiff body
    left = phi * math.exp(-fading * (-math.log(phi)) ** power)
    # by upsetting more is left where phi is large, and less than the plastic part where it is small
    left *= 1.0 + upset * law.swell * (1.0 - phi) * (law.swell_end - (1.0 - phi))
    return min(depth, plastic + (depth - plastic) * left)


@inlined
def elastic_terms(law, depth):  # type: ignore[no-untyped-def]
    """Terms of the elastic branch in sqrt(s), s and s^3."""
    return law.force_1 * math.sqrt(depth), law.force_2 * depth, law.force_3 * depth * depth * depth


@kernel
def shape_terms(law, depth, phi):  # type: ignore[no-untyped-def]
    """Share of the elastic branch; terms of that in sqrt(s), s and s^3; A and B of the rest."""
    return shape_of_terms(law, depth, phi, elastic_terms(law, depth))


@inlined
def shape_of_terms(law, size, phi, elastic):  # type: ignore[no-untyped-def]
    """`shape_terms` from those of the elastic branch; `size` is the depth that indentation and upsetting are told apart by."""
    one, two, three = elastic
    if phi >= 1.0:
        return 1.0, one, two, three, 1.5, 0.0
    upset = share(size, law.shape_turn, 6)
    mix = 1.0 / (1.0 + (law.mix * (1.0 - phi) / phi) ** law.mix_power)
    round_plastic = (1.0 - upset) * (law.round + law.round_phi * phi) + upset * (law.round_upset + law.round_upset_depth * size)
    slope_plastic = law.slope + upset * (law.slope_upset - law.slope)
    power = round_plastic + mix * (law.round_elastic + law.round_elastic_depth * size - round_plastic)
    power += (1.0 - upset) * law.round_dip * phi * (1.0 - phi)
    return phi**law.share, one, two, three, max(LEAST_ROUND, power), slope_plastic + mix * (law.slope_elastic - slope_plastic)


@inlined
def shape(terms, s):  # type: ignore[no-untyped-def]
    """f/f_max at the share s of the recovery that is left."""
    if s <= 0.0:
        return 0.0
    elastic, one, two, three, power, slope = terms
    t = math.sqrt(s)
    own = s * t * (1.0 + t * (one + t * (two + s * s * three))) / (1.0 + one + two + three)
    if elastic >= 1.0:
        return own
    return elastic * own + (1.0 - elastic) * math.exp((power + slope * s) * math.log(s))


@kernel
def shape_work(terms, s):  # type: ignore[no-untyped-def]
    """Integral of `shape` from 0 to s: closed for the elastic share, Gauss quadrature for the rest."""
    if s <= 0.0:
        return 0.0
    elastic, one, two, three, power, slope = terms
    t = math.sqrt(s)
    own = s * s * t * (0.4 + t * (one / 3.0 + t * (two / 3.5 + s * s * three / 5.5))) / (1.0 + one + two + three)
    if elastic >= 1.0:
        return own
    rest = 0.0
    for j in range(_NODES.size):
        v = 0.5 * (1.0 + _NODES[j])
        at = s * v * v * v
        rest += 0.5 * _SHARES[j] * 3.0 * s * v * v * math.exp((power + slope * at) * math.log(at))
    return elastic * own + (1.0 - elastic) * rest


@kernel
def shape_slope(terms, s):  # type: ignore[no-untyped-def]
    """Derivative of `shape`."""
    elastic, one, two, three, power, slope = terms
    if s <= 0.0:
        return 1.0 - elastic if power <= 1.0 else 0.0
    t = math.sqrt(s)
    own = t * (1.5 + t * (2.0 * one + t * (2.5 * two + s * s * 4.5 * three))) / (1.0 + one + two + three)
    log = math.log(s)
    rest = math.exp((power + slope * s - 1.0) * log) * (power + slope * s * (1.0 + log))
    return elastic * own + (1.0 - elastic) * rest


@kernel
def area_by_slope(terms, stiffness, begun, s):  # type: ignore[no-untyped-def]
    """(a/a_max)^2 along the unloading with these terms; stiffness: 2 E* over pi R Y; begun: recovery, force and area where it begins.

    The stiffness is x times that of the start, which is 1/y of the contact's own 2 E* a_max. What the compliance of the finite body differs
    by from that of the contact (pressed deep, it is stiffer) is taken to stay as it is; so a/a_max = x/(x + y (1 - x)).
    """
    start, slope = shape_slope(terms, 1.0), shape_slope(terms, s)
    if slope >= start:
        return 1.0
    if slope <= 0.0:
        return 0.0
    recovered, load, area = begun
    ratio = slope / (slope + stiffness * math.sqrt(area) * recovered / load * (1.0 - slope / start))
    return ratio * ratio


@kernel
def retreat(terms, phi, stiffness, begun, elastic_begun, own, s):  # type: ignore[no-untyped-def]
    """(a/a_max)^2 along an unloading: the power of `area_by_slope` that would make `own` of the elastic branch, as far as it is elastic.

    elastic_begun: what `begun` would be on the elastic branch.
    """
    if phi >= 1.0 or s <= 0.0:
        return own
    _, one, two, three, _, _ = terms
    elastic, power = area_by_slope((1.0, one, two, three, 1.5, 0.0), stiffness, elastic_begun, s), 1.0
    if own < 1.0 and 0.0 < elastic < 1.0:
        # where the elastic force of a long body is as steep as at the start, `elastic` is 1 and says nothing
        power += phi * (min(MOST_POWER, max(1.0 / MOST_POWER, math.log(own) / math.log(elastic))) - 1.0)
    return area_by_slope(terms, stiffness, begun, s) ** power


@kernel
def area_left(law, depth, load, phi, area, recovered, terms, s):  # type: ignore[no-untyped-def]
    """(a/a_max)^2 while a share s of the recovery from `depth` is left."""
    elastic = elastic_area(law, depth)
    begun, elastic_begun = (recovered, load, area), (depth, elastic_load(law, depth), elastic)
    return retreat(terms, phi, 1.5 * law.stiffness, begun, elastic_begun, elastic_area(law, depth * s) / elastic, s)
