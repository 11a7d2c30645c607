"""From one curve to its columns in the atlas: a few smooth dimensionless numbers per overlap, relative to what an elastic body does.

Everything is taken relative to the elastic body of the same Poisson's ratio: before first yield all of it is then 0, and beyond it a
smooth function of how far beyond. Loading: ln F/F_el, ln A/A_el (A the contact area). An unloading from the overlap d: ln w/d with
w = d - d_0 recovered, the exponent p(s) of F/F_max = s^p(s), a parabola in s = (d - d_0)/w, and the exponent k(s) of A/A_max = s^k(s) at
fixed s, both less those of the elastic body. The elastic body itself: ln F/F_Hertz, ln A/(R d), and p and k of its loading curve.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from contactlaws.curve import QUANTITIES, Curve
from contactlaws.errors import InputError, Problem

FloatArray = npt.NDArray[np.float64]

#: s at which the exponent of the contact area is kept; in between it is linear in ln s
SHARES = np.array([0.005, 0.02, 0.05, 0.12, 0.3, 0.6, 0.9])
POWERS = 3  # numbers of the parabola p(s)
FORCE, AREA = 0, 1  # columns of the loading
RECOVERED, SHAPE, EDGE = 0, slice(1, 1 + POWERS), slice(1 + POWERS, 1 + POWERS + SHARES.size)  # columns of an unloading
LOADING_COLUMNS, UNLOADING_COLUMNS = 2, 1 + POWERS + SHARES.size
#: ln of the recovered share of the overlap below which a body has yielded, whether its first yield was found or not
PLASTIC = -0.05
#: where the elastic body's loading is read to find the shape of its unloading
ELASTIC_SHARES = np.linspace(0.02, 0.99, 60)


class Columns(NamedTuple):
    """One material: loading at the atlas's depths, unloading from its starts (overlaps over the radius)."""

    yield_depth: float  # overlap over radius at first yield; NaN: not on this curve
    loading: FloatArray  # shape (depths, LOADING_COLUMNS)
    unloading: FloatArray  # shape (starts, UNLOADING_COLUMNS)
    errors: FloatArray  # the finite elements' own estimate, in the order of QUANTITIES


def area_exponent(values: FloatArray, share: FloatArray) -> FloatArray:
    """k(s) from its values at `SHARES`; shape (..., shares)."""
    return values @ _hats(share).T


def _hats(share: FloatArray) -> FloatArray:
    """Weights of the values at `SHARES` in what is linear in ln s between them and constant beyond; shape (shares, SHARES)."""
    return np.array([np.interp(np.log(share), np.log(SHARES), row) for row in np.eye(SHARES.size)]).T


def shape_exponent(values: FloatArray, share: FloatArray) -> FloatArray:
    """p(s) from its coefficients; shape (..., shares)."""
    return values @ np.vander(share, POWERS, increasing=True).T


def fitted_shape(share: FloatArray, force: FloatArray) -> FloatArray:
    """Coefficients of p(s) by least squares of the force; share, force: rows of one unloading strictly between 0 and 1."""
    found = np.array([1.4] + [0.0] * (POWERS - 1))
    for _ in range(20):
        shape = share ** shape_exponent(found, share)
        slope = (shape * np.log(share))[:, None] * np.vander(share, POWERS, increasing=True)
        found = found + np.linalg.lstsq(slope, force - shape, rcond=None)[0]
    return found


def fitted_edge(share: FloatArray, area: FloatArray) -> FloatArray:
    """k(s) at `SHARES` by linear least squares of ln A, weighted to be least squares of A; a weak second difference fills gaps."""
    hats = _hats(share)
    weight = area[:, None]
    smooth = 1e-2 * np.diff(np.eye(SHARES.size), 2, axis=0)
    rows = np.vstack([weight * hats * np.log(share)[:, None], smooth])
    return np.asarray(np.linalg.lstsq(rows, np.concatenate([area * np.log(area), np.zeros(len(smooth))]), rcond=None)[0])


def hertz_force(depth: FloatArray, reduced_modulus: float) -> FloatArray:
    """4/3 E* sqrt(d) d of a body of radius 1 (Hertz 1882)."""
    return 4.0 / 3.0 * reduced_modulus * np.sqrt(depth) * depth


def elastic_columns(curve: Curve, depths: FloatArray, starts: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Loading (depths, 2) and unloading shape (starts, all columns but the recovered overlap) of a body that never yields."""
    assert curve.material is not None
    x, force, area = _loading(curve, curve.material.youngs_modulus)
    factor = np.log(force / hertz_force(x, 1.0 / (1.0 - curve.material.poissons_ratio**2)))
    splines = [CubicSpline(np.log(x), factor), CubicSpline(np.log(x), np.log(area / x))]
    loading = np.array([spline(np.log(depths)) for spline in splines]).T
    unloading = []
    for start in starts:
        inside = ELASTIC_SHARES[ELASTIC_SHARES * start > x[0]]
        to_force, to_area = (np.exp(spline(np.log(inside * start)) - spline(np.log(start))) for spline in splines)
        unloading.append([*fitted_shape(inside, to_force * inside**1.5), *fitted_edge(inside, to_area * inside)])
    return loading, np.array(unloading)


def columns(curve: Curve, elastic: tuple[FloatArray, FloatArray], depths: FloatArray, starts: FloatArray) -> Columns:
    """The columns of a body that may yield, relative to `elastic_columns` of its Poisson's ratio."""
    material = curve.material
    assert material is not None
    x, force, area = _loading(curve, material.youngs_modulus)
    depth = np.log(depths)
    own = hertz_force(x, 1.0 / (1.0 - material.poissons_ratio**2))
    loading = np.array([CubicSpline(np.log(x), np.log(y))(depth) for y in (force / own, area / x)]).T - elastic[0]
    unloading = np.array([_unloading(curve, branch) for branch in branches_from(curve, starts)])
    unloading[:, 1:] -= elastic[1]
    elastic_to = np.inf if curve.yield_overlap is None else curve.yield_overlap / curve.radius
    if curve.yield_overlap is None and unloading[-1, RECOVERED] < PLASTIC:
        elastic_to = 0.0  # the solver did not find first yield, but the body has clearly yielded
    loading[depths <= elastic_to] = 0.0
    unloading[starts <= elastic_to] = 0.0
    errors = np.array([curve.errors.get(name, np.nan) for name in QUANTITIES])
    return Columns(np.nan if curve.yield_overlap is None else elastic_to, loading, unloading, errors)


def starts_of(curve: Curve) -> FloatArray:
    """Overlaps over the radius that the unloadings start from."""
    return np.array([curve.overlap[curve.rows(branch)][0] for branch in curve.unloadings]) / curve.radius


def branches_from(curve: Curve, starts: FloatArray) -> Sequence[int]:
    """The unloadings from `starts`; raises `InputError` if one is missing."""
    there = starts_of(curve)
    found = [int(np.argmin(abs(there - start))) + 1 for start in starts] if there.size else []
    if not found or not np.allclose(there[np.array(found) - 1], starts, rtol=1e-6):
        raise InputError(Problem("unloadings", there.tolist(), f"must start from {starts.tolist()}", "compute this curve anew"))
    return found


def _loading(curve: Curve, modulus: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Overlap, force over E, contact radius squared, for radius 1, without the row at 0."""
    rows = curve.rows(0)
    if curve.contact_radius is None:
        raise InputError(Problem("contact_radius", None, "is needed for an atlas", "give curves of this project's solver"))
    overlap, force, edge = (column[rows][1:] for column in (curve.overlap, curve.force, curve.contact_radius))
    return overlap / curve.radius, force / (modulus * curve.radius**2), (edge / curve.radius) ** 2


def _unloading(curve: Curve, branch: int) -> FloatArray:
    """ln w/d, p and k of one branch, not yet relative to the elastic body."""
    assert curve.contact_radius is not None
    rows = curve.rows(branch)
    overlap, force, edge = curve.overlap[rows], curve.force[rows], curve.contact_radius[rows]
    recovered = overlap[0] - overlap[-1]
    share = (overlap - overlap[-1]) / recovered
    inside = (share > 0.0) & (share < 1.0) & (force > 0.0) & (edge > 0.0)
    shape = fitted_shape(share[inside], (force / force[0])[inside])
    area = fitted_edge(share[inside], (edge[inside] / edge[0]) ** 2)
    return np.array([np.log(min(recovered / overlap[0], 1.0)), *shape, *area])
