"""How wrong a prediction may be: what leaving out a neighbour in the atlas changes, and what the finite elements say of themselves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from calibration.atlas import Atlas
from calibration.atlas_response import Interpolator, Response
from calibration.unloadings import power_law
from contactlaws.curve import QUANTITIES

FloatArray = npt.NDArray[np.float64]

#: the error between two nodes is this share of the error at a node that is left out, where the gap is twice as wide. A cubic would allow
#: 1/16; measured on materials between the nodes it is a fifth to a third
SHARE = 1.0 / 3.0
#: rows of an unloading, closer towards the separation, where the shape bends most
SHARES = np.linspace(1.0, 0.0, 41) ** 1.7


class Expected(NamedTuple):
    """Per name in QUANTITIES; relative, of the exponent absolute."""

    interpolation: Mapping[str, float]
    finite_elements: Mapping[str, float]

    @property
    def total(self) -> dict[str, float]:
        """The sum: both may be systematic."""
        return {name: self.interpolation[name] + self.finite_elements[name] for name in QUANTITIES}


def measured(response: Response, starts: FloatArray) -> FloatArray:
    """What errors are stated of, at `starts` (over the radius): force, contact radius, 1/recovered overlap, exponent, recovered energy."""
    force, recovered, shapes = response.force(starts), response.recovered(starts), response.shape(starts, SHARES)
    exponents = [power_law(SHARES, shape).exponent for shape in shapes]
    energy = -force * recovered * np.trapezoid(shapes, SHARES)
    return np.array([force, np.sqrt(response.area(starts)), 1.0 / recovered, exponents, energy]).T


def leave_out(atlas: Atlas) -> FloatArray:
    """Difference that each material makes when it is left out with all of its modulus (first axis: 0) or Poisson's ratio (1).

    Shape (2, moduli, Poisson's ratios, starts, QUANTITIES); relative, of the exponent absolute. The outermost nodes cannot be left out:
    they take over what is found at their neighbours.
    """
    ratios, nus = atlas.modulus_ratios, atlas.poissons_ratios
    truth = _at_nodes(Interpolator(atlas), ratios, nus, atlas.starts)
    found = np.full((2, *truth.shape), np.nan)
    for i in range(1, ratios.size - 1):
        found[0, i] = _at_nodes(Interpolator(atlas.without(modulus_ratio=ratios[i])), ratios[i : i + 1], nus, atlas.starts)[0]
    for j in range(1, nus.size - 1):
        found[1, :, j] = _at_nodes(Interpolator(atlas.without(poissons_ratio=nus[j])), ratios, nus[j : j + 1], atlas.starts)[:, 0]
    scale = np.where(np.array(QUANTITIES) == "unloading_exponent", 1.0, truth)
    change = abs(found - truth) / scale
    change[0, 0], change[0, -1] = change[0, 1], change[0, -2]
    change[1, :, 0], change[1, :, -1] = change[1, :, 1], change[1, :, -2]
    return np.asarray(change)


def _at_nodes(interpolator: Interpolator, ratios: FloatArray, nus: FloatArray, starts: FloatArray) -> FloatArray:
    return np.array([[measured(interpolator(ratio, nu), starts) for nu in nus.tolist()] for ratio in ratios.tolist()])


def expected(atlas: Atlas, modulus_ratio: float | None, poissons_ratio: float, deepest: float) -> Expected:
    """The largest errors to be expected up to the overlap `deepest` over the radius."""
    at = atlas.modulus_ratios[0] if modulus_ratio is None else modulus_ratio
    i, moduli = _cell(np.log(atlas.modulus_ratios), float(np.log(at)))
    j, ratios = _cell(atlas.poissons_ratios, poissons_ratio)
    starts = atlas.starts <= max(deepest, atlas.starts[0]) * (1.0 + 1e-9)
    found = [part[i : i + 2, j : j + 2][:, :, starts].max(axis=(0, 1, 2)) for part in atlas.leave_out]
    interpolation = SHARE * (moduli * found[0] + ratios * found[1])
    elements = atlas.errors[i : i + 2, j : j + 2].max(axis=(0, 1))
    return Expected(dict(zip(QUANTITIES, interpolation.tolist(), strict=True)), dict(zip(QUANTITIES, elements.tolist(), strict=True)))


def _cell(nodes: FloatArray, x: float) -> tuple[int, float]:
    """Number of the node before x, and 1 half way to the next one, 0 at both."""
    i = int(np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, nodes.size - 2))
    t = float(np.clip((x - nodes[i]) / (nodes[i + 1] - nodes[i]), 0.0, 1.0))
    return i, 4.0 * t * (1.0 - t)
