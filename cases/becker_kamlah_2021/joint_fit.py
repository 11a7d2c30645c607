"""All seven constants of the law at once, m, o, p, s, t, u and n, from the forces of all shapes of one material.

Least squares of the force over the largest of each body, as in `readings`, of the bodies in which lambda rises: the blunt ones, whose
lambda only falls, tell none of them. Each body's misfit is one smooth curve and counts as four data, two more than its own two constants.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from cases.becker_kamlah_2021.data import Body
from cases.becker_kamlah_2021.readings import FREE, RADIUS, equation_28, sampled
from cases.becker_kamlah_2021.shape_fit import FASTEST, FEWEST, SLOWEST, Read
from contactlaws.curve import FloatArray
from contactlaws.rivals.becker_kamlah import EXPONENT, PRESSURE_CONSTANTS, RADIUS_CONSTANTS

NAMES = ("m", "o", "p", "s", "t", "u", "n")
#: data that one body counts as
DATA = 4.0
#: where they are sought
LOW = (-50.0, FASTEST, -50.0, -50.0, FASTEST, -50.0, FREE[0])
HIGH = (100.0, SLOWEST, 50.0, 200.0, SLOWEST, 50.0, FREE[1])


class Joint(NamedTuple):
    """Constants of one material."""

    constants: tuple[float, ...]  # in the order of `NAMES`
    errors: tuple[float, ...]  # standard; infinite for those that do nothing
    misfit: float  # root mean square of the force over the largest
    condition: float  # of the scaled Jacobian
    bodies: int


class _Part(NamedTuple):
    relative: float
    radius: FloatArray  # c/c_Y
    area: FloatArray  # of which lambda is the pressure, such that lambda area + base is the force over the largest
    base: float
    force: FloatArray


def _part(body: Body) -> _Part:
    overlap, force = sampled(body)
    largest = float(force[-1])
    area = math.pi * body.radius * (overlap - body.yield_overlap) * body.law.yield_stress / largest
    return _Part(body.relative, np.sqrt(overlap / body.yield_overlap), area, body.yield_force / largest, force / largest)


def _difference(parts: Sequence[_Part], constants: FloatArray) -> FloatArray:
    m, o, p, s, t, u, n = constants.tolist()
    found = []
    for part in parts:
        largest = m * math.exp(o * part.relative) + p
        full = max(s * math.exp(t * part.relative) + u, RADIUS[0])
        found.append(part.area * equation_28(part.radius, largest, full, n) + part.base - part.force)
    return np.concatenate(found)


def fit_all(rows: Sequence[Read]) -> Joint | None:
    """Begun at Eq. 53; None of fewer than `FEWEST` bodies in which lambda rises."""
    parts = [_part(row.body) for row in rows if row.force.risen]
    if len(parts) < FEWEST:
        return None
    scale = max(row.force.radius_ratio for row in rows if row.force.risen) / RADIUS_CONSTANTS[0]
    start = np.array([*PRESSURE_CONSTANTS, *(c * f for c, f in zip(RADIUS_CONSTANTS, (scale, 1.0, 1.0), strict=True)), EXPONENT])
    found = least_squares(lambda constants: _difference(parts, constants), start, bounds=(LOW, HIGH), x_scale=np.abs(start), max_nfev=3000)
    covariance = np.linalg.pinv(found.jac.T @ found.jac) * 2.0 * found.cost / (DATA * len(parts) - len(NAMES))
    lengths = np.linalg.norm(found.jac, axis=0)
    does = lengths > 1e-9 * lengths.max()
    errors = np.where(does, np.sqrt(np.diag(covariance)), np.inf)
    condition = float(np.linalg.cond(found.jac / lengths)) if does.all() else math.inf
    misfit = float(np.sqrt(np.mean(found.fun**2)))
    return Joint(tuple(found.x.tolist()), tuple(errors.tolist()), misfit, condition, len(parts))
