"""Many cubic splines at once, each 0 with slope 0 up to a point of its own and smooth beyond it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

#: a node this near to first yield (in the logarithm) says no more than first yield itself, and its noise would be magnified
NEAR_YIELD = 0.05


class Splines(NamedTuple):
    """Hermite form: abscissae, values and slopes; leading axes count the splines, the last one of `values` and `slopes` the columns."""

    at: FloatArray  # (..., nodes); never falls
    values: FloatArray  # (..., nodes, columns)
    slopes: FloatArray  # (..., nodes, columns)


def from_onset(onset: FloatArray, nodes: FloatArray, values: FloatArray) -> Splines:
    """Splines over node - onset: 0 (value and slope) at 0, through `values` beyond, without curvature at the last node.

    onset: (...); nodes: (nodes,) ascending; values: (..., nodes, columns), not looked at up to the onset.

    >>> line = from_onset(np.array(1.0), np.array([0.0, 2.0, 3.0]), np.array([[9.0], [1.0], [2.0]]))
    >>> evaluate(line, np.array([-1.0, 0.0, 1.0, 2.0])).round(12).ravel().tolist()
    [0.0, 0.0, 1.0, 2.0]
    """
    x = nodes - onset[..., None]
    beyond = x > NEAR_YIELD
    zeros = np.zeros((*x.shape[:-1], 1))
    # nodes before the onset are laid upon it; they are passed over, since their interval is empty
    at = np.concatenate((zeros, np.where(beyond, x, 0.0)), axis=-1)
    known = np.concatenate((zeros[..., None] * values[..., :1, :], np.where(beyond[..., None], values, 0.0)), axis=-2)
    return Splines(at, known, _slopes(at, known))


def _slopes(at: FloatArray, values: FloatArray) -> FloatArray:
    """Slopes that make the second derivative continuous (a tridiagonal system, eliminated forwards), 0 wherever `at` is 0."""
    step = np.diff(at)[..., None]
    inverse = np.divide(1.0, step, out=np.zeros_like(step), where=step > 0.0)
    chord = np.diff(values, axis=-2) * inverse
    size = at.shape[-1]
    upper, right = np.zeros((*at.shape, 1)), np.zeros_like(values)
    for k in range(1, size):
        before = inverse[..., k - 1, :]
        after = inverse[..., k, :] if k + 1 < size else np.zeros_like(before)
        load = 3.0 * chord[..., k - 1, :] * before + (3.0 * chord[..., k, :] * after if k + 1 < size else 0.0)
        pivot = 2.0 * (before + after) - before * upper[..., k - 1, :]
        free = (at[..., k, None] > 0.0) & (pivot > 0.0)
        upper[..., k, :] = np.divide(after, pivot, out=np.zeros_like(pivot), where=free)
        right[..., k, :] = np.where(free, (load - before * right[..., k - 1, :]) / np.where(free, pivot, 1.0), 0.0)
    slopes = right
    for k in range(size - 2, 0, -1):
        slopes[..., k, :] -= upper[..., k, :] * slopes[..., k + 1, :]
    return slopes


def evaluate(splines: Splines, query: FloatArray) -> FloatArray:
    """Values at `query`, whose leading axes are those of the splines (or none: all splines at the same points) and whose last counts
    points: (..., points, columns). 0 before the onset, straight beyond the last node.
    """
    at, values, slopes = splines
    query = np.broadcast_to(query, (*at.shape[:-1], query.shape[-1]))
    x = np.clip(query, 0.0, at[..., -1:])
    left = np.clip((at[..., None, :] <= x[..., None]).sum(-1) - 1, 0, at.shape[-1] - 2)
    low, high = (np.take_along_axis(at, left + i, axis=-1)[..., None] for i in (0, 1))
    (y0, y1), (m0, m1) = ([np.take_along_axis(column, (left + i)[..., None], axis=-2) for i in (0, 1)] for column in (values, slopes))
    h = np.maximum(high - low, 1e-300)
    t = np.clip((x[..., None] - low) / h, 0.0, 1.0)
    inside = y0 + t * h * m0 + t * t * (3.0 * (y1 - y0) - h * (2.0 * m0 + m1)) + t**3 * (2.0 * (y0 - y1) + h * (m0 + m1))
    return np.asarray(inside + slopes[..., -1:, :] * np.maximum(query - at[..., -1:], 0.0)[..., None])
