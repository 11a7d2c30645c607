"""Curves of pressed spheroids in the units of the whole-range law: lengths over the radius of curvature R, forces over pi R^2 Y."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.curve import Curve
from contactlaws.curve_files import read_curve
from contactlaws.errors import InputError, Problem
from contactlaws.material import Material
from contactlaws.whole_range import whole_range
from contactlaws.whole_range_record import WholeRange
from contactlaws.whole_range_shape import local_geometry

FloatArray = npt.NDArray[np.float64]
#: E/Y that an elastic curve's record is given; it says nothing of elastic factors
ANY_RATIO = 100.0


class Unloading(NamedTuple):
    """One branch."""

    depth: float
    load: float
    area: float  # (a/R)^2
    recovered: float
    left: FloatArray  # share of the recovery that is left, falling from 1 to 0
    share: FloatArray  # of the force
    area_share: FloatArray  # of the contact area


class Pressed(NamedTuple):
    """A spheroid with its curve and the sphere's record of its material."""

    elastic: bool
    law: WholeRange  # of radius 1
    local: tuple[float, float, float, float, float]  # see `contactlaws.whole_range_shape.local_geometry`
    depth: FloatArray  # of the loading, without its first row, where nothing touches
    load: FloatArray
    area: FloatArray
    yield_depth: float | None
    unloadings: tuple[Unloading, ...]

    @property
    def t(self) -> FloatArray:
        """Root of the overlap over the mean radius."""
        return np.sqrt(self.depth * self.local[1])

    @property
    def name(self) -> str:
        """For tables."""
        return f"E/Y {self.law.youngs_modulus:g}, nu {self.law.poissons_ratio:g}, b/a {math.exp(self.local[2]):.3g}"


def pressed(curve: Curve) -> Pressed:
    """Raises `InputError` for a curve without a contact radius or material."""
    material, shape = curve.material, curve.aspect
    if material is None or curve.contact_radius is None:
        raise InputError(Problem("curve", curve.content_hash, "has no material or no contact radius", "take one of fem.press"))
    stress = material.youngs_modulus / ANY_RATIO if material.yield_stress is None else material.yield_stress
    radius, unit = curve.radius * shape**2, math.pi * (curve.radius * shape**2) ** 2 * stress
    law = whole_range(Material(material.youngs_modulus / stress, material.poissons_ratio, 1.0), 1.0)
    depth, load, area = curve.overlap / radius, curve.force / unit, (curve.contact_radius / radius) ** 2
    rows = curve.rows(0)
    return Pressed(
        elastic=material.yield_stress is None,
        law=law,
        local=local_geometry((1.0, 1.0, curve.radius * shape ** (2.0 / 3.0) / radius)),
        depth=depth[rows][1:],
        load=load[rows][1:],
        area=area[rows][1:],
        yield_depth=None if curve.yield_overlap is None else curve.yield_overlap / radius,
        unloadings=tuple(_unloading(depth[part], load[part], area[part]) for part in map(curve.rows, curve.unloadings)),
    )


def _unloading(depth: FloatArray, load: FloatArray, area: FloatArray) -> Unloading:
    recovered = depth[0] - depth[-1]
    left = (depth - depth[-1]) / recovered
    return Unloading(float(depth[0]), float(load[0]), float(area[0]), float(recovered), left, load / load[0], area / area[0])


def read_folder(folder: Path) -> Iterator[Pressed]:
    """All curves of a folder, in the order of their names; raises `InputError` if there is none."""
    paths: Sequence[Path] = sorted(folder.glob("*.parquet"))
    if not paths:
        raise InputError(Problem("folder", str(folder), "holds no curves", "python -m calibration.spheroid_curves makes them"))
    return (pressed(read_curve(path)) for path in paths)
