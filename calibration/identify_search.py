"""Least squares for `calibration.identify`: the parameters and their bounds, the best of them, and profiles of the deviance."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg import cho_factor, solve_triangular
from scipy.optimize import least_squares

from calibration import atlas_errors
from calibration.atlas_response import Interpolator
from calibration.identify_data import Measured
from calibration.identify_model import Setting, reading

FloatArray = npt.NDArray[np.float64]

#: 95 % of a chi-square with one degree of freedom
LIMIT = 3.841458820694124
#: the strongest body tried, E/Y over the atlas's smallest, where the curve ends before that one yields: all of them are elastic
STRONGEST = 1e-6
#: a curve that would lower its deviance by this for E/Y larger (or smaller) by a factor of e is held back by the atlas's end
PULL = 0.5
#: E/Y tried for a start
STARTS = 25
#: most steps outwards, and steps that narrow an end of an interval down
OUTWARDS, INWARDS = 12, 10
#: where a profile is filled in between the minimum and an end of its interval
FILL = (0.35, 0.7)
NAMES = ("youngs_modulus", "yield_stress", "poissons_ratio", "zero", "compliance")


class Profile(NamedTuple):
    """Deviance above its minimum against one parameter (SI), the others at their best for each of its values."""

    values: FloatArray  # ascending
    deviance: FloatArray


@dataclass(frozen=True)
class Task:
    """A measurement, what is unknown about it, and the covariance of its differences from the model.

    Parameters are searched as a vector: ln of E or of Y (whichever is named first), ln E/Y, then Poisson's ratio, zero over R, compliance
    times F_max over the largest overlap, as far as they are unknown.
    """

    measured: Measured
    atlas: Interpolator
    poissons_ratio: tuple[float, float]  # both the same: given
    zero_unknown: bool
    compliance_unknown: bool
    whitener: FloatArray | None = field(default=None, repr=False)  # lower Cholesky factor of the covariance; None: unit noise

    @property
    def others(self) -> tuple[str, ...]:
        """The unknowns beside E and Y."""
        unknown = (self.poissons_ratio[0] < self.poissons_ratio[1], self.zero_unknown, self.compliance_unknown)
        return tuple(name for name, is_unknown in zip(NAMES[2:], unknown, strict=True) if is_unknown)

    @property
    def unknowns(self) -> tuple[str, ...]:
        """All of them."""
        return NAMES[:2] + self.others

    @property
    def compliance_unit(self) -> float:
        """m/N; a machine that gives way as much as the particle at the largest force."""
        return float(np.ptp(self.measured.overlap) / self.measured.force.max())

    def setting(self, vector: FloatArray, first: str = "youngs_modulus") -> Setting:
        """The meaning of a vector whose first entry is ln of `first`."""
        ratio, leading = math.exp(vector[1]), math.exp(vector[0])
        modulus = leading if first == "youngs_modulus" else leading * ratio
        more = dict(zip(self.others, vector[2:].tolist(), strict=True))
        return Setting(
            modulus,
            modulus / ratio,
            more.get("poissons_ratio", self.poissons_ratio[0]),
            more.get("zero", 0.0) * self.measured.radius,
            more.get("compliance", 0.0) * self.compliance_unit,
        )

    def vector(self, setting: Setting, first: str = "youngs_modulus") -> FloatArray:
        """The inverse of `setting`."""
        scale = {"poissons_ratio": 1.0, "zero": self.measured.radius, "compliance": self.compliance_unit}
        ratio = setting.youngs_modulus / setting.yield_stress
        return np.array(
            [math.log(getattr(setting, first)), math.log(ratio), *(getattr(setting, name) / scale[name] for name in self.others)]
        )

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest entries of a vector."""
        nodes, deepest = self.atlas.atlas.modulus_ratios, float(self.measured.overlap.max()) / self.measured.radius
        strongest = self.atlas(float(nodes[0]), self.poissons_ratio[0]).yield_depth
        elastic = strongest is None or deepest < 0.98 * strongest
        shallow = float(self.measured.overlap.min()) / self.measured.radius
        span = float(np.ptp(self.measured.overlap)) / self.measured.radius
        low = {
            "poissons_ratio": self.poissons_ratio[0],
            "zero": max(shallow - span, deepest - self.atlas.atlas.depths[-1]),
            "compliance": 0.0,
        }
        high = {"poissons_ratio": self.poissons_ratio[1], "zero": shallow + 0.9 * span, "compliance": 0.95}
        ratio = (math.log(nodes[0] * (STRONGEST if elastic else 1.0)), math.log(nodes[-1]))
        return (
            np.array([-math.inf, ratio[0], *(low[name] for name in self.others)]),
            np.array([math.inf, ratio[1], *(high[name] for name in self.others)]),
        )

    def residuals(self, setting: Setting) -> FloatArray:
        """Differences of the forces in standard deviations, made independent."""
        difference = reading(self.atlas, self.measured, setting).force - self.measured.force
        if self.whitener is None:
            return difference / float(self.measured.force.max())
        return np.asarray(solve_triangular(self.whitener, difference, lower=True, check_finite=False))


class Found(NamedTuple):
    """A minimum of the deviance."""

    vector: FloatArray
    deviance: float
    jacobian: FloatArray
    at_bound: bool  # E/Y lies at the end of what the atlas holds, and the curve would rather have it go on


def start(task: Task) -> Setting:
    """E/Y from a grid, E by least squares: the force is proportional to it at a given E/Y."""
    low, high = task.bounds()
    nu = 0.5 * (task.poissons_ratio[0] + task.poissons_ratio[1])
    zero = float(np.clip(0.0, low[2 + task.others.index("zero")], None)) if task.zero_unknown else 0.0
    force, tried = task.measured.force, []
    for ratio in np.exp(np.linspace(max(low[1], math.log(0.5)), high[1], STARTS)):
        one = Setting(1.0, 1.0 / ratio, nu, zero * task.measured.radius, 0.0)
        shape = reading(task.atlas, task.measured, one).force
        modulus = float(shape @ force / (shape @ shape))
        tried.append((float(((modulus * shape - force) ** 2).sum()), Setting(modulus, modulus / ratio, nu, one.zero, 0.0)))
    return min(tried)[1]


def best(task: Task, begin: Setting, first: str = "youngs_modulus", held: tuple[int, float] | None = None) -> Found:
    """The least deviance from `begin` on; with `held`, an entry of the vector (its number and value) stays as it is."""
    low, high = task.bounds()
    vector = task.vector(begin, first)
    free = np.ones(vector.size, dtype=bool)
    if held is not None:
        free[held[0]], vector[held[0]] = False, held[1]

    def difference(part: FloatArray) -> FloatArray:
        whole = vector.copy()
        whole[free] = part
        return task.residuals(task.setting(whole, first))

    margin = 1e-6 * np.where(np.isfinite(high - low), high - low, 1.0)[free]
    inside = np.clip(vector[free], low[free] + margin, high[free] - margin)
    limits = (low[free], high[free])
    result = least_squares(difference, inside, bounds=limits, x_scale="jac", xtol=1e-8, ftol=1e-8, gtol=1e-8, max_nfev=40)
    vector[free] = result.x
    gradient = 2.0 * float(result.grad[np.count_nonzero(free[:1])])  # of the deviance, against ln E/Y
    at_bound = (vector[1] - low[1] < 1e-3 and gradient > PULL) or (high[1] - vector[1] < 1e-3 and gradient < -PULL)
    return Found(vector, 2.0 * float(result.cost), np.asarray(result.jac), bool(at_bound))


def noise_of(task: Task, setting: Setting) -> float:
    """Standard deviation of the force's noise in N: from how each row differs from the mean of its neighbours, the model taken off.

    What the model misses is smooth and hardly enters; on a curve without noise the smallest noise that arithmetic can bear is taken.
    """
    rest = reading(task.atlas, task.measured, setting).force - task.measured.force
    scatter = []
    for branch in (0, *task.measured.unloadings):
        part = rest[task.measured.rows(branch)]
        if part.size > 2:
            scatter.append(part[1:-1] - 0.5 * (part[2:] + part[:-2]))
    largest = float(task.measured.force.max())
    if not scatter:
        return max(float(np.std(rest)), 1e-4 * largest)
    return max(math.sqrt(float(np.mean(np.concatenate(scatter) ** 2)) / 1.5), 1e-4 * largest)


def covariance_of(task: Task, setting: Setting, noise: float) -> FloatArray:
    """Lower Cholesky factor of the covariance: noise, and the atlas's own error at `setting`, which whole branches share."""
    measured, found = task.measured, reading(task.atlas, task.measured, setting)
    deepest = max((float(measured.overlap.max()) - setting.zero) / measured.radius, 1e-9)
    expected = atlas_errors.expected(task.atlas.atlas, setting.youngs_modulus / setting.yield_stress, setting.poissons_ratio, deepest).total
    depth = np.maximum((measured.overlap - setting.zero) / measured.radius, 1e-3 * deepest)
    # half the variance of the force's error is common to the curve, half is a trend over the logarithm of the overlap
    trend = np.clip(1.0 + np.log(depth / deepest) / math.log(5.0), -1.0, 1.0)
    share = expected["force"] / math.sqrt(2.0)
    modes = [share * found.force, share * found.force * trend]
    modes += [expected["unloading_stiffness"] * found.slope_of_overlap, expected["unloading_exponent"] * found.slope_of_exponent]
    shared = np.array(modes).T
    covariance = noise**2 * np.eye(found.force.size) + shared @ shared.T
    return np.asarray(np.tril(cho_factor(covariance, lower=True)[0]))


class Interval(NamedTuple):
    """What the deviance allows; None: no limit within what the atlas holds."""

    low: float | None
    high: float | None
    profile: Profile


def interval(task: Task, found: Found, name: str) -> Interval:
    """Profile of one unknown around the minimum (which is `found` for ln E first), by stepping outwards and narrowing down."""
    centre = task.setting(found.vector)
    points = {_coordinate(task, centre, name): 0.0}
    ends = [_end(task, found, centre, name, side, points) for side in (-1.0, 1.0)]
    for end in ends:
        for share in FILL if end is not None else ():
            x = (1.0 - share) * _coordinate(task, centre, name) + share * (end or 0.0)
            points[x] = _held(task, centre, name, x)[0] - found.deviance
    at = sorted(points)
    values = np.array([_value(task, x, name) for x in at])
    low, high = (None if end is None else _value(task, end, name) for end in ends)
    return Interval(low, high, Profile(values, np.array([max(points[x], 0.0) for x in at])))


def _coordinate(task: Task, setting: Setting, name: str) -> float:
    if name in NAMES[:2]:
        return math.log(getattr(setting, name))
    return float(task.vector(setting)[2 + task.others.index(name)])


def _value(task: Task, coordinate: float, name: str) -> float:
    if name in NAMES[:2]:
        return math.exp(coordinate)
    return coordinate * {"poissons_ratio": 1.0, "zero": task.measured.radius, "compliance": task.compliance_unit}[name]


def _standard_error(task: Task, found: Found, name: str) -> float:
    """From the curvature at the minimum; a tenth where that says nothing."""
    covariance = np.linalg.pinv(found.jacobian.T @ found.jacobian, rcond=1e-12)
    direction = np.zeros(found.vector.size)
    direction[0 if name in NAMES[:2] else 2 + task.others.index(name)] = 1.0
    if name == "yield_stress":
        direction[1] = -1.0
    error = math.sqrt(max(float(direction @ covariance @ direction), 0.0))
    return float(np.clip(error, 1e-5, 0.1)) if math.isfinite(error) else 0.1


def _end(task: Task, found: Found, centre: Setting, name: str, side: float, points: dict[float, float]) -> float | None:
    """Where the deviance passes the limit on one side; every point tried is kept in `points`."""
    middle = _coordinate(task, centre, name)
    inside, outside, warm, step = middle, math.nan, centre, 2.0 * side * _standard_error(task, found, name)
    for _ in range(OUTWARDS):
        x, edge = _clipped(task, middle + step, name)
        deviance, warm, at_bound = _held(task, warm, name, x)
        points[x] = deviance - found.deviance
        if points[x] > LIMIT:
            outside = x
            break
        if edge or at_bound:
            return None
        inside, step = x, 2.5 * step
    if math.isnan(outside):
        return None
    forced = at_bound
    for trial in range(INWARDS):
        # the deviance is nearly a parabola, so its root is nearly linear; every other time halving, in case it is not
        low, high = math.sqrt(max(points[inside], 0.0)), math.sqrt(points[outside])
        share = float(np.clip((math.sqrt(LIMIT) - low) / max(high - low, 1e-12), 0.05, 0.95)) if trial % 2 == 0 else 0.5
        x = inside + share * (outside - inside)
        deviance, warm, at_bound = _held(task, warm, name, x)
        points[x] = deviance - found.deviance
        if abs(points[x] - LIMIT) < 0.05:
            return None if at_bound else x
        inside, outside, forced = (x, outside, forced) if points[x] < LIMIT else (inside, x, at_bound)
    # where the deviance only rises because E/Y must not go on, the curve itself sets no limit
    return None if forced else x


def _clipped(task: Task, x: float, name: str) -> tuple[float, bool]:
    """A coordinate within its bounds, and whether it lies on one."""
    if name in NAMES[:2]:
        return x, False
    low, high = (bound[2 + task.others.index(name)] for bound in task.bounds())
    return float(np.clip(x, low, high)), not low < x < high


def _held(task: Task, warm: Setting, name: str, coordinate: float) -> tuple[float, Setting, bool]:
    """The least deviance with one unknown held, its setting, and whether E/Y ended at the atlas's end."""
    if name in NAMES[:2]:
        found = best(task, warm._replace(**{name: math.exp(coordinate)}), name, (0, coordinate))
        return found.deviance, task.setting(found.vector, name), found.at_bound
    found = best(task, warm, held=(2 + task.others.index(name), coordinate))
    return found.deviance, task.setting(found.vector), found.at_bound
