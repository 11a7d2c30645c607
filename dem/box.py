"""The box that particles live in: three edges along the axes, each axis periodic or open."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.errors import Problem

FloatArray = npt.NDArray[np.float64]


class Box(NamedTuple):
    """Edge lengths in m and, per axis, whether the box repeats along it. An open axis has no walls: its length only counts in the volume.

    >>> Box((2.0, 3.0, 4.0)).volume
    24.0
    >>> Box((2.0, 3.0, 4.0)).stretched((1.0, 1.0, 0.5)).lengths
    (2.0, 3.0, 2.0)
    """

    lengths: tuple[float, float, float]  # m
    periodic: tuple[bool, bool, bool] = (True, True, True)

    @property
    def volume(self) -> float:
        """m3."""
        return math.prod(self.lengths)

    def stretched(self, stretch: tuple[float, float, float]) -> Box:
        """This box with each edge multiplied by its stretch."""
        x, y, z = (length * factor for length, factor in zip(self.lengths, stretch, strict=True))
        return self._replace(lengths=(x, y, z))


def wrapped(position: FloatArray, box: Box) -> FloatArray:
    """Positions, shape (n, 3), brought into [0, length) along the periodic axes."""
    lengths, periodic = np.array(box.lengths), np.array(box.periodic)
    inside = position - np.floor(position / lengths) * lengths * periodic
    return np.where(periodic & (inside >= lengths), 0.0, inside)


def problems_with(box: Box) -> Iterator[Problem]:
    """Yield one `Problem` for each edge that is not a positive finite number."""
    for axis, length in zip("xyz", box.lengths, strict=True):
        if not (math.isfinite(length) and length > 0.0):
            yield Problem(f"box length {axis}", length, "must be a positive finite number of metres", "give the edge of the box in m")
