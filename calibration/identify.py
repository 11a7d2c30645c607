"""From a measured force-overlap curve to Young's modulus and yield stress, with what the curve does not tell.

The atlas is the forward model. The deviance of a set of parameters is r^T V^-1 r, with r the differences of the forces and V the
covariance of the noise (independent from row to row) and of the atlas's own error (common to whole branches: the force as a whole, its
trend, what unloadings recover, their exponent). The interval of a parameter is its profile likelihood's: all its values at which the
deviance, smallest over the other parameters, is less than 3.84 above its minimum (95 %; Wilks 1938).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from calibration.atlas import Atlas, shipped
from calibration.identify_data import Measured, from_curve
from calibration.identify_model import reading, response_of
from calibration.identify_search import Found, Profile, Task, best, covariance_of, interval, noise_of, start
from calibration.identify_words import correlation_of, statements
from calibration.predict import interpolator
from contactlaws.curve import Curve
from contactlaws.errors import Problem, require
from contactlaws.material import Material

FloatArray = npt.NDArray[np.float64]

#: the covariance is taken at the best fit, which it changes a little: so often
ROUNDS = 2


@dataclass(frozen=True)
class Identified:
    """What a measured curve says about its particle. SI units."""

    #: youngs_modulus, yield_stress, and of poissons_ratio, zero (m), compliance (m/N) those unknown; None: bounded on one side at most
    estimates: Mapping[str, float | None]
    intervals: Mapping[str, tuple[float | None, float | None]]  # 95 %; None: the curve sets no limit within what the atlas holds
    profiles: Mapping[str, Profile]
    names: tuple[str, ...]  # the unknowns, in the order of `correlation`
    correlation: FloatArray  # of the logarithms of E and Y, and of the others
    noise: float  # N; standard deviation of one force, as given or as found
    misfit: float  # rms difference over its expectation; about 1 if the model can be true
    statements: tuple[str, ...]  # what must be known before the numbers are used
    material: Material  # the best fit, also where not all of it is determined; no yield stress: the curve is elastic
    measured: Measured
    fitted_force: FloatArray  # N; the model at the best estimate, row by row
    atlas: str  # content hash


def identify(
    measured: Measured | Curve,
    *,
    poissons_ratio: float | tuple[float, float],
    zero_unknown: bool = False,
    compliance_unknown: bool = False,
    noise: float | None = None,
    atlas: Atlas | None = None,
) -> Identified:
    """Young's modulus and yield stress of the elastic, perfectly plastic sphere behind a measured curve, with 95 % intervals.

    poissons_ratio: given, or an interval that it lies in. zero_unknown: the reading of the overlap at first touch is fitted too.
    compliance_unknown: so is the machine's give, in m/N. noise: standard deviation of the force in N; None: found from the scatter.
    Raises `InputError` for a curve that leaves the atlas, or with no more rows than unknowns.
    """
    data = from_curve(measured) if isinstance(measured, Curve) else measured
    source = interpolator(shipped() if atlas is None else atlas)
    low, high = poissons_ratio if isinstance(poissons_ratio, tuple) else (poissons_ratio, poissons_ratio)
    task = Task(data, source, (low, high), zero_unknown, compliance_unknown)
    require(_problems(task, noise))
    found = best(task, start(task))
    scatter = math.nan
    for _ in range(ROUNDS):
        setting = task.setting(found.vector)
        scatter = noise_of(task, setting) if noise is None else noise
        task = replace(task, whitener=covariance_of(task, setting, scatter))
        found = best(task, setting)
    return _summed_up(task, found, scatter)


def _summed_up(task: Task, found: Found, noise: float) -> Identified:
    setting = task.setting(found.vector)
    intervals = {name: interval(task, found, name) for name in task.unknowns}
    correlation = correlation_of(found.jacobian, task.unknowns)
    misfit = math.sqrt(found.deviance / max(task.measured.force.size - len(task.unknowns), 1))
    deepest = (float(task.measured.overlap.max()) - setting.zero) / task.measured.radius
    response = response_of(task.atlas, setting, deepest)
    yielded = response.yield_depth is not None and response.yield_depth < deepest and intervals["yield_stress"].high is not None
    return Identified(
        estimates={name: None if None in (one.low, one.high) else getattr(setting, name) for name, one in intervals.items()},
        intervals={name: (one.low, one.high) for name, one in intervals.items()},
        profiles={name: one.profile for name, one in intervals.items()},
        names=task.unknowns,
        correlation=correlation,
        noise=noise,
        misfit=misfit,
        statements=tuple(statements(task.measured, intervals, task.unknowns, correlation, misfit, yielded)),
        material=Material(setting.youngs_modulus, setting.poissons_ratio, setting.yield_stress if yielded else None),
        measured=task.measured,
        fitted_force=reading(task.atlas, task.measured, setting).force,
        atlas=task.atlas.atlas.content_hash,
    )


def _problems(task: Task, noise: float | None) -> Iterator[Problem]:
    nodes, (low, high) = task.atlas.atlas.poissons_ratios, task.poissons_ratio
    if not nodes[0] <= low <= high <= nodes[-1]:
        bound = f"must lie in the atlas's [{nodes[0]:g}, {nodes[-1]:g}]"
        yield Problem("poissons_ratio", task.poissons_ratio, bound, "give it, or the lowest and the highest that it can be")
    if noise is not None and not (math.isfinite(noise) and noise > 0.0):
        yield Problem("noise", noise, "must be a positive force", "give its standard deviation in N, or leave it out")
    rows, unknown = task.measured.force.size, (*task.unknowns, *(("noise",) if noise is None else ()))
    if rows <= len(unknown):
        yield Problem("rows", rows, f"are too few for {len(unknown)} unknowns ({', '.join(unknown)})", "measure more states")
    deepest = float(np.ptp(task.measured.overlap) if task.zero_unknown else task.measured.overlap.max()) / task.measured.radius
    limit = float(task.atlas.atlas.depths[-1])
    if deepest > limit:
        yield Problem("overlap", deepest, f"over the radius leaves the atlas, which ends at {limit:g}", "cut the curve there")
