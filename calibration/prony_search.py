"""The best Prony series of each number of terms: non-negative least squares on a dense grid of times, from there refined.

On a grid the fit is a convex problem with one solution (the positive spectrum that fits best), but it puts two neighbours where there is
one time. Grouping them gives starts that no nonlinear fit would find alone; others come from the best series with one term less.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares, nnls

from calibration.prony_basis import Target

FloatArray = npt.NDArray[np.float64]

#: grid times per decade; more adds nothing, as neighbours are then alike to below the noise of any test
DENSITY = 12
#: times are sought up to this factor outside the window: further away a term is a constant or nothing
BEYOND = 10.0
MOST_TERMS = 20
#: amplitudes, over what they may be like, are kept above this: a long-term modulus of zero would be a fluid's
SMALLEST, LARGEST = 1e-9, 1e3
#: relative accuracy that no table exceeds; below it residuals are round-off and choose nothing
ROUND_OFF = 1e-9
#: the search ends when so many further terms in a row were not worth their parameters
PATIENCE = 3
#: relative change of the sum of squares at which a start is compared with others, and at which the best of them ends
ROUGH, EXACT = 1e-2, 1e-10
MOST_STEPS = 200


class Found(NamedTuple):
    """A series with amplitudes in the unit of the table, the constant first."""

    amplitudes: FloatArray
    times: FloatArray  # s, rising
    squares: float  # sum of the squared differences over the scale


def unknowns(terms: int) -> int:
    """A constant, and amplitude and time of each term."""
    return 1 + 2 * terms


def most_terms(data: int) -> int:
    """How many terms so many numbers can be asked about: two numbers more than unknowns are left (n > k + 1, as AICc needs it)."""
    return min(MOST_TERMS, (data - 3) // 2)


def grid(window: tuple[float, float]) -> FloatArray:
    """Times on a logarithmic grid, beyond the window at both ends."""
    low, high = window[0] / BEYOND, window[1] * BEYOND
    return np.geomspace(low, high, 1 + int(np.ceil(DENSITY * np.log10(high / low))))


def spectrum(target: Target, times: FloatArray) -> tuple[FloatArray, float]:
    """The non-negative amplitudes, the constant first, that fit best with these times; and the sum of squares."""
    columns, _ = target.columns(times)
    size = np.linalg.norm(columns, axis=0)
    size[size == 0.0] = 1.0
    amplitudes, norm = nnls(columns / size, target.goal, maxiter=50 * size.size)
    return amplitudes / size, float(norm**2)


def search(target: Target, window: tuple[float, float], terms: int | None = None) -> list[Found]:
    """The best series of 0, 1, 2 ... terms, until more are not worth it; up to `terms` at least, if that is given.

    Worth is judged here by n ln(sum of squares) + k ln n, which needs no noise level.
    """
    places = grid(window)
    amplitudes, _ = spectrum(target, places)
    lines = [(float(a), float(t)) for a, t in zip(amplitudes[1:], places, strict=True) if a > 0.0]
    data = target.count
    found: list[Found] = []
    worths: list[float] = []
    for number in range(most_terms(data) + 1):
        starts = _starts(target, window, lines, number, found[-1] if found else None)
        roughly = min((_refined(target, window, start, ROUGH) for start in starts), key=lambda one: one.squares)
        exactly = _refined(target, window, roughly.times, EXACT)
        found.append(min([exactly, roughly, *found[-1:]], key=lambda one: one.squares))
        squares = max(found[-1].squares, ROUND_OFF**2 * float(target.goal @ target.goal))
        worths.append(data * np.log(squares) + unknowns(number) * np.log(data))
        if number >= (terms or 0) and number - int(np.argmin(worths)) >= PATIENCE:
            break
    return found


def _starts(
    target: Target, window: tuple[float, float], lines: list[tuple[float, float]], number: int, fewer: Found | None
) -> Iterator[FloatArray]:
    """Times to start from: none twice, and never the same as another."""
    if fewer is None:
        yield np.zeros(0)
        return
    if len(lines) >= number:
        yield _grouped(lines, number)
    yield np.geomspace(*window, number + 2)[1:-1]
    ends = np.array([window[0] / np.sqrt(BEYOND), *fewer.times, window[1] * np.sqrt(BEYOND)])
    added = [np.sort([*fewer.times, np.sqrt(a * b)]) for a, b in zip(ends[:-1], ends[1:], strict=True)]
    yield from sorted(added, key=lambda times: spectrum(target, times)[1])[:2]


def _grouped(lines: list[tuple[float, float]], number: int) -> FloatArray:
    """Times of `number` groups of lines of a spectrum, each the mean of its logarithms.

    Those neighbours are joined first that move least when they are (Ward's criterion).
    """
    weight = [a for a, _ in lines]
    place = [float(np.log(t)) for _, t in lines]
    while len(weight) > number:
        costs = [a * b / (a + b) * (y - x) ** 2 for a, b, x, y in zip(weight[:-1], weight[1:], place[:-1], place[1:], strict=True)]
        i = int(np.argmin(costs))
        both = weight[i] + weight[i + 1]
        place[i : i + 2] = [(weight[i] * place[i] + weight[i + 1] * place[i + 1]) / both]
        weight[i : i + 2] = [both]
    return np.exp(place)


def _refined(target: Target, window: tuple[float, float], times: FloatArray, accuracy: float) -> Found:
    """Least squares in the logarithms of amplitudes and times from the best amplitudes of `times` on."""
    size = target.size
    terms = times.size
    low = np.log([*[SMALLEST * size] * (1 + terms), *[window[0] / BEYOND] * terms])
    high = np.log([*[LARGEST * size] * (1 + terms), *[window[1] * BEYOND] * terms])
    amplitudes, _ = spectrum(target, times)
    start = np.log([*np.maximum(amplitudes, 1e-4 * size), *times])

    def difference(inner: FloatArray) -> FloatArray:
        return target.misses(np.exp(inner[: 1 + terms]), np.exp(inner[1 + terms :]))

    def jacobian(inner: FloatArray) -> FloatArray:
        amplitudes = np.exp(inner[: 1 + terms])
        slopes = target.slopes(amplitudes, np.exp(inner[1 + terms :]))
        return slopes * np.concatenate((amplitudes, np.ones(terms)))

    start = np.clip(start, low + 1e-9, high - 1e-9)
    limits = {"xtol": accuracy, "ftol": accuracy, "gtol": 1e-15, "max_nfev": MOST_STEPS}
    result = least_squares(difference, start, jacobian, (low, high), x_scale="jac", **limits)
    order = np.argsort(result.x[1 + terms :])
    amplitudes = np.exp(result.x[: 1 + terms])
    return Found(np.array([amplitudes[0], *amplitudes[1:][order]]), np.exp(result.x[1 + terms :][order]), 2.0 * float(result.cost))
