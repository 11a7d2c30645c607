"""The box that particles live in: three edge vectors, each axis periodic or open."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.errors import Problem

FloatArray = npt.NDArray[np.float64]


class Box(NamedTuple):
    """Edges in m and, per axis, whether the box repeats along it. An open axis has walls where the scene says so; it counts in the volume.

    The first edge lies along x, the second in the xy plane; `tilt` is how far the second leans along x and the third along x and y, as in
    LAMMPS. A box without tilt is a cuboid.

    >>> Box((2.0, 3.0, 4.0)).volume
    24.0
    >>> Box((2.0, 3.0, 4.0)).stretched((1.0, 1.0, 0.5)).lengths
    (2.0, 3.0, 2.0)
    """

    lengths: tuple[float, float, float]  # m
    periodic: tuple[bool, bool, bool] = (True, True, True)
    tilt: tuple[float, float, float] = (0.0, 0.0, 0.0)  # m; xy, xz, yz

    @property
    def volume(self) -> float:
        """m3."""
        return math.prod(self.lengths)

    @property
    def cell(self) -> FloatArray:
        """The edge vectors as rows, in m, shape (3, 3)."""
        (x, y, z), (xy, xz, yz) = self.lengths, self.tilt
        return np.array([[x, 0.0, 0.0], [xy, y, 0.0], [xz, yz, z]])

    def with_cell(self, cell: FloatArray) -> Box:
        """The box of these edge vectors."""
        (x, _, _), (xy, y, _), (xz, yz, z) = cell.tolist()
        return self._replace(lengths=(x, y, z), tilt=(xy, xz, yz))

    def stretched(self, stretch: tuple[float, float, float], shear: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Box:
        """This box with x, y and z multiplied by their stretch, after a simple shear (change of tilt over the height): xy, xz, yz."""
        x, y, z = stretch
        xy, xz, yz = shear
        return self.with_cell(self.cell @ np.array([[1.0, 0.0, 0.0], [xy, 1.0, 0.0], [xz, yz, 1.0]]) @ np.diag([x, y, z]))


def wrapped(position: FloatArray, box: Box) -> FloatArray:
    """Positions, shape (n, 3), brought into the box along the periodic axes: 0 to 1 edges from the origin."""
    part = position @ np.linalg.inv(box.cell)
    inside = position - (np.floor(part) * np.array(box.periodic)) @ box.cell
    return np.where(np.array(box.periodic) & (inside >= np.array(box.lengths)) & (not any(box.tilt)), 0.0, inside)


def problems_with(box: Box) -> Iterator[Problem]:
    """Yield one `Problem` for each edge that is not a positive finite number, and each tilt that is not finite."""
    for axis, length in zip("xyz", box.lengths, strict=True):
        if not (math.isfinite(length) and length > 0.0):
            yield Problem(f"box length {axis}", length, "must be a positive finite number of metres", "give the edge of the box in m")
    for name, tilt in zip(("xy", "xz", "yz"), box.tilt, strict=True):
        if not math.isfinite(tilt):
            yield Problem(f"box tilt {name}", tilt, "must be a finite number of metres", "0 is a cuboid")
