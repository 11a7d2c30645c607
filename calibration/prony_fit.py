"""From a measured table to a Prony series, with as many terms as the table supports."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from calibration.prony_basis import TableTarget
from calibration.prony_outcome import candidates_of, inverse, left_over, of_modulus, tidied
from calibration.prony_record import STEP, PronyFit, slopes
from calibration.prony_search import Found, grid, most_terms, search, spectrum, unknowns
from calibration.prony_table import PronyTable
from contactlaws.errors import Problem, require
from contactlaws.prony import Creep, Relaxation

FloatArray = npt.NDArray[np.float64]

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
    candidates = candidates_of(found, level, table.values.size)
    asked = min(candidates, key=lambda one: one.bic).terms if terms is None else terms
    chosen = tidied(found[asked])
    freedom = table.values.size - unknowns(chosen.times.size)
    misfit = math.sqrt(found[asked].squares / freedom) / level
    stated = noise is not None or table.errors is not None
    modulus, change = _of_creep(chosen) if table.kind == "creep" else of_modulus(chosen)
    # amplitudes enter as they are, not by their logarithms: one that is nearly zero has an error all the same
    half = change @ inverse(target.slopes(chosen.amplitudes, chosen.times))
    scatter = max(level * (max(1.0, misfit) if stated else misfit), EPSILON)
    return PronyFit(
        modulus=modulus,
        covariance=scatter**2 * half @ half.T,
        candidates=candidates,
        scatter="stated for each number" if table.errors is not None else f"{100.0 * level:.3g} % of each number",
        noise_from=origin,
        misfit=misfit,
        freedom=freedom,
        asked=asked,
        window=table.window,
        source="table",
        table=table,
        noise=None if table.errors is not None else level,
    )


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


def _target(table: PronyTable) -> TableTarget:
    """The table with what its differences are divided by: the stated errors, else the numbers of a series that fits.

    Not the measured numbers: one that came out low by chance would count for more, and pull the series down. Where no series comes near
    a number, half of what was measured holds.
    """
    scale = abs(table.values) if table.errors is None else table.errors
    target = TableTarget(table.kind, table.place, table.values, scale)
    times = grid(table.window)
    for _ in range(0 if table.errors is not None else 2):  # the second time the weights are right to first order in the noise
        amplitudes, _ = spectrum(target, times)
        fitted = target.columns(times)[0] @ amplitudes * target.scale
        target = replace(target, scale=np.maximum(fitted, 0.5 * table.values))
    return target


def _noise(table: PronyTable, found: list[Found], noise: float | None) -> tuple[float, str]:
    """What a difference over its scale is by chance, and how that is known."""
    if table.errors is not None:
        return 1.0, "stated in the table"
    if noise is not None:
        return noise, "given"
    return left_over(found, table.values.size)


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
