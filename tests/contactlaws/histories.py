"""Histories of viscoelastic contacts for tests: programmes of overlap, and what quadrature and root finding, not springs, say of the force.

All of a sphere of radius 1 whose instantaneous reduced modulus is 3/4: its elastic force is d^1.5.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.integrate import quad
from scipy.optimize import brentq

from contactlaws.foundation import Springs, springs_of
from contactlaws.prony import Relaxation

FloatArray = npt.NDArray[np.float64]

#: instantaneous reduced modulus of a sphere whose elastic force is d^1.5
UNIT = 0.75
PVDF = Relaxation(UNIT, (0.2285,), (1.8,))
STRONG = Relaxation(UNIT, (0.9,), (1.0,))
WIDE = Relaxation(UNIT, (0.2, 0.3, 0.4), (0.1, 1.0, 10.0))
MATERIALS = {"PVDF": PVDF, "90 % relaxing": STRONG, "three terms": WIDE}

#: corners of time and overlap; the largest overlap is 1
PROGRAMMES = {
    "ramp and release": ((0.0, 1.0, 2.0), (0.0, 1.0, 0.0)),
    "fast ramp, slow release": ((0.0, 0.1, 2.0), (0.0, 1.0, 0.0)),
    "hold and release": ((0.0, 1.0, 3.0, 4.0), (0.0, 1.0, 1.0, 0.0)),
    "cycles": ((0.0, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5), (0.0, 1.0, 0.6, 1.0, 0.6, 1.0, 0.0)),
    "growing cycles": ((0.0, 1.0, 1.5, 2.5, 3.0, 4.0, 5.0), (0.0, 0.5, 0.3, 0.8, 0.4, 1.0, 0.0)),
    "re-contact before recovery": ((0.0, 1.0, 1.7, 2.2, 3.0, 4.0), (0.0, 1.0, 0.02, 0.02, 1.0, 0.0)),
    "steps": ((0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0), (0.0, 1.0, 1.0, 0.5, 0.5, 0.9, 0.9)),
}


def programme(name: str, rows: int) -> tuple[FloatArray, FloatArray]:
    """Time and overlap, `rows` from corner to corner."""
    return between(*PROGRAMMES[name], rows)


def between(time: npt.ArrayLike, overlap: npt.ArrayLike, rows: int, graded: bool = False) -> tuple[FloatArray, FloatArray]:
    """Straight lines from corner to corner; graded: as many rows again, ever shorter towards the corner left, where relaxation is fast."""
    share = np.arange(rows) / rows
    if graded:
        share = np.union1d(share, np.geomspace(1e-9, 1.0, rows, endpoint=False))
    columns = []
    for corners in (np.asarray(time, dtype=np.float64), np.asarray(overlap, dtype=np.float64)):
        inner = corners[:-1, None] + np.diff(corners)[:, None] * share
        columns.append(np.append(inner.ravel(), corners[-1]))
    return columns[0], columns[1]


def elastic(overlap: FloatArray) -> FloatArray:
    """Of the instantaneous modulus."""
    return overlap**1.5


def fine_springs(count: int = 800, largest: float = 1.0) -> Springs:
    """So many that their force is off by (largest/count)^2 or so."""
    return springs_of(elastic, largest, count)


def psi(modulus: Relaxation, time: float) -> float:
    """M(t)/M(0)."""
    return float(modulus.at(time)) / modulus.instantaneous


def psi_integral(modulus: Relaxation, time: float) -> float:
    """int_0^t psi."""
    terms = zip(modulus.fractions, modulus.times, strict=True)
    return modulus.long_term / modulus.instantaneous * time - sum(g * tau * np.expm1(-time / tau) for g, tau in terms)


def lee_radok(modulus: Relaxation, time: float, end: float, rate: float = 1.0) -> float:
    """int_0^end psi(t - s) dF_e(rate s)."""
    return float(
        quad(lambda s: psi(modulus, time - s) * 1.5 * rate * np.sqrt(rate * s), 0.0, end, epsabs=1e-13, epsrel=1e-12, limit=400)[0]
    )


def ting(modulus: Relaxation, time: float) -> tuple[float, float]:
    """Force, and the overlap whose elastic contact is as large, of a ramp of overlap 1 in time 1 that turns back at the same speed.

    Ting (1966): F = int_0^t1 psi(t - s) dF_e, where int_t1^t psi(t - s) d'(s) ds = 0; after the turn that is Psi(t - t1) = 2 Psi(t - 1).
    """
    if time <= 1.0:
        return lee_radok(modulus, time, time), time

    def excess(start: float) -> float:
        return psi_integral(modulus, time - start) - 2.0 * psi_integral(modulus, time - 1.0)

    if excess(0.0) <= 0.0:
        return 0.0, 0.0
    start = float(brentq(excess, 0.0, 1.0, xtol=1e-15))
    return lee_radok(modulus, time, start), start


def separation_time(modulus: Relaxation) -> float:
    """When the force of that programme ends."""
    return float(brentq(lambda t: psi_integral(modulus, t) - 2.0 * psi_integral(modulus, t - 1.0), 1.0, 2.0, xtol=1e-14))


def work(overlap: FloatArray, force: FloatArray) -> FloatArray:
    """Done on the body up to each row, by trapezoids."""
    return np.concatenate(([0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(overlap))))
