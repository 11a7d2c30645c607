"""From the discrete states of two meshes to one smooth curve with an error estimate.

Force: the work done up to the instants of landing is smooth in the overlap, though the force between them is a sawtooth (nodes land one by
one); the force is the derivative of a spline through the logarithm of that work. Work is taken as stored plus dissipated energy.
Both meshes have elements proportional to the distance from the pole and steps proportional to the elements, so every quantity has an error
of first order in the element size at every overlap; twice the fine result minus the coarse one cancels it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from fem.mesh import FloatArray
from fem.walk import Branch, Walk


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
    rows = slice(skip, None)
    x = np.log(walk.landing_overlap[rows])
    at = np.log(overlap)
    work = CubicSpline(x, np.log(walk.landing_stored[rows] + walk.landing_dissipated[rows]))
    radius = CubicSpline(x, np.log(walk.landing_radius[rows]))
    energy = np.exp(work(at))
    share = PchipInterpolator(x, walk.landing_dissipated[rows] / (walk.landing_stored[rows] + walk.landing_dissipated[rows]))(at)
    return Loading(energy / overlap * work(at, 1), np.exp(radius(at)), energy * (1.0 - share), energy * share)


def _retreat(branch: Branch) -> FloatArray:
    """Contact radius over its value at the start: the edge passes half way between two nodes in the middle of the states that rest on it."""
    edge = branch.edge.mean(axis=1)
    starts = np.flatnonzero(np.diff(edge, prepend=np.nan) != 0.0)
    middle = [branch.overlap[a:b].mean() for a, b in zip(starts, [*starts[1:], edge.size], strict=True)]
    middle[0], middle[-1] = branch.overlap[0], branch.overlap[-1]
    radius = np.minimum.accumulate(edge[starts])
    radius[-1] = 0.0
    return np.asarray(PchipInterpolator(middle[::-1], radius[::-1])(branch.overlap) / radius[0])


def unloading(fine: Branch, coarse: Branch | None, start: Loading) -> Unloading:
    """An unloading of the fine mesh, carried to the extrapolated start (one row) and the extrapolated separation.

    The recovered overlap is extrapolated; the shape is the fine mesh's.
    """
    recovered = fine.overlap[0] - fine.overlap[-1]
    better = recovered if coarse is None else extrapolate(recovered, coarse.overlap[0] - coarse.overlap[-1])
    overlap = fine.overlap[0] - (fine.overlap[0] - fine.overlap) * (better / recovered)
    force = fine.force * (start.force[0] / fine.force[0])
    work = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(overlap))])
    dissipated = start.dissipated[0] + (fine.dissipated - fine.dissipated[0])
    stored = start.stored[0] + work - (dissipated - dissipated[0])
    return Unloading(overlap, force, start.contact_radius[0] * _retreat(fine), stored, dissipated, fine.force)


def extrapolate(fine: FloatArray | float, coarse: FloatArray | float) -> FloatArray:
    """The limit of a first-order error, from a mesh and one half as fine."""
    return np.asarray(2.0 * np.asarray(fine) - np.asarray(coarse))


def extrapolated(fine: Loading, coarse: Loading | None) -> Loading:
    """`extrapolate` for all columns; the fine result itself if there is no coarse one."""
    return fine if coarse is None else Loading(*(extrapolate(f, c) for f, c in zip(fine, coarse, strict=True)))


def exponent(branch: Branch | Unloading) -> float:
    """Best exponent in least squares of F/F_max = ((d - d_0)/(d_max - d_0))^alpha (Edmans & Sinka 2020, Eq. 2)."""
    s = (branch.overlap - branch.overlap[-1]) / (branch.overlap[0] - branch.overlap[-1])
    f = branch.force / branch.force[0]
    inside = (s > 0.0) & (s < 1.0)
    s, f, alpha = s[inside], f[inside], 1.4
    for _ in range(30):
        shape = s**alpha
        slope = shape * np.log(s)
        alpha += float((slope * (f - shape)).sum() / (slope * slope).sum())
    return alpha
