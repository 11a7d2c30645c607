"""The five constants of Eq. 3, fitted again: three readings of the first-yield overlap, three measures of the misfit."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from cases.edmans_sinka_2020 import paper
from cases.edmans_sinka_2020.data import Points
from contactlaws.edmans_sinka import FIRST_YIELD, PUBLISHED

FloatArray = npt.NDArray[np.float64]

READINGS = tuple(FIRST_YIELD)
#: what is made small: the sum of |rho - rho_FE| (the paper), of |ln(rho/rho_FE)|, of its square
MEASURES = ("absolute", "logarithm", "logarithm squared")
RESAMPLES = 100
#: a sum of absolute values is the limit of smooth sums that turn linear ever nearer to zero: at these shares of the mean residual
SHARPENING = (1.0, 0.1, 0.01, 0.001)


class Refit(NamedTuple):
    """Constants of Eq. 3 for one reading and measure."""

    reading: str
    measure: str
    gammas: tuple[float, ...]
    standard_errors: tuple[float, ...]  # from curves drawn again with replacement: errors are common to a curve

    def errors(self, points: Points) -> FloatArray:
        """Absolute relative errors of rho at `points`."""
        return relative_errors(points, self.reading, self.gammas)


def relative_errors(points: Points, reading: str, gammas: tuple[float, ...] = PUBLISHED) -> FloatArray:
    """Absolute relative errors of Eq. 3 against the finite elements."""
    return np.abs(paper.stiffness(points.modulus, points.poisson, points.depth, reading, gammas) / points.stiffness - 1.0)


def percentiles(errors: FloatArray) -> tuple[float, ...]:
    """The paper's four."""
    return tuple(np.percentile(errors, paper.PERCENTILES).tolist())


def _residuals(points: Points, reading: str, measure: str, gammas: FloatArray) -> FloatArray:
    found = paper.stiffness(points.modulus, points.poisson, points.depth, reading, tuple(gammas))
    if measure == "absolute":
        return found - points.stiffness
    return np.log(np.maximum(found / points.stiffness, 1e-6))


def gammas_of(
    points: Points,
    reading: str,
    measure: str,
    weights: FloatArray,
    start: tuple[float, ...] = PUBLISHED,
    shares: tuple[float, ...] = SHARPENING,
) -> tuple[float, ...]:
    """The constants that make the weighted measure smallest; `shares` as in `SHARPENING`."""

    def rows(gammas: FloatArray) -> FloatArray:
        return weights * _residuals(points, reading, measure, gammas)

    inner = np.array(start)
    if measure == "logarithm squared":
        return tuple(least_squares(lambda g: np.sqrt(weights) * _residuals(points, reading, measure, g), inner, x_scale=inner).x.tolist())
    size = float(np.abs(rows(inner)).mean())
    if size == 0.0:
        return start
    for share in shares:
        inner = least_squares(rows, inner, loss="soft_l1", f_scale=share * size, x_scale=np.array(PUBLISHED), max_nfev=200).x
    return tuple(inner.tolist())


def refit(points: Points, reading: str, measure: str, resamples: int = RESAMPLES, seed: int = 0) -> Refit:
    """Fit all points; standard errors from `resamples` draws of as many materials as there are."""
    ones = np.ones(points.depth.size)
    best = gammas_of(points, reading, measure, ones)
    generator = np.random.default_rng(seed)
    materials = np.unique(points.material)
    draws = []
    for _ in range(resamples):
        counts = generator.multinomial(materials.size, np.full(materials.size, 1.0 / materials.size))
        weights = counts[np.searchsorted(materials, points.material)].astype(np.float64)
        draws.append(gammas_of(points, reading, measure, weights, best, SHARPENING[1:3]))
    return Refit(reading, measure, best, tuple(np.std(draws, axis=0, ddof=1).tolist()) if resamples > 1 else (np.nan,) * 5)


def refits(points: Points, resamples: int = RESAMPLES) -> list[Refit]:
    """All readings and measures."""
    return [refit(points, reading, measure, resamples) for reading in READINGS for measure in MEASURES]
