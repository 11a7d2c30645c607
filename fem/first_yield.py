"""Overlap and place of first yield, from a run of its own that resolves the small contact in which a stiff material yields."""

from __future__ import annotations

import math
from typing import NamedTuple

from contactlaws.elastoplastic import Thornton, thornton_yield_overlap
from contactlaws.material import Material
from fem.assembly import discretise
from fem.mesh import spheroid
from fem.newton import Moduli
from fem.readout import WORK_SHARE, extrapolate
from fem.walk import Walk, walk

#: largest pressure over yield stress at first yield, about (exact: 1.30 at nu = 0 to 1.81 at nu = .45); sizes the mesh only
PRESSURE_AT_YIELD = 1.6
DIVISIONS = 6
BEYOND = 1.2  # of the expected overlap; the walk's own margin reaches the exact 1.27 at nu = .45


class FirstYield(NamedTuple):
    """Overlap over the half height, and undeformed (r, z) over it."""

    overlap: float
    place: tuple[float, float]


def expected_yield(material: Material, aspect: float) -> float:
    """Overlap over the half height at which a parabolic body of the pole's curvature would yield; infinite without a yield stress."""
    if material.yield_stress is None:
        return math.inf
    law = Thornton(aspect * aspect, material.reduced_modulus, PRESSURE_AT_YIELD * material.yield_stress)
    return float(thornton_yield_overlap(law))


def resolved(fine: Walk, coarse: Walk, first_row: float) -> FirstYield | None:
    """First yield from the main runs, if it falls where the contact is resolved."""
    if fine.yield_overlap is None or coarse.yield_overlap is None or fine.yield_place is None or fine.yield_overlap < first_row:
        return None
    return FirstYield(float(extrapolate(fine.yield_overlap, coarse.yield_overlap, WORK_SHARE)), fine.yield_place)


def small_run(material: Material, aspect: float, moduli: Moduli) -> FirstYield | None:
    """First yield from two small runs around the expected overlap; None if none is found there."""
    overlap = expected_yield(material, aspect)
    core = min(0.5 * math.sqrt(overlap), 0.2)
    fine, coarse = (walk(discretise(spheroid(n, core, aspect)), moduli, min(BEYOND * overlap, 0.3)) for n in (DIVISIONS, DIVISIONS // 2))
    return resolved(fine, coarse, 0.0)
