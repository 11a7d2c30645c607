"""From the series that a search found to a modulus, its errors, and how it compares with the others."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from calibration.prony_record import Candidate
from calibration.prony_search import ROUND_OFF, Found, unknowns
from contactlaws.prony import Relaxation, series

FloatArray = npt.NDArray[np.float64]

#: amplitudes below this part of their sum are left out; two times closer than this, relatively, are one
NO_WEIGHT, SAME = 1e-7, 1e-5


def candidates_of(found: Sequence[Found], level: float, data: int) -> tuple[Candidate, ...]:
    """What the best series of 0, 1, 2 ... terms are worth where a difference over its scale is `level` by chance."""
    return tuple(_candidate(number, one.squares / level**2, data) for number, one in enumerate(found))


def _candidate(terms: int, chi_squared: float, data: int) -> Candidate:
    k = unknowns(terms)
    return Candidate(terms, chi_squared, chi_squared + 2 * k + 2 * k * (k + 1) / (data - k - 1), chi_squared + k * math.log(data))


def tidied(found: Found) -> Found:
    """Without terms of no weight, and with those of one time added."""
    kept: list[tuple[float, float]] = []
    for amplitude, time in zip(found.amplitudes[1:].tolist(), found.times.tolist(), strict=True):
        if amplitude <= NO_WEIGHT * found.amplitudes.sum():
            continue
        if kept and time - kept[-1][1] <= SAME * time:
            amplitude += kept.pop()[0]
        kept.append((amplitude, time))
    return Found(np.array([found.amplitudes[0], *(a for a, _ in kept)]), np.array([t for _, t in kept]), found.squares)


def left_over(found: Sequence[Found], data: int) -> tuple[float, str]:
    """What a difference over its scale is by chance, if the series with most terms misses nothing else; and that in words."""
    richest = found[-1]
    level = math.sqrt(richest.squares / (data - unknowns(richest.times.size)))
    return max(level, ROUND_OFF), f"what a series of {richest.times.size} terms leaves over"


def inverse(jacobian: FloatArray) -> FloatArray:
    """What takes errors of the rows, in the base of `left_vectors`, to those of the unknowns; times its transpose it is (J^T J)^-1."""
    length, singular, directions = _decomposed(jacobian)[1:]
    return np.asarray(directions.T / np.maximum(singular, 1e-14 * singular[0]) / length[:, None])


def left_vectors(jacobian: FloatArray) -> FloatArray:
    """The jacobian's left singular vectors."""
    return _decomposed(jacobian)[0]


def _decomposed(jacobian: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Left vectors, lengths of the columns, singular values and right vectors of the columns over their lengths: units lose no digits."""
    length = np.linalg.norm(jacobian, axis=0)
    left, singular, directions = np.linalg.svd(jacobian / length, full_matrices=False)
    return left, length, singular, directions


def of_modulus(found: Found) -> tuple[Relaxation, FloatArray]:
    """The modulus, and the derivatives of its numbers by amplitudes and logarithms of times."""
    terms, total = found.times.size, float(found.amplitudes.sum())
    shares = found.amplitudes[1:] / total
    change = np.zeros((1 + 2 * terms, 1 + 2 * terms))
    change[0, : 1 + terms] = 1.0
    change[1 : 1 + terms, : 1 + terms] = (np.eye(terms, 1 + terms, 1) - shares[:, None]) / total
    change[1 + terms :, 1 + terms :] = np.diag(found.times)
    return series(total, shares.tolist(), found.times.tolist()), change
