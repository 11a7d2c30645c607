"""What there is to know about one unloading of a curve, and the rows of a table of all unloadings of many curves.

The unloading stiffness rho = R/(d_max - d_0) and the exponent alpha of F/F_max = ((d - d_0)/(d_max - d_0))^alpha are those of Edmans &
Sinka 2020, Eqs. 1 and 2; both are read as they did it: d_0 is the separation itself, and alpha is the best exponent in least squares at
100 forces in equal steps, so it does not depend on where the rows of the curve stand.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PchipInterpolator

from contactlaws.curve import QUANTITIES, Curve
from contactlaws.unloading_table import UNITS

FloatArray = npt.NDArray[np.float64]

#: equal steps of the force at which the shape of an unloading is read
FORCE_STEPS = 100
#: an unloading whose last force is a larger share of its first one does not end in separation
SEPARATED = 0.01


class Unloading(NamedTuple):
    """One unloading, from the state it leaves (its start) to the separation. SI units; None where the curve does not say."""

    branch: int
    overlap: float  # m; at the start, d_max
    separation_overlap: float  # m; d_0, what is left of the overlap
    force: float  # N; at the start, F_max
    contact_radius: float | None  # m; at the start
    stiffness: float  # rho = R/(d_max - d_0)
    exponent: float  # alpha
    exponent_r2: float  # coefficient of determination of the power law
    recovered_energy: float  # J; work that the unloading gives back
    stored_energy: float | None  # J; at the start
    dissipated_energy: float | None  # J; at the start
    dissipated_on_unloading: float | None  # J; more, from the start to the separation
    plastic: bool | None  # whether it starts beyond first yield


class PowerLaw(NamedTuple):
    """The best power law through an unloading."""

    exponent: float
    r2: float


def unloadings(curve: Curve) -> tuple[Unloading, ...]:
    """All unloadings of a curve that end in separation."""
    return tuple(found for branch in curve.unloadings if (found := unloading(curve, branch)) is not None)


def unloading(curve: Curve, branch: int) -> Unloading | None:
    """The unloading number `branch` of a curve; None if there is no force to begin with, or if it does not end in separation."""
    rows = curve.rows(branch)
    overlap, force = curve.overlap[rows], curve.force[rows]
    if overlap.size < 3 or force[0] <= 0.0 or force[-1] > SEPARATED * force[0] or overlap[-1] >= overlap[0]:
        return None
    shape = power_law(overlap, force)
    dissipated = None if curve.dissipated_energy is None else curve.dissipated_energy[rows]
    return Unloading(
        branch=branch,
        overlap=float(overlap[0]),
        separation_overlap=float(overlap[-1]),
        force=float(force[0]),
        contact_radius=None if curve.contact_radius is None else float(curve.contact_radius[rows][0]),
        stiffness=float(curve.radius / (overlap[0] - overlap[-1])),
        exponent=shape.exponent,
        exponent_r2=shape.r2,
        recovered_energy=recovered_energy(overlap, force),
        stored_energy=None if curve.stored_energy is None else float(curve.stored_energy[rows][0]),
        dissipated_energy=None if dissipated is None else float(dissipated[0]),
        dissipated_on_unloading=None if dissipated is None else float(dissipated[-1] - dissipated[0]),
        plastic=_plastic(curve, float(overlap[0])),
    )


def _plastic(curve: Curve, overlap: float) -> bool | None:
    """A curve of a known material without a yield overlap never yielded."""
    if curve.yield_overlap is not None:
        return overlap > curve.yield_overlap
    return None if curve.material is None else False


def equal_force_steps(overlap: FloatArray, force: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Overlap and force, each from 1 at the start to 0 at the separation, at `FORCE_STEPS` equal steps of the force and the separation.

    overlap, force: one unloading from its start to its separation, any units. Between the rows the logarithms are interpolated, which is
    exact for a power law.
    """
    s = (overlap - overlap[-1]) / (overlap[0] - overlap[-1])
    f = force / force[0]
    s, f = (column[_falling(s) & _falling(f)] for column in (s, f))
    steps = np.arange(FORCE_STEPS, 0, -1) / FORCE_STEPS
    steps = steps[steps >= f[-1]]
    at = np.exp(PchipInterpolator(np.log(f[::-1]), np.log(s[::-1]))(np.log(steps))) if f.size > 1 else np.ones(1)
    return np.append(at, 0.0), np.append(steps[: at.size], 0.0)


def _falling(values: FloatArray) -> npt.NDArray[np.bool_]:
    """The rows that are positive and below all before them: measured and computed unloadings have a little noise near their end."""
    before = np.minimum.accumulate(np.concatenate(([np.inf], values[:-1])))
    return np.asarray((values > 0.0) & (values < before))


def power_law(overlap: FloatArray, force: FloatArray) -> PowerLaw:
    """Best exponent of an unloading (start to separation, any units) in least squares of the force, and its R2.

    >>> s = np.linspace(1.0, 0.0, 30)
    >>> found = power_law(0.02 + 0.01 * s, 5.0 * s**1.357)
    >>> round(found.exponent, 9), round(found.r2, 9)
    (1.357, 1.0)
    """
    from fem.readout import exponent  # not above: the solver takes long to load

    s, f = equal_force_steps(overlap, force)
    best = exponent(s, f)
    s, f = s[:-1], f[:-1]
    return PowerLaw(best, float(1.0 - np.sum((f - s**best) ** 2) / np.sum((f - f.mean()) ** 2)))


def recovered_energy(overlap: FloatArray, force: FloatArray) -> float:
    """Work given back along an unloading: integral of the force over the overlap, by a cubic that does not overshoot between rows."""
    s, first = np.unique(overlap, return_index=True)
    return float(PchipInterpolator(s, force[first]).integrate(s[0], s[-1]))


def table_rows(curves: Iterable[Curve]) -> Iterator[dict[str, Any]]:
    """One row per unloading, keys as in `UNITS`; `error_` is what the curve itself estimates, `curve` its content hash."""
    for curve in curves:
        facts = _facts(curve)
        for found in unloadings(curve):
            values = {**facts, **found._asdict(), "overlap_over_radius": found.overlap / curve.radius}
            yield {name: values[name] for name in UNITS}


def _facts(curve: Curve) -> dict[str, Any]:
    material = curve.material
    place = curve.yield_place or (None, None)
    strength = None if material is None else material.yield_stress
    return {
        "curve": curve.content_hash,
        "youngs_modulus": None if material is None else material.youngs_modulus,
        "poissons_ratio": None if material is None else material.poissons_ratio,
        "yield_stress": strength,
        "modulus_over_yield_stress": None if material is None or strength is None else material.youngs_modulus / strength,
        "radius": curve.radius,
        "aspect": curve.aspect,
        "yield_overlap": curve.yield_overlap,
        "yield_place_r": place[0],
        "yield_place_z": place[1],
        **{f"error_{name}": curve.errors.get(name) for name in QUANTITIES},
        "stopped": curve.stopped,
    }
