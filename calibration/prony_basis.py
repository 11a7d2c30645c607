"""What a Prony series is fitted to, and what one term contributes to a measured table, with the change by the logarithm of its time.

All three kinds of table are a constant plus amplitudes times these functions, so with the times given the amplitudes are a linear fit.
Ferry, Viscoelastic Properties of Polymers (1980), chapter 3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from calibration.prony_table import Kind

FloatArray = npt.NDArray[np.float64]
#: (times or angular frequencies, relaxation or retardation times) -> values and their derivatives, one column a term
Terms = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


def relaxing(time: FloatArray, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """exp(-t/tau); the constant is the long-term modulus."""
    past = time[:, None] / times
    left = np.exp(-past)
    return left, past * left


def creeping(time: FloatArray, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """1 - exp(-t/lambda); the constant is the instantaneous compliance."""
    past = time[:, None] / times
    return -np.expm1(-past), -past * np.exp(-past)


def oscillating(frequency: FloatArray, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Storage z^2/(1 + z^2) and, in the rows below, loss z/(1 + z^2), with z = omega tau; the constant is the long-term modulus."""
    z = frequency[:, None] * times
    share = 1.0 / (1.0 + z * z)
    return np.vstack((z * z * share, z * share)), np.vstack((2.0 * z * z * share**2, z * (1.0 - z * z) * share**2))


TERMS: dict[Kind, Terms] = {"relaxation": relaxing, "creep": creeping, "dynamic": oscillating}


class Target(Protocol):
    """Numbers that a series is fitted to, and what a difference is divided by."""

    @property
    def goal(self) -> FloatArray:
        """Those numbers, over their scale, that are linear in the amplitudes."""

    @property
    def count(self) -> int:
        """All numbers, also those that are not."""

    @property
    def size(self) -> float:
        """What an amplitude may be like, in its unit."""

    def columns(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Of the numbers in `goal`: contributions of the constant and of each term, over the scale, and the terms' derivatives by the
        logarithms of their times.
        """

    def misses(self, amplitudes: FloatArray, times: FloatArray) -> FloatArray:
        """Differences of all numbers, over their scale."""

    def slopes(self, amplitudes: FloatArray, times: FloatArray) -> FloatArray:
        """Derivatives of `misses` by the amplitudes and by the logarithms of the times."""


class LinearTarget(Target, Protocol):
    """One all of whose numbers are linear in the amplitudes."""

    @property
    def count(self) -> int:
        """All are linear."""
        return int(self.goal.size)

    def misses(self, amplitudes: FloatArray, times: FloatArray) -> FloatArray:
        """Differences over the scale."""
        columns, _ = self.columns(times)
        return np.asarray(columns @ amplitudes - self.goal)

    def slopes(self, amplitudes: FloatArray, times: FloatArray) -> FloatArray:
        """Derivatives of them."""
        columns, slopes = self.columns(times)
        return np.hstack((columns, slopes * amplitudes[1:]))


@dataclass(frozen=True)
class TableTarget(LinearTarget):
    """The numbers of a table."""

    kind: Kind
    place: FloatArray
    values: FloatArray
    scale: FloatArray

    def columns(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The constant is a spring: it loses nothing."""
        terms, slopes = TERMS[self.kind](self.place, times)
        constant = np.zeros((self.values.size, 1))
        constant[: self.place.size] = 1.0
        return np.hstack((constant, terms)) / self.scale[:, None], slopes / self.scale[:, None]

    @property
    def goal(self) -> FloatArray:
        """The numbers over the scale."""
        return self.values / self.scale

    @property
    def size(self) -> float:
        """The largest number."""
        return float(abs(self.values).max())
