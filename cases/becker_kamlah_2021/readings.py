"""lambda_max, epsilon_max and n of one body, read from its finite elements in three ways.

    lambda = (F - F_pY)/(pi Y (c^2 - c_Y^2))                                     Eq. 51, with c^2 = R d, c_Y and F_pY of Hertz at 1.6 Y

At first yield this is 0/0: a force some per cent off Hertz's there, as that of every finite body is, sends lambda to infinity. The paper
does not say how its plateau was read. Here:

    force      least squares of the force by Eqs. 25 to 31 with n = 1.8, from first yield to 15 % of the mean radius, even in the overlap's
               logarithm. The weight c^2 - c_Y^2 disarms the 0/0. It meets the paper's Eq. 54 best, and is the reading of all constants here
    free       the same, with n free between 1 and 8
    plateau    the largest lambda beyond 1.5 delta_Y, up to 15 %, and c/c_Y there; only if lambda has risen to it and does not rise on

Where the fit of the force finds no transition (epsilon at its lower limit: blunt bodies, whose lambda falls from the start), lambda at 15 %
stands for its level.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import least_squares

from cases.becker_kamlah_2021.data import REACH, Body
from contactlaws.curve import FloatArray
from contactlaws.rivals.becker_kamlah import EXPONENT, FIRST

#: overlaps of a fit, first yield to the end
POINTS = 200
#: over that of first yield: where lambda starts to say something, in the reading of the plateau
CLEAR = 1.5
#: constants are sought in these ranges; epsilon at its lower one means that there is no transition to be seen
PRESSURE, RADIUS, FREE = (FIRST + 0.01, 12.0), (1.01, 60.0), (1.0, 8.0)
#: a fit stands for a transition if epsilon is beyond the first and inside the curve by the second: c_max at most so much past its end;
#: epsilon itself is told if its standard error is below the third as a share of it
SEEN, BEYOND, TOLD = 1.05, 1.5, 0.5
#: overlaps over that of first yield from which lambda at the end of the curve says something
LEVEL = 3.0


class Reading(NamedTuple):
    """Constants of one body, and how well they are told."""

    pressure_ratio: float  # lambda_max
    radius_ratio: float  # epsilon_max
    exponent: float  # n
    pressure_error: float  # standard, from the misfit
    radius_error: float
    exponent_error: float | None  # None: held
    misfit: float  # root mean square of the force over the largest
    condition: float  # of the scaled Jacobian
    last: float  # c/c_Y at the end
    level: float  # lambda there

    @property
    def risen(self) -> bool:
        """Whether lambda rises to lambda_max on the curve, or just beyond its end."""
        return SEEN < self.radius_ratio < BEYOND * self.last

    @property
    def seen(self) -> bool:
        """Whether it is told where: epsilon has a value."""
        return self.risen and self.radius_error < TOLD * self.radius_ratio

    @property
    def told(self) -> float | None:
        """lambda_max: of the transition, else the level; None where there is neither."""
        if self.risen:
            return self.pressure_ratio
        return self.level if self.radius_ratio <= SEEN and self.last**2 >= LEVEL else None


class Plateau(NamedTuple):
    """The largest lambda and where it is."""

    pressure_ratio: float
    radius_ratio: float
    at_end: float  # lambda at 15 % over the largest
    at_last: float  # the same at the end of the curve


def pressure_ratio(body: Body, overlap: FloatArray, force: FloatArray) -> FloatArray:
    """lambda of Eq. 51; overlaps in m beyond first yield, forces in N."""
    area = math.pi * body.radius * (overlap - body.yield_overlap)
    return np.asarray((force - body.yield_force) / (area * body.law.yield_stress))


def equation_28(radius: FloatArray, largest: float, full: float, exponent: float) -> FloatArray:
    """lambda at c/c_Y."""
    behind = np.clip((full - radius) / (full - 1.0), 0.0, None)
    return np.asarray(largest - (largest - FIRST) * behind**exponent)


def sampled(body: Body, reach: float = REACH, start: float = 1.02) -> tuple[FloatArray, FloatArray]:
    """Overlaps (m) from `start` times that of first yield to `reach` mean radii, even in their logarithms, and the forces (N) there.

    Stiff bodies yield before their contact is resolved: there they begin with the curve.
    """
    overlap = np.geomspace(max(start * body.yield_overlap, body.overlap[0]), reach * body.mean_radius, POINTS)
    return overlap, np.exp(PchipInterpolator(np.log(body.overlap), np.log(body.force))(np.log(overlap)))


def yields_early(body: Body, factor: float = 2.0) -> bool:
    """Whether the curve goes to `factor` times the overlap of first yield and more, up to 15 %: else there is nothing to fit."""
    return REACH * body.mean_radius > factor * body.yield_overlap


def read(body: Body, free: bool = False) -> Reading:
    """By the fit of the force."""
    overlap, force = sampled(body)
    radius = np.sqrt(overlap / body.yield_overlap)
    area = math.pi * body.radius * (overlap - body.yield_overlap) * body.law.yield_stress / force[-1]
    measured = (force - body.yield_force) / force[-1]

    def difference(constants: FloatArray) -> FloatArray:
        exponent = float(constants[2]) if free else EXPONENT
        return np.asarray(area * equation_28(radius, constants[0], constants[1], exponent) - measured)

    ranges = (PRESSURE, RADIUS, FREE) if free else (PRESSURE, RADIUS)
    starts = ([3.0, share * radius[-1], EXPONENT] for share in (0.5, 0.8, 1.2))
    low, high = zip(*ranges, strict=True)
    found = min(
        (least_squares(difference, np.clip(start[: len(ranges)], low, high), bounds=(low, high), x_scale="jac") for start in starts),
        key=lambda solution: solution.cost,
    )
    errors, condition = _told(found.jac, found.fun)
    return Reading(
        pressure_ratio=float(found.x[0]),
        radius_ratio=float(found.x[1]),
        exponent=float(found.x[2]) if free else EXPONENT,
        pressure_error=float(errors[0]),
        radius_error=float(errors[1]),
        exponent_error=float(errors[2]) if free else None,
        misfit=float(np.sqrt(np.mean(found.fun**2))),
        condition=condition,
        last=float(radius[-1]),
        level=float(measured[-1] / area[-1]),
    )


def _told(jacobian: FloatArray, misfit: FloatArray) -> tuple[FloatArray, float]:
    """Standard errors, and the condition number of the columns scaled to length 1; infinite where a constant does nothing.

    What is left is no noise but one smooth curve: it counts as two data more than there are constants, however many points it has.
    """
    lengths = np.linalg.norm(jacobian, axis=0)
    does = lengths > 1e-12 * lengths.max()
    if not does.all():
        return np.where(does, np.nan, np.inf), math.inf
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * float(np.sum(misfit**2)) / 2.0
    return np.sqrt(np.diag(covariance)), float(np.linalg.cond(jacobian / lengths))


def plateau(body: Body) -> Plateau | None:
    """By the largest lambda; None if it only falls, or still rises at 15 %."""
    overlap, force = sampled(body, start=CLEAR)
    values = pressure_ratio(body, overlap, force)
    top = int(np.argmax(values))
    if top in (0, values.size - 1):
        return None
    last = pressure_ratio(body, body.overlap[-1:], body.force[-1:])
    return Plateau(
        float(values[top]),
        float(np.sqrt(overlap[top] / body.yield_overlap)),
        float(values[-1] / values[top]),
        float(last[0] / values[top]),
    )
