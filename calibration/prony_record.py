"""A fitted Prony series with everything that says how good it is."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from calibration.prony_table import PronyTable
from contactlaws.prony import PronyViscoelastic, Relaxation, uniaxial

FloatArray = npt.NDArray[np.float64]
#: of a number, in central differences: their error is then 1e-10 or less
STEP = 1e-5


class Candidate(NamedTuple):
    """One number of terms, and how well the best series of that many fits."""

    terms: int
    chi_squared: float  # differences over their standard errors, squared
    aicc: float  # chi^2 + 2 k + 2 k (k + 1)/(n - k - 1) with k = 1 + 2 terms; Hurvich & Tsai 1989; infinite for too short a table
    bic: float  # chi^2 + k ln n; Schwarz 1978


@dataclass(frozen=True)
class SeriesFit:
    """A fitted series of one modulus, and how far it can be trusted."""

    modulus: Relaxation  # Pa
    covariance: FloatArray  # of the fitted numbers, in the order of `names`
    candidates: tuple[Candidate, ...]
    scatter: str  # what a number may be off by, in words
    noise_from: str  # how that is known, in words
    misfit: float  # root mean square of the differences over that noise, per degree of freedom
    freedom: int  # numbers fitted to less those fitted
    asked: int  # terms that were asked for, or that the criterion chose
    window: tuple[float, float]  # relaxation times in s that can be seen
    source: str  # what it was fitted to: "table", "curves"

    @property
    def terms(self) -> int:
        """How many have a weight."""
        return len(self.modulus.times)

    @property
    def names(self) -> tuple[str, ...]:
        """What was fitted."""
        count = range(1, self.terms + 1)
        return ("instantaneous", *(f"fractions[{i}]" for i in count), *(f"times[{i}]" for i in count))

    @property
    def values(self) -> FloatArray:
        """What was found, in the order of `names`, in Pa and s."""
        return np.array([self.modulus.instantaneous, *self.modulus.fractions, *self.modulus.times])

    @property
    def standard_errors(self) -> Mapping[str, float]:
        """Of the fitted numbers and of the long-term modulus, each in its unit."""
        own = dict(zip(self.names, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))
        return own | {"long_term": float(self.errors_of(lambda modulus: [modulus.long_term])[0])}

    @property
    def correlation(self) -> FloatArray:
        """Of the fitted numbers, in the order of `names`."""
        spread = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(spread, spread))

    def errors_of(self, quantities: Callable[[Relaxation], Sequence[float]]) -> FloatArray:
        """Standard errors of anything that follows from the modulus, to first order (delta method)."""
        steps = STEP * self.values
        left = self.modulus.long_term / self.modulus.instantaneous
        steps[1 : 1 + self.terms] = np.minimum(steps[1 : 1 + self.terms], 1e-3 * left)  # the sum of fractions stays below 1

        def at(numbers: FloatArray) -> Sequence[float]:
            first, *rest = numbers.tolist()
            return quantities(Relaxation(first, tuple(rest[: self.terms]), tuple(rest[self.terms :])))

        spread = np.sqrt(np.diag(self.covariance))
        squares, directions = np.linalg.eigh(self.correlation)  # round-off makes no variance negative
        slope = slopes(at, self.values, steps) * spread
        return np.asarray(np.linalg.norm(slope @ directions * np.sqrt(np.maximum(squares, 0.0)), axis=1))


@dataclass(frozen=True)
class PronyFit(SeriesFit):
    """The series of a table's own modulus: Young's, or that of shear."""

    table: PronyTable
    noise: float | None  # standard deviation of every number of the table over its true value; None: the table states each one's own

    def material(self, poissons_ratio: float, constant_bulk: bool = False) -> PronyViscoelastic:
        """The material with this modulus; poissons_ratio: the instantaneous one. See `contactlaws.prony.uniaxial`.

        Raises `InputError` for a Poisson's ratio that cannot be.
        """
        return self._material(self.modulus, poissons_ratio, constant_bulk)

    def shear_errors(self, poissons_ratio: float, constant_bulk: bool = False) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Standard errors of `material`'s shear fractions and of its relaxation times (delta method, Poisson's ratio being exact)."""

        def series(modulus: Relaxation) -> list[float]:
            made = self._material(modulus, poissons_ratio, constant_bulk)
            return [*made.shear_fractions, *made.relaxation_times]

        errors = self.errors_of(series).tolist() if self.terms else []
        return tuple(errors[: self.terms]), tuple(errors[self.terms :])

    def _material(self, modulus: Relaxation, poissons_ratio: float, constant_bulk: bool) -> PronyViscoelastic:
        if not self.table.shear:
            return uniaxial(modulus, poissons_ratio, constant_bulk)
        made = uniaxial(modulus.scaled(2.0 * (1.0 + poissons_ratio)), poissons_ratio)  # E = 2 (1 + nu) G
        return made._replace(bulk_fractions=(0.0,) * len(modulus.times)) if constant_bulk else made


def slopes(function: Callable[[FloatArray], Sequence[float]], values: FloatArray, steps: FloatArray) -> FloatArray:
    """Derivatives of what `function` gives by each of `values`, one column each, by central differences."""
    sides = [[np.asarray(function(values + sign * step)) for sign in (1.0, -1.0)] for step in np.diag(steps)]
    return np.array([(up - down) / (2.0 * h) for (up, down), h in zip(sides, steps, strict=True)]).T
