"""Unloading of the whole-range law: the recovered overlap, the shape of the branch, and its work. `law` is the record.

From the largest depth D, s falls from 1 to 0 while the overlap w (over the radius) is recovered. Everything hangs on phi = f/f_el there and
on the share of upsetting. w goes from D (elastic) to the plastic w_pl, which is Mesarovic & Johnson's 2 (1 - nu^2) F/(pi a E) for a contact
small against the body and the springback of a bar of equal volume for D towards 1. The shape is a share e of the elastic branch itself
and 1 - e of s [1 - x1 (1 - sqrt(s)) - x2 (1 - s)]: powers of sqrt(s) whose integral is closed.
"""

from __future__ import annotations

import math

from contactlaws.compiled import kernel
from contactlaws.whole_range_loading import elastic_area, turned


@kernel
def behind(phi):  # type: ignore[no-untyped-def]
    """r^(5/8) with r = f_el/f - 1: the measure of how far from elastic an unloading is, by roots that cost little."""
    root = math.sqrt(1.0 / phi - 1.0)
    return root * math.sqrt(math.sqrt(root))


@kernel
def recovered_depth(law, depth, load, phi, upset, area):  # type: ignore[no-untyped-def]
    """w: the overlap over the radius that unloading from `depth` gives back."""
    if phi >= 1.0:
        return depth
    h = 1.0 - depth
    punch = 2.0 * (1.0 - law.poissons_ratio * law.poissons_ratio * h)
    bar = h * h * math.sqrt(punch * punch / area + 2.25)
    plastic = min(depth, law.compliance * load * bar * math.exp(-depth * h * law.recovery / (1.0 + law.recovery_depth * depth)))
    power = law.fading + turned(upset, law.turn_recovery) * (law.fading_upset - law.fading + law.fading_upset_depth * depth)
    return plastic + (depth - plastic) * math.exp(-power * behind(phi))


@kernel
def shape_terms(law, depth, phi, upset):  # type: ignore[no-untyped-def]
    """Factors of s, s^1.5, s^2, s^2.5 and s^4.5 in f/f_max; they sum to 1."""
    t = math.sqrt(depth)
    one, two, three = law.force_1 * t, law.force_2 * depth, law.force_3 * depth * depth * depth
    upset = turned(upset, law.turn_shape)
    share = phi * (1.0 + (1.0 - phi) * (law.share + upset * (law.share_upset - law.share)))
    elastic = share / (1.0 + one + two + three)
    x1 = law.round + upset * (law.round_upset - law.round + law.round_upset_phi * phi + law.round_upset_depth * depth)
    x2 = phi * law.slope_phi
    x2 += upset * (law.slope_upset + law.slope_upset_phi * phi + law.slope_upset_depth * depth - x2)
    x1 = min(x1, 1.0 - x2)  # no tension at the end
    rest = 1.0 - share
    return rest * (1.0 - x1 - x2), elastic + rest * x1, elastic * one + rest * x2, elastic * two, elastic * three


@kernel
def shape(terms, s):  # type: ignore[no-untyped-def]
    """f/f_max at the share s of the recovery that is left."""
    t = math.sqrt(s)
    return s * (terms[0] + t * (terms[1] + t * (terms[2] + t * (terms[3] + s * s * terms[4]))))


@kernel
def shape_work(terms, s):  # type: ignore[no-untyped-def]
    """Integral of `shape` from 0 to s."""
    t = math.sqrt(s)
    rest = t * (terms[1] / 2.5 + t * (terms[2] / 3.0 + t * (terms[3] / 3.5 + s * s * terms[4] / 5.5)))
    return s * s * (0.5 * terms[0] + rest)


@kernel
def shape_slope(terms, s):  # type: ignore[no-untyped-def]
    """Derivative of `shape`."""
    t = math.sqrt(s)
    return terms[0] + t * (1.5 * terms[1] + t * (2.0 * terms[2] + t * (2.5 * terms[3] + s * s * 4.5 * terms[4])))


@kernel
def retreat(law, depth, phi, s):  # type: ignore[no-untyped-def]
    """(a/a_max)^2: the elastic branch's own, and Mesarovic & Johnson's 1 - (1 - s)^2 where plastic."""
    return phi * elastic_area(law, depth * s) / elastic_area(law, depth) + (1.0 - phi) * s * (2.0 - s)
