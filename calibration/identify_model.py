"""The atlas as a forward model: the force that a machine reads for a material, an unknown zero and an unknown compliance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from calibration.atlas_response import Interpolator, Response
from calibration.identify_data import Measured

FloatArray = npt.NDArray[np.float64]

#: overlaps at which a deflecting machine's reading is tabulated, over the deepest one
TABLE = np.concatenate(([0.0], np.geomspace(1e-4, 1.3, 300)))
SHARES = np.linspace(0.0, 1.0, 200) ** 2


class Setting(NamedTuple):
    """What decides a reading."""

    youngs_modulus: float  # Pa
    yield_stress: float  # Pa
    poissons_ratio: float
    zero: float  # m; the reading of the overlap at first touch
    compliance: float  # m/N; what the machine gives way


class Reading(NamedTuple):
    """Forces at the rows of a measurement, and how they change with what the atlas may be wrong about."""

    force: FloatArray  # N
    slope_of_overlap: FloatArray  # N; dF/dx on unloadings if the recovered overlap is larger by the factor 1 + x
    slope_of_exponent: FloatArray  # N; dF/dx on unloadings if the exponent is larger by x


def response_of(atlas: Interpolator, setting: Setting, deepest: float) -> Response:
    """A body stronger than the atlas's strongest is elastic as long as `deepest` is before that one's first yield; else NaN comes out."""
    ratio = setting.youngs_modulus / setting.yield_stress
    smallest = float(atlas.atlas.modulus_ratios[0])
    if ratio >= smallest:
        return atlas(ratio, setting.poissons_ratio)
    strongest = atlas(smallest, setting.poissons_ratio)
    return strongest.elastic if strongest.yield_depth is None or deepest <= strongest.yield_depth else strongest


def reading(atlas: Interpolator, measured: Measured, setting: Setting) -> Reading:
    """The force of each row of `measured`."""
    radius = measured.radius
    deepest = (float(measured.overlap.max()) - setting.zero) / radius
    response = response_of(atlas, setting, deepest)
    scale = setting.youngs_modulus * radius**2
    give = setting.compliance * scale / radius  # overlap over the radius, per force over E R^2
    overlap = (measured.overlap - setting.zero) / radius
    force, by_overlap, by_exponent = np.zeros(overlap.size), np.zeros(overlap.size), np.zeros(overlap.size)
    rows = measured.rows(0)
    force[rows] = response.force(np.maximum(_depth(response, overlap[rows], give), 0.0))
    starts = np.array([overlap[measured.rows(branch)[0] - 1 : measured.rows(branch)[0] + 1].max() for branch in measured.unloadings])
    starts = np.maximum(_depth(response, starts, give), 1e-9)
    for branch, start in zip(measured.unloadings, starts, strict=True):
        rows = measured.rows(branch)
        recovered, top = float(response.recovered(start)), float(response.force(start))
        table = top * response.shape(float(start), SHARES)
        at = np.interp(overlap[rows], start - recovered * (1.0 - SHARES) + give * table, SHARES)
        force[rows] = top * response.shape(float(start), at)
        slope = np.interp(at, SHARES, np.gradient(table, SHARES))
        by_overlap[rows] = slope * (1.0 - at) * (at > 0.0)
        by_exponent[rows] = force[rows] * np.log(np.maximum(at, 1e-12))
    return Reading(force * scale, by_overlap * scale, by_exponent * scale)


def _depth(response: Response, overlap: FloatArray, give: float) -> FloatArray:
    """The true overlap on loading, from one in which the machine's deflection is contained."""
    if give == 0.0:
        return overlap
    depth = TABLE * max(float(overlap.max()), 1e-9)
    return np.asarray(np.interp(overlap, depth + give * response.force(depth), depth))
