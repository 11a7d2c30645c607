"""What one term of a Prony series contributes to a measured table, and how that changes with the logarithm of its time.

All three kinds of table are a constant plus amplitudes times these functions, so with the times given the amplitudes are a linear fit.
Ferry, Viscoelastic Properties of Polymers (1980), chapter 3.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

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


class Target(NamedTuple):
    """The numbers to be met, and what a difference is divided by."""

    kind: Kind
    place: FloatArray
    values: FloatArray
    scale: FloatArray

    def columns(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Contributions of the constant and of each term, over the scale, and the terms' derivatives."""
        terms, slopes = TERMS[self.kind](self.place, times)
        constant = np.zeros((self.values.size, 1))
        constant[: self.place.size] = 1.0  # a spring loses nothing
        return np.hstack((constant, terms)) / self.scale[:, None], slopes / self.scale[:, None]

    @property
    def goal(self) -> FloatArray:
        """The numbers over the scale."""
        return self.values / self.scale
