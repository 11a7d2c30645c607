"""From the atlas to any material: interpolation that knows where first yield is.

At a fixed overlap all columns are 0 up to the modulus ratio at which the body just begins to yield, and smooth beyond. So they are
interpolated over t = ln(E/Y) - ln(E/Y at yield), from 0 (value and slope) through the materials that yield; materials of different
Poisson's ratio are first brought to the same t, and then a polynomial goes through them. Over the overlap of one material it is the same,
from its own first yield. Below the smallest overlap of the atlas strains are small, and all columns depend nearly on d/d_yield alone: they
are those of a softer body at the smallest overlap, E'^2 d_smallest = E^2 d; what is left to the finite size of the body goes as sqrt(d).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from calibration.atlas import Atlas
from calibration.atlas_columns import AREA, EDGE, FORCE, RECOVERED, SHAPE, area_exponent, hertz_force, shape_exponent
from calibration.atlas_splines import Splines, evaluate, from_onset

FloatArray = npt.NDArray[np.float64]
Function = Callable[[npt.ArrayLike], FloatArray]

#: how much deeper each row below the smallest overlap of the atlas is than the one before
GROWTH = 1.25
#: what large strains change below the smallest overlap is extrapolated in sqrt(d) from there and from an overlap about so much larger
APART = 3.0
#: p and k of a parabolic elastic body (Hertz 1882): F = s^1.5, A = s
HERTZ_UNLOADING = np.concatenate(([1.5], np.zeros(SHAPE.stop - SHAPE.start - 1), np.ones(EDGE.stop - EDGE.start)))


class Prepared(NamedTuple):
    """The splines of an atlas over the modulus ratio."""

    yield_scale: tuple[Function, ...]  # per Poisson's ratio: ln(d_yield (E/Y)^2) over ln E/Y
    onset: tuple[FloatArray, FloatArray]  # loading, unloading: (Poisson's ratios, overlaps), ln of the E/Y that just yields there
    splines: tuple[Splines, Splines]  # leading axes as `onset`


@dataclass(frozen=True)
class Interpolator:
    """An atlas ready for use; call it with a material."""

    atlas: Atlas
    prepared: Prepared = field(init=False, repr=False)
    _remembered: Callable[[float | None, float], Response] = field(init=False, repr=False)  # the last few, as a fit asks for them again

    def __post_init__(self) -> None:
        ready = _prepare(self.atlas)
        object.__setattr__(self, "prepared", ready)
        object.__setattr__(self, "_remembered", functools.lru_cache(16)(functools.partial(_response, self.atlas, ready)))

    def __call__(self, modulus_ratio: float | None, poissons_ratio: float) -> Response:
        """The response of a material with E/Y = `modulus_ratio` (None: it never yields); no check of the range."""
        return self._remembered(modulus_ratio, poissons_ratio)


def _prepare(atlas: Atlas) -> Prepared:
    t = np.log(atlas.modulus_ratios)
    scales = tuple(_yield_scale(t, depth, nu) for depth, nu in zip(atlas.yield_depth.T, atlas.poissons_ratios.tolist(), strict=True))
    onset = tuple(np.array([_onset(scale, overlaps) for scale in scales]) for overlaps in (atlas.depths, atlas.starts))
    tables = (atlas.loading, atlas.unloading)
    splines = tuple(from_onset(at, t, table.transpose(1, 2, 0, 3)) for at, table in zip(onset, tables, strict=True))
    return Prepared(scales, (onset[0], onset[1]), (splines[0], splines[1]))


def _yield_scale(t: FloatArray, depth: FloatArray, poissons_ratio: float) -> Function:
    """ln(d_yield (E/Y)^2) over ln E/Y; straight beyond both ends.

    Where the finite elements did not find first yield, though the body is weaker than one for which they did, it is Hertz's, with what the
    body's finite size changes going as sqrt(d_yield), or Y/E.
    """
    known = np.flatnonzero(np.isfinite(depth))
    scale = np.log(depth) + 2.0 * t
    limit, last = math.log(hertz_yield_scale(poissons_ratio)), known[-1]
    scale[last + 1 :] = limit + (scale[last] - limit) * np.exp(t[last] - t[last + 1 :])
    spline = CubicSpline(t[known[0] :], scale[known[0] :], bc_type="natural")
    low, high = t[known[0]], t[-1]

    def function(x: npt.ArrayLike) -> FloatArray:
        inside = np.clip(x, low, high)
        return np.asarray(spline(inside) + spline(inside, 1) * (np.asarray(x) - inside))

    return function


def hertz_yield_scale(poissons_ratio: float) -> float:
    """d_yield (E/Y)^2 of a small contact: Hertz's stresses on the axis and von Mises' condition.

    >>> round(hertz_yield_scale(0.3), 2)
    5.31
    """
    z = np.linspace(0.0, 2.0, 4001)[1:]  # depth over contact radius
    axial = -1.0 / (1.0 + z * z)
    radial = -(1.0 + poissons_ratio) * (1.0 - z * np.arctan(1.0 / z)) - 0.5 * axial
    pressure = 1.0 / float(abs(axial - radial).max())  # largest pressure over yield stress
    return (0.5 * math.pi * (1.0 - poissons_ratio**2) * pressure) ** 2


def _onset(scale: Function, overlaps: FloatArray) -> FloatArray:
    """ln of the modulus ratio at which first yield is at each of `overlaps`."""
    t = np.linspace(-2.0, 16.0, 2000)
    falling = np.minimum.accumulate(scale(t) - 2.0 * t)
    return np.interp(-np.log(overlaps), -falling, t)


@dataclass(frozen=True)
class Response:
    """One material: radius 1, Young's modulus 1; all overlaps over the radius."""

    poissons_ratio: float
    yield_depth: float | None  # None: it does not yield within the atlas
    depths: FloatArray  # rows of the loading, ascending; also below the atlas's smallest
    starts: FloatArray  # rows of the unloading
    loading: FloatArray  # (depths, columns), relative to the elastic body
    unloading: FloatArray  # (starts, columns), relative to the elastic body
    elastic_loading: FloatArray
    elastic_unloading: FloatArray
    below: FloatArray  # those of `depths` and `starts` that are below the atlas's smallest

    @property
    def elastic(self) -> Response:
        """The same body without yield stress."""
        return replace(self, yield_depth=None)

    def force(self, depth: npt.ArrayLike) -> FloatArray:
        """Force over E R^2 on the loading."""
        x = np.asarray(depth, dtype=np.float64)
        return np.asarray(hertz_force(x, 1.0 / (1.0 - self.poissons_ratio**2)) * np.exp(self._along_loading(x, FORCE)))

    def area(self, depth: npt.ArrayLike) -> FloatArray:
        """Contact radius over R, squared, on the loading."""
        x = np.asarray(depth, dtype=np.float64)
        return np.asarray(x * np.exp(self._along_loading(x, AREA)))

    def recovered(self, start: npt.ArrayLike) -> FloatArray:
        """Overlap recovered on unloading from `start`."""
        x = np.asarray(start, dtype=np.float64)
        found = self._relative_unloading(np.atleast_1d(x).ravel())[:, RECOVERED].reshape(x.shape)
        return np.asarray(x * np.exp(np.minimum(found, 0.0)))

    def shape(self, start: npt.ArrayLike, share: FloatArray) -> FloatArray:
        """Force over its value at the start of an unloading from `start`, at s = `share` from 0 (separation) to 1; (starts..., shares)."""
        return _power(share, shape_exponent(self._unloading(start)[..., SHAPE], share))

    def edge(self, start: npt.ArrayLike, share: FloatArray) -> FloatArray:
        """Contact area over its value at the start; (starts..., shares). It never grows on the way back: over the `share` given, the little
        by which the fitted exponents let it is taken off.
        """
        found = _power(share, area_exponent(self._unloading(start)[..., EDGE], np.maximum(share, 1e-300)))
        order = np.argsort(share)
        found[..., order] = np.minimum(np.maximum.accumulate(found[..., order], axis=-1), 1.0)
        return found

    def _along_loading(self, depth: FloatArray, column: int) -> FloatArray:
        x = np.maximum(np.atleast_1d(depth).ravel(), 1e-300)
        found = self._elastic_loading(np.sqrt(np.minimum(x, self.depths[-1]))) + self._relative_loading(x)
        return np.asarray(found[:, column].reshape(np.shape(depth)))

    def _unloading(self, start: npt.ArrayLike) -> FloatArray:
        """All columns, the elastic body's added; (starts..., columns)."""
        at = np.atleast_1d(np.asarray(start, dtype=np.float64))
        found = self._relative_unloading(at)
        found[:, RECOVERED + 1 :] += self._elastic_unloading(np.sqrt(np.minimum(at, self.starts[-1])))
        return found.reshape(*np.shape(start), found.shape[1])

    def _relative_loading(self, x: FloatArray) -> FloatArray:
        return self._relative(self._splines[0], x, self.loading.shape[1])

    def _relative_unloading(self, x: FloatArray) -> FloatArray:
        return self._relative(self._splines[1], x, self.unloading.shape[1])

    def _relative(self, splines: Splines | None, x: FloatArray, columns: int) -> FloatArray:
        if splines is None or self.yield_depth is None:
            return np.zeros((x.size, columns))
        return evaluate(splines, np.log(x / self.yield_depth))

    @cached_property
    def _splines(self) -> tuple[Splines | None, Splines | None]:
        if self.yield_depth is None:
            return None, None
        onset = np.array(np.log(self.yield_depth))
        return from_onset(onset, np.log(self.depths), self.loading), from_onset(onset, np.log(self.starts), self.unloading)

    @cached_property
    def _elastic_loading(self) -> Callable[[FloatArray], FloatArray]:
        return _from_touch(self.depths, self.elastic_loading, np.zeros(self.elastic_loading.shape[1]))

    @cached_property
    def _elastic_unloading(self) -> Callable[[FloatArray], FloatArray]:
        return _from_touch(self.starts, self.elastic_unloading, HERTZ_UNLOADING)


def _from_touch(nodes: FloatArray, values: FloatArray, limit: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """The elastic body's columns over sqrt(d), from their limit at first touch on."""
    return CubicSpline(np.sqrt(np.append(0.0, nodes)), np.vstack((limit, values)))


def _power(share: FloatArray, exponent: FloatArray) -> FloatArray:
    return np.where(share > 0.0, np.where(share > 0.0, share, 1.0) ** exponent, 0.0)


def _response(atlas: Atlas, ready: Prepared, modulus_ratio: float | None, poissons_ratio: float) -> Response:
    weights = _lagrange(atlas.poissons_ratios, poissons_ratio)
    yielded, smallest = None, 1e-3 * atlas.depths[0]
    if modulus_ratio is not None:
        t = np.log(modulus_ratio)
        depth = float(np.exp(sum(w * scale(t) for w, scale in zip(weights, ready.yield_scale, strict=True)) - 2.0 * t))
        yielded = depth if depth < atlas.depths[-1] else None
        smallest = min(0.5 * depth, smallest)
    rows = int(np.ceil(np.log(atlas.depths[0] / smallest) / np.log(GROWTH))) + 1
    below = np.geomspace(smallest, atlas.depths[0], rows)[:-1]
    grids = [np.concatenate((below, grid)) for grid in (atlas.depths, atlas.starts)]
    relative = [np.zeros((grid.size, table.shape[-1])) for grid, table in zip(grids, (atlas.loading, atlas.unloading), strict=True)]
    if yielded is not None:
        tables = zip(ready.onset, ready.splines, (atlas.depths, atlas.starts), strict=True)
        relative = [_columns(at, splines, t, weights, below, overlaps) for at, splines, overlaps in tables]
    elastic = [np.tensordot(weights, table, 1) for table in (atlas.elastic_loading, atlas.elastic_unloading)]
    limits = (np.zeros(elastic[0].shape[1]), HERTZ_UNLOADING)
    extended = [_towards(limit, values, below / atlas.depths[0]) for limit, values in zip(limits, elastic, strict=True)]
    return Response(poissons_ratio, yielded, grids[0], grids[1], relative[0], relative[1], extended[0], extended[1], below)


def _lagrange(nodes: FloatArray, x: float) -> FloatArray:
    """Weights of the values at `nodes` in the polynomial through them; as products, which also hold next to a node.

    >>> _lagrange(np.array([0.0, 1.0, 3.0]), 2.0).round(12).tolist()
    [-0.333333333333, 1.0, 0.333333333333]
    """
    apart = nodes[:, None] - nodes + np.eye(nodes.size)
    away = np.where(np.eye(nodes.size, dtype=bool), 1.0, x - nodes)
    return np.asarray((away / apart).prod(axis=1))


def _columns(onset: FloatArray, splines: Splines, t: float, weights: FloatArray, below: FloatArray, overlaps: FloatArray) -> FloatArray:
    """Columns at the overlaps `below` the atlas, and at its own; `onset` and `splines` by Poisson's ratio and overlap."""
    at_onset = weights @ onset

    def softer(i: int) -> FloatArray:
        """At overlap i of the atlas, the bodies with as much overlap over that of first yield as this one has at `below`."""
        query = t + 0.5 * np.log(below / overlaps[i]) - at_onset[i]
        return np.asarray(np.tensordot(weights, evaluate(Splines(*(part[:, i] for part in splines)), query[None]), 1))

    second = int(np.argmin(abs(overlaps - APART * overlaps[0])))
    roots = [np.sqrt(overlaps[i]) for i in (0, second)]
    beyond = ((roots[0] - np.sqrt(below)) / (roots[1] - roots[0]))[:, None]
    similar = softer(0) + beyond * (softer(0) - softer(second))
    inside = evaluate(splines, (t - at_onset)[None, :, None])[:, :, 0]
    return np.vstack((similar, np.tensordot(weights, inside, 1)))


def _towards(limit: FloatArray, values: FloatArray, shares: FloatArray) -> FloatArray:
    """The elastic body's columns below and within the atlas; below, they go to their limit for small overlaps as sqrt(d)."""
    return np.vstack((limit + (values[0] - limit) * np.sqrt(shares)[:, None], values))
