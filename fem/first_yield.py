"""Overlap and place of first yield, from a run of its own that resolves the small contact in which a stiff material yields."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contactlaws.elastoplastic import Thornton, thornton_yield_overlap
from contactlaws.material import Material
from fem.assembly import discretise
from fem.mesh import spheroid
from fem.newton import Moduli
from fem.readout import WORK_SHARE, extrapolate
from fem.walk import Walk, walk

DIVISIONS = 6
BEYOND = 1.2  # of the expected overlap


class FirstYield(NamedTuple):
    """Overlap over the half height, and undeformed (r, z) over it."""

    overlap: float
    place: tuple[float, float]


def pressure_at_yield(poissons_ratio: float) -> float:
    """Largest pressure over yield stress when a parabolic body first yields: 1.30 at nu = 0, 1.61 at .3, 1.81 at .45.

    The inverse of the largest von Mises stress on the axis of the Hertz field, at depth z below a contact of radius 1 (Johnson 1985,
    Eqs. 3.45): 3/2 / (1 + z^2) - (1 + nu)(1 - z arctan(1/z)).
    """
    z = np.linspace(0.2, 0.8, 601)  # the maximum is flat and lies at .38 to .55
    return float(1.0 / (1.5 / (1.0 + z * z) - (1.0 + poissons_ratio) * (1.0 - z * np.arctan(1.0 / z))).max())


def expected_yield(material: Material, aspect: float) -> float:
    """Overlap over the half height at which a parabolic body of the pole's curvature would yield; infinite without a yield stress."""
    if material.yield_stress is None:
        return math.inf
    law = Thornton(aspect * aspect, material.reduced_modulus, pressure_at_yield(material.poissons_ratio) * material.yield_stress)
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
    bodies = (discretise(spheroid(n, core, aspect)) for n in (DIVISIONS, DIVISIONS // 2))
    fine, coarse = (walk(body, moduli, min(BEYOND * overlap, 0.3), to_yield=True) for body in bodies)
    return resolved(fine, coarse, 0.0)
