"""From the discrete states of two meshes to one smooth curve with an error estimate.

Force: the work done up to the instants of landing is smooth in the overlap, though the force between them is a sawtooth (nodes land one by
one); the force is the derivative of a spline through the logarithm of that work. Work is taken as stored plus dissipated energy.
A mesh half as fine says what is left: elements are proportional to the distance from the pole and steps to the elements, so a quantity has
the same order of error at every overlap, and a fixed share of the difference between the meshes removes most of it. The shares are set by
the orders measured over materials from elastic to E/Y = 1000 and overlaps to 0.5: 1.2 to 1.7 for the work, 1 for the contact radius (whose
edge lies between two nodes) and for what is recovered from the instants of landing.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicSpline, PchipInterpolator

from fem.branch import SHARES, Branch
from fem.mesh import FloatArray
from fem.walk import Walk

WORK_SHARE = 0.6  # order 1.4
EDGE_SHARE = 1.0  # order 1
RECOVERED_SHARE = 1.0  # order 1


class Loading(NamedTuple):
    """Loading at given overlaps; lengths over the half height, stresses in the solver's unit."""

    force: FloatArray
    contact_radius: FloatArray
    stored: FloatArray
    dissipated: FloatArray


class Unloading(NamedTuple):
    """One unloading; first row the state it leaves from, last row the separation."""

    overlap: FloatArray
    force: FloatArray
    contact_radius: FloatArray
    stored: FloatArray
    dissipated: FloatArray
    raw_force: FloatArray


def loading(walk: Walk, overlap: FloatArray, skip: int) -> Loading:
    """Smooth loading of one mesh at `overlap`, from all landings but the first `skip` (too few elements in contact)."""
    return reader(walk, skip)(overlap)


def reader(walk: Walk, skip: int) -> Callable[[FloatArray], Loading]:
    """`loading` at any overlap, its splines made once."""
    rows = slice(skip, None)
    x, total = np.log(walk.landing_overlap[rows]), walk.landing_stored[rows] + walk.landing_dissipated[rows]
    work, radius = CubicSpline(x, np.log(total)), CubicSpline(x, np.log(walk.landing_radius[rows]))
    dissipated = PchipInterpolator(x, walk.landing_dissipated[rows] / total)

    def read(overlap: FloatArray) -> Loading:
        at = np.log(overlap)
        energy, share = np.exp(work(at)), dissipated(at)
        return Loading(energy / overlap * work(at, 1), np.exp(radius(at)), energy * (1.0 - share), energy * share)

    return read


def from_zero(read: Callable[[FloatArray], Loading], first: float, overlap: FloatArray) -> Loading:
    """The loading of a body that has not yielded, at `overlap` from 0 on: `read` gives it where the contact is resolved, from `first` on.

    Below, the force is the power p of the overlap that has done the right work up to `first`; the contact radius, which goes with its
    slope, is the power p - 1 (Hertz: 3/2 and 1/2).
    """
    last = read(np.array([first]))
    power = float(last.force[0] * first / last.stored[0]) - 1.0
    share = np.minimum(overlap / first, 1.0)
    resolved = read(np.maximum(overlap, first))
    return Loading(
        force=resolved.force * share**power,
        contact_radius=resolved.contact_radius * share ** max(power - 1.0, 0.0) * (share > 0.0),
        stored=resolved.stored * share ** (power + 1.0),
        dissipated=resolved.dissipated * 0.0,
    )


def retraced(loaded: Loading, overlap: FloatArray, raw_force: FloatArray) -> Unloading:
    """The unloading of a body that has not yielded, which is its loading: `loaded` at `overlap`, down to 0."""
    return Unloading(overlap, loaded.force, loaded.contact_radius, loaded.stored, loaded.dissipated, raw_force)


def retraced_branch(loaded: Loading, start: float) -> Branch:
    """The same of one mesh, `loaded` at `SHARES` of the overlap `start`."""
    shape, retreat = loaded.force / loaded.force[0], loaded.contact_radius / loaded.contact_radius[0]
    return Branch(start, start, float(loaded.force[0]), shape, np.zeros_like(SHARES), retreat)


def unloading(fine: Branch, start: Loading) -> Unloading:
    """An unloading of the fine mesh, its force and contact radius carried to the smooth loading state (one row) that it leaves from."""
    overlap = fine.overlap
    force = fine.shape * start.force[0]
    work = -cumulative_simpson(force, x=-overlap, initial=0.0)
    stored = start.stored[0] + work - fine.dissipated
    return Unloading(overlap, force, start.contact_radius[0] * fine.retreat, stored, start.dissipated[0] + fine.dissipated, fine.force)


def extrapolate(fine: FloatArray | float, coarse: FloatArray | float, share: float) -> FloatArray:
    """Add `share` of what the finer of two meshes changed; 1/(2^p - 1) removes an error of order p."""
    return np.asarray(fine) + share * (np.asarray(fine) - np.asarray(coarse))


def better(fine: Branch, coarse: Branch) -> Branch:
    """An unloading with most of the mesh error of what it recovers removed."""
    return fine._replace(recovered=fine.recovered * (fine.recovered / coarse.recovered) ** RECOVERED_SHARE)


def extrapolated(fine: Loading, coarse: Loading) -> Loading:
    """Loading columns with most of their mesh error removed."""
    return Loading(
        force=extrapolate(fine.force, coarse.force, WORK_SHARE),
        contact_radius=extrapolate(fine.contact_radius, coarse.contact_radius, EDGE_SHARE),
        stored=extrapolate(fine.stored, coarse.stored, WORK_SHARE),
        dissipated=extrapolate(fine.dissipated, coarse.dissipated, WORK_SHARE),
    )


def exponent(overlap: FloatArray, force: FloatArray) -> float:
    """Best exponent in least squares of F/F_max = ((d - d_0)/(d_max - d_0))^alpha (Edmans & Sinka 2020, Eq. 2).

    overlap, force: one unloading from its start to its separation, any units.
    """
    s = (overlap - overlap[-1]) / (overlap[0] - overlap[-1])
    f = force / force[0]
    inside = (s > 0.0) & (s < 1.0)
    s, f, alpha = s[inside], f[inside], 1.4
    for _ in range(30):
        shape = s**alpha
        slope = shape * np.log(s)
        alpha += float((slope * (f - shape)).sum() / (slope * slope).sum())
    return alpha
