"""From a measured table to a Prony series, with as many terms as the table supports."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from calibration.prony_basis import Target
from calibration.prony_record import STEP, Candidate, PronyFit, slopes
from calibration.prony_search import ROUND_OFF, Found, grid, most_terms, search, spectrum, unknowns
from calibration.prony_table import PronyTable
from contactlaws.errors import Problem, require
from contactlaws.prony import Creep, Relaxation, series

FloatArray = npt.NDArray[np.float64]

#: amplitudes below this part of their sum are left out; two times closer than this, relatively, are one
NO_WEIGHT, SAME = 1e-7, 1e-5
#: differences of a table without noise are round-off
EPSILON = float(np.finfo(np.float64).eps)


def fit_prony(table: PronyTable, terms: int | None = None, noise: float | None = None) -> PronyFit:
    """Fit a Prony series; its number of terms is the one of smallest BIC, or `terms`.

    noise: standard deviation of each number over its true value. Without it the table's own errors hold; without these the noise is what
    the series with most terms leaves over, per degree of freedom. Standard errors are those of the given noise, widened where the
    differences exceed it; if none was given, those that the differences show. What they don't cover: that the number of terms was chosen.

    Raises `InputError` for more terms than the table has numbers for, a noise that is not positive or stated twice, and numbers that are
    not positive where no error is stated.
    """
    require(_problems(table, terms, noise))
    target = _target(table)
    found = search(target, table.window, terms)
    level, origin = _noise(table, found, noise)
    candidates = tuple(_candidate(number, one.squares / level**2, table.values.size) for number, one in enumerate(found))
    asked = min(candidates, key=lambda one: one.bic).terms if terms is None else terms
    chosen = _tidied(found[asked])
    freedom = table.values.size - unknowns(chosen.times.size)
    misfit = math.sqrt(found[asked].squares / freedom) / level
    stated = noise is not None or table.errors is not None
    modulus, covariance = _outcome(target, chosen)
    covariance *= max(level * (max(1.0, misfit) if stated else misfit), EPSILON) ** 2
    return PronyFit(table, modulus, covariance, candidates, None if table.errors is not None else level, origin, misfit, freedom, asked)


def _problems(table: PronyTable, terms: int | None, noise: float | None) -> Iterator[Problem]:
    if terms is not None and not 0 <= terms <= most_terms(table.values.size):
        bound = f"must lie between 0 and {most_terms(table.values.size)} for {table.values.size} numbers"
        yield Problem("terms", terms, bound, "ask for fewer, or leave it out")
    if table.errors is None and not (table.values > 0.0).all():
        first = int(np.argmin(table.values > 0.0))
        yield Problem(
            f"values[{first + 1}]", table.values[first], "must be positive, as noise is a share of it", "leave it out, or state errors"
        )
    if noise is not None and not 0.0 < noise < 1.0:
        yield Problem("noise", noise, "must lie between 0 and 1", "0.01 is 1 % of each number")
    elif noise is not None and table.errors is not None:
        yield Problem("noise", noise, "contradicts the table, which states the error of each number", "leave one of them out")


def _target(table: PronyTable) -> Target:
    """The table with what its differences are divided by: the stated errors, else the numbers of a series that fits.

    Not the measured numbers: one that came out low by chance would count for more, and pull the series down. Where no series comes near
    a number, half of what was measured holds.
    """
    scale = abs(table.values) if table.errors is None else table.errors
    target = Target(table.kind, table.place, table.values, scale)
    times = grid(table.window)
    for _ in range(0 if table.errors is not None else 2):  # the second time the weights are right to first order in the noise
        amplitudes, _ = spectrum(target, times)
        fitted = target.columns(times)[0] @ amplitudes * target.scale
        target = target._replace(scale=np.maximum(fitted, 0.5 * table.values))
    return target


def _noise(table: PronyTable, found: list[Found], noise: float | None) -> tuple[float, str]:
    """What a difference over its scale is by chance, and how that is known."""
    if table.errors is not None:
        return 1.0, "stated in the table"
    if noise is not None:
        return noise, "given"
    richest = found[-1]
    left = table.values.size - unknowns(richest.times.size)
    level = max(math.sqrt(richest.squares / left), ROUND_OFF)
    return level, f"what a series of {richest.times.size} terms leaves over"


def _candidate(terms: int, chi_squared: float, data: int) -> Candidate:
    k = unknowns(terms)
    return Candidate(terms, chi_squared, chi_squared + 2 * k + 2 * k * (k + 1) / (data - k - 1), chi_squared + k * math.log(data))


def _tidied(found: Found) -> Found:
    """Without terms of no weight, and with those of one time added."""
    kept: list[tuple[float, float]] = []
    for amplitude, time in zip(found.amplitudes[1:].tolist(), found.times.tolist(), strict=True):
        if amplitude <= NO_WEIGHT * found.amplitudes.sum():
            continue
        if kept and time - kept[-1][1] <= SAME * time:
            amplitude += kept.pop()[0]
        kept.append((amplitude, time))
    return Found(np.array([found.amplitudes[0], *(a for a, _ in kept)]), np.array([t for _, t in kept]), found.squares)


def _outcome(target: Target, found: Found) -> tuple[Relaxation, FloatArray]:
    """The modulus, and the covariance of its numbers where a difference over its scale is 1 by chance.

    Amplitudes enter as they are, not by their logarithms: one that is nearly zero has an error all the same.
    """
    columns, slope = target.columns(found.times)
    jacobian = np.hstack((columns, slope * found.amplitudes[1:]))
    length = np.linalg.norm(jacobian, axis=0)
    _, singular, directions = np.linalg.svd(jacobian / length, full_matrices=False)
    half = directions.T / np.maximum(singular, 1e-14 * singular[0]) / length[:, None]
    modulus, change = _of_creep(found) if target.kind == "creep" else _of_modulus(found)
    return modulus, change @ half @ half.T @ change.T


def _of_modulus(found: Found) -> tuple[Relaxation, FloatArray]:
    """The modulus, and the derivatives of its numbers by amplitudes and logarithms of times."""
    terms, total = found.times.size, float(found.amplitudes.sum())
    shares = found.amplitudes[1:] / total
    change = np.zeros((1 + 2 * terms, 1 + 2 * terms))
    change[0, : 1 + terms] = 1.0
    change[1 : 1 + terms, : 1 + terms] = (np.eye(terms, 1 + terms, 1) - shares[:, None]) / total
    change[1 + terms :, 1 + terms :] = np.diag(found.times)
    return series(total, shares.tolist(), found.times.tolist()), change


def _of_creep(found: Found) -> tuple[Relaxation, FloatArray]:
    terms = found.times.size

    def modulus(numbers: FloatArray) -> Relaxation:
        first, *jumps = numbers[: 1 + terms].tolist()
        return Creep(first, tuple(jumps), tuple(np.exp(numbers[1 + terms :]).tolist())).relaxation()

    def numbers(of: FloatArray) -> list[float]:
        made = modulus(of)
        return [made.instantaneous, *made.fractions, *made.times]

    place = np.concatenate((found.amplitudes, np.log(found.times)))
    steps = np.concatenate((STEP * found.amplitudes, np.full(terms, STEP)))
    return modulus(place), slopes(numbers, place, steps)
