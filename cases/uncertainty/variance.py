"""Variance of a two-way layout taken apart: every law on every packing, once each.

    value[i, j] = mean + law[i] + packing[j] + rest[i, j]

with independent random effects. The mean squares of rows, columns and rest have the expectations var_rest + J var_law, var_rest + I
var_packing and var_rest (Searle, Casella & McCulloch 1992, section 4.4.d), which gives the estimates; these may be negative where an
effect is small beside its sampling error. For normal effects the mean squares are independent and in proportion to chi squared, so
intervals come from the values that the expectations may have, given the mean squares that were found (generalised intervals, Weerahandi
1993).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

PARTS = ("law", "packing", "rest")
#: of the distribution of what the expectations may be, and how many of it are drawn
LEVEL, DRAWS = 0.9, 4000


class Parts(NamedTuple):
    """Of each column of values; parts in the order of `PARTS`, shape (3, columns)."""

    mean: FloatArray
    mean_error: FloatArray  # standard error of the mean
    variance: FloatArray  # estimates, unbiased; may be negative
    low: FloatArray  # ends of the interval of each variance, not negative
    high: FloatArray
    share: FloatArray  # of the sum of the variances, each at least zero; NaN where nothing varies
    share_low: FloatArray
    share_high: FloatArray

    @property
    def deviation(self) -> FloatArray:
        """Standard deviation of each part; zero where its variance was estimated as negative."""
        return np.sqrt(np.maximum(self.variance, 0.0))

    @property
    def whole(self) -> FloatArray:
        """Standard deviation of one packing on one law that is as uncertain as the fitted one."""
        return np.asarray(np.sqrt(np.maximum(self.variance, 0.0).sum(axis=0)))


def taken_apart(values: FloatArray, seed: int = 0) -> Parts:
    """The parts of `values`, shape (laws, packings, columns), at least two of each; every column on its own.

    >>> laws, packings = np.array([1.0, 2.0, 3.0]), np.array([10.0, 30.0])
    >>> taken_apart((laws[:, None] + packings)[:, :, None]).variance.ravel().round(12)
    array([  1., 200.,   0.])
    """
    laws, packings, _ = values.shape
    squares = mean_squares(values)
    freedom = np.array([laws - 1, packings - 1, (laws - 1) * (packings - 1)], dtype=np.float64)
    variance = _variances(squares, laws, packings)
    chance = np.random.default_rng(seed).chisquare(freedom[:, None], (DRAWS, 3, 1))
    possible = np.maximum(_variances(freedom[:, None] * squares / chance, laws, packings), 0.0)
    ends = [0.5 * (1.0 - LEVEL), 0.5 * (1.0 + LEVEL)]
    low, high = np.quantile(possible, ends, axis=0)
    share_low, share_high = np.quantile(_shares(possible), ends, axis=0)
    mean = values.mean(axis=(0, 1))
    error = np.sqrt(np.maximum(variance / np.array([[laws], [packings], [laws * packings]]), 0.0).sum(axis=0))
    return Parts(mean, error, variance, low, high, _shares(np.maximum(variance, 0.0)), share_low, share_high)


def mean_squares(values: FloatArray) -> FloatArray:
    """Of laws, packings and rest, shape (3, columns)."""
    laws, packings, _ = values.shape
    mean = values.mean(axis=(0, 1))
    of_law, of_packing = values.mean(axis=1) - mean, values.mean(axis=0) - mean
    rest = values - mean - of_law[:, None] - of_packing[None]
    return np.stack(
        (
            packings * (of_law**2).sum(axis=0) / (laws - 1),
            laws * (of_packing**2).sum(axis=0) / (packings - 1),
            (rest**2).sum(axis=(0, 1)) / ((laws - 1) * (packings - 1)),
        )
    )


def _variances(squares: FloatArray, laws: int, packings: int) -> FloatArray:
    """From mean squares, with the parts along the last axis but one."""
    law, packing, rest = np.moveaxis(squares, -2, 0)
    return np.stack(((law - rest) / packings, (packing - rest) / laws, rest), axis=-2)


def _shares(variances: FloatArray) -> FloatArray:
    whole = variances.sum(axis=-2, keepdims=True)
    return np.divide(variances, whole, out=np.full_like(variances, np.nan), where=whole > 0.0)
