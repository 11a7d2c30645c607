"""What terms and Ting's retreat are worth: error against nanoseconds per contact and bytes of memory.

The material relaxes evenly over six decades, which no few terms describe. Its relaxation, as a table, is fitted with 1, 2, 3, 5 and 8
terms; each law goes through histories that last from milliseconds to minutes, against the continuum with all terms.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from calibration.prony_fit import fit_prony
from calibration.prony_table import PronyTable
from cases.benchmarks.law_cost import Cost, measure
from cases.wahn_gan_kamlah_2022.accuracy import followed
from contactlaws import dispatch
from contactlaws.curve import Curve
from contactlaws.elastic import Hertz
from contactlaws.maxwell_zener import maxwell_zener
from contactlaws.maxwell_zener_ting import maxwell_zener_ting
from contactlaws.prony import PronyViscoelastic, Relaxation, uniaxial
from fem.press_in_time import press_in_time
from fem.programme import Knot, Programme

TERMS = (1, 2, 3, 5, 8)
RADIUS, DEPTH = 5e-6, 0.05
#: twelve times half a decade apart, a twentieth of the modulus each
BROAD: PronyViscoelastic = uniaxial(Relaxation(1770.5e6, (0.05,) * 12, tuple(10.0 ** (-3.0 + 0.5 * k) for k in range(12))), 0.4)
SPRINGS = (4, 12, 32)
HERTZ = "hertz"


class Choice(NamedTuple):
    """One law: its error over the largest force, its cost and its memory."""

    law: str
    terms: int
    springs: int  # remembered by Ting's law; 0 without
    growing: float  # error while the contact grows or rests for the first time
    retreating: float  # after that
    loading: float  # time per contact in the DEM's pair kernel over Hertz's, while it grows
    unloading: float  # while it shrinks
    nanoseconds: float  # per contact there, while it grows
    bytes: int


def histories(depth: float = DEPTH * RADIUS) -> dict[str, Programme]:
    """Ramp, rest, release, meet again, over five decades of time."""
    found: dict[str, Programme] = {}
    for name, unit in (("fast", 0.01), ("middling", 1.0), ("slow", 100.0)):
        knots = ((0.0, 0.0), (1.0, 1.0), (3.0, 1.0), (3.5, 0.3), (4.0, 0.8), (5.0, 0.8), (6.0, 0.0))
        found[name] = tuple(Knot(unit * t, depth * d) for t, d in knots)
    return found


def fitted(terms: int) -> Relaxation:
    """The reduced modulus with fewer terms, from a table of its relaxation."""
    times = np.geomspace(1e-4, 1e3, 141)
    table = PronyTable("relaxation", times, BROAD.reduced.at(times))
    return fit_prony(table, terms=terms).modulus


def laws() -> dict[tuple[int, int], Any]:
    """By terms and springs."""
    found: dict[tuple[int, int], Any] = {}
    for terms in TERMS:
        modulus = fitted(terms)
        found[terms, 0] = maxwell_zener(modulus, RADIUS, BROAD.poissons_ratio)
        for springs in SPRINGS:
            found[terms, springs] = maxwell_zener_ting(modulus, RADIUS, BROAD.poissons_ratio, springs=springs)
    return found


def choices(curves: Mapping[str, Curve]) -> list[Choice]:
    """Every law measured; costs taken in turns with Hertz's."""
    records = laws()
    costs = measure({HERTZ: Hertz(RADIUS, BROAD.reduced.instantaneous), **{f"{n} {k}": law for (n, k), law in records.items()}})
    base = costs[HERTZ]
    return [choice(terms, springs, law, curves.values(), costs[f"{terms} {springs}"], base) for (terms, springs), law in records.items()]


def choice(terms: int, springs: int, law: Any, curves: Sequence[Curve] | Any, cost: Cost, base: Cost) -> Choice:
    """One row."""
    growing, retreating = 0.0, 0.0
    for curve in curves:
        error = abs(followed(law, curve) - curve.force) / curve.force.max()
        growing = max(growing, float(error[curve.branch == 0].max()))
        retreating = max(retreating, float(error[curve.branch > 0].max()))
    name = dispatch.law_of(law).name
    ratios = (cost.pair[0] / base.pair[0], cost.pair[1] / base.pair[1])
    return Choice(name, terms, springs, growing, retreating, *ratios, cost.pair[0], 8 * dispatch.floats_of_state(law))


def references(tolerance: float = 0.005) -> dict[str, Curve]:
    """The continuum with all terms."""
    return {name: press_in_time(BROAD, knots, radius=RADIUS, tolerance=tolerance) for name, knots in histories().items()}
