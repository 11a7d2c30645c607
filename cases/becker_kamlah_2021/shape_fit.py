"""Eq. 52: lambda_max and epsilon_max as functions of R_e/r, for one material after the other; then with constants that follow the material.

    lambda_max = m exp(o R_e/r) + p        epsilon_max = s exp(t R_e/r) + u                                   Eq. 52

Of all materials together m and p, s and u are polynomials c_0 + c_1 L + c_2 L^2 + c_3 nu of L = ln(E/Y) and nu; o and t lie between two
rates, at the logistic function of such a polynomial, since a slow exponential is a straight line of which m and p are not told apart.
epsilon_max, which spans a decade, is taken by its logarithm.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from cases.becker_kamlah_2021.data import Body, Key, Study
from cases.becker_kamlah_2021.readings import Plateau, Reading, plateau, read, yields_early
from contactlaws.curve import FloatArray
from contactlaws.rivals.becker_kamlah import PRESSURE_CONSTANTS, RADIUS_CONSTANTS, levelling

#: Eq. 52 has three constants: a material with fewer readings is left out
FEWEST = 5
#: o and t, over R_e/r that go from .1 to .63: slower is a straight line, faster a step at the sharpest body
SLOWEST, FASTEST = -0.8, -12.0


class Read(NamedTuple):
    """All readings of one body; None where there is nothing to read."""

    body: Body
    force: Reading
    free: Reading
    plateau: Plateau | None


class Shape(NamedTuple):
    """Constants of Eq. 52 of one material, with standard errors, and how far the readings are off."""

    constants: tuple[float, ...]
    errors: tuple[float, ...]
    largest: float  # relative difference at worst
    bodies: int


class Together(NamedTuple):
    """Constants that follow the material."""

    coefficients: FloatArray  # (3, 4): rows the constants of Eq. 52, columns 1, L, L^2, nu
    errors: FloatArray
    typical: float  # root mean square relative difference
    largest: float
    bodies: int
    logarithm: bool

    def __call__(self, key: Key, relative: FloatArray | float) -> FloatArray:
        """At R_e/r, for the material E/Y, nu."""
        value = _curve(self.coefficients @ np.array(terms_of(key)), np.asarray(relative))
        return np.asarray(np.exp(value) if self.logarithm else value)


def readings(study: Study) -> dict[Key, list[Read]]:
    """Of every body that yields early enough, by material."""
    found = {}
    for key in study.plastic:
        bodies = [body for body in study.of(key) if yields_early(body)]
        if bodies:
            found[key] = [Read(body, read(body), read(body, free=True), plateau(body)) for body in bodies]
    return found


def points(rows: Sequence[Read], quantity: str, reading: str) -> tuple[FloatArray, FloatArray]:
    """R_e/r and `quantity` ("pressure_ratio" or "radius_ratio") of the bodies of which it is told, by "force" or "plateau"."""
    values = {row.body.relative: _told(row, quantity, reading) for row in rows}
    told = {relative: value for relative, value in values.items() if value is not None}
    return np.array(list(told)), np.array(list(told.values()))


def _told(row: Read, quantity: str, reading: str) -> float | None:
    if reading == "plateau":
        return None if row.plateau is None else float(getattr(row.plateau, quantity))
    if quantity == "pressure_ratio":
        return row.force.told
    return row.force.radius_ratio if row.force.seen else None


def fit(relative: FloatArray, values: FloatArray, quantity: str) -> Shape | None:
    """Least squares of the relative differences from Eq. 52, begun at Eq. 53; None of fewer than `FEWEST` readings."""
    if values.size < FEWEST:
        return None

    def difference(constants: FloatArray) -> FloatArray:
        return np.asarray((constants[0] * np.exp(constants[1] * relative) + constants[2]) / values - 1.0)

    start = np.array(PRESSURE_CONSTANTS if quantity == "pressure_ratio" else RADIUS_CONSTANTS)
    found = least_squares(difference, start, x_scale=np.abs(start), bounds=([-50.0, FASTEST, -50.0], [100.0, SLOWEST, 50.0]))
    covariance = np.linalg.pinv(found.jac.T @ found.jac) * 2.0 * found.cost / (values.size - 3)
    return Shape(tuple(found.x.tolist()), tuple(np.sqrt(np.diag(covariance)).tolist()), float(np.abs(found.fun).max()), values.size)


def fit_together(read_of: Mapping[Key, Sequence[Read]], quantity: str, reading: str) -> Together | None:
    """Twelve coefficients from all materials; None of fewer than two readings for each."""
    logarithm = quantity == "radius_ratio"
    columns = []
    for key, rows in read_of.items():
        relative, values = points(rows, quantity, reading)
        columns += [(*terms_of(key), x, value) for x, value in zip(relative, values, strict=True)]
    size = len(terms_of((1.0, 0.0)))
    if len(columns) < 6 * size:
        return None
    table = np.array(columns)
    terms, relative, values = table[:, :size], table[:, size], table[:, size + 1]
    measured = np.log(values) if logarithm else values

    def difference(coefficients: FloatArray) -> FloatArray:
        return np.asarray((_curve(coefficients.reshape(3, size) @ terms.T, relative) - measured) / (1.0 if logarithm else values))

    starts = [np.zeros((3, size)) for _ in range(4)]
    for start, (scale, rate) in zip(starts, itertools.product((1.0, 3.0), (-1.0, 0.5)), strict=True):
        start[:, 0] = scale, rate, float(measured.min())
    found = min(
        (least_squares(difference, start.ravel(), x_scale="jac", max_nfev=4000) for start in starts), key=lambda solution: solution.cost
    )
    covariance = np.linalg.pinv(found.jac.T @ found.jac) * 2.0 * found.cost / (values.size - found.x.size)
    return Together(
        found.x.reshape(3, size),
        np.sqrt(np.diag(covariance)).reshape(3, size),
        float(np.sqrt(np.mean(found.fun**2))),
        float(np.abs(found.fun).max()),
        values.size,
        logarithm,
    )


def terms_of(key: Key) -> tuple[float, ...]:
    """1, L, L^2, nu with L = ln(E/Y)."""
    logarithm = math.log(key[0])
    return 1.0, logarithm, logarithm * logarithm, key[1]


def _curve(constants: FloatArray, relative: FloatArray) -> FloatArray:
    """Eq. 52 with the rate given by the logistic function."""
    scale, place, limit = constants
    rate = FASTEST + (SLOWEST - FASTEST) / (1.0 + np.exp(-place))
    return np.asarray(scale * np.exp(rate * relative) + limit)


def published(quantity: str, relative: FloatArray | float) -> FloatArray:
    """Eq. 54."""
    constants = PRESSURE_CONSTANTS if quantity == "pressure_ratio" else RADIUS_CONSTANTS
    return np.array([levelling(float(x), *constants) for x in np.atleast_1d(relative)])
