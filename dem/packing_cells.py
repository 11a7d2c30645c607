"""Cells that find the near ones among spheres of very different sizes, and the worst overlap of a packing.

Each sphere is kept in the cells of its size class (a factor of 2 in radius), so that small ones are not looked for in cells of large ones.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.compiled import kernel
from contactlaws.errors import InputError, Problem
from dem.box import Box

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]


class Cells(NamedTuple):
    """Linked lists of the spheres in each cell, for each size class a grid of its own; they change in place."""

    lengths: FloatArray  # of the box, shape (3,)
    size: IntArray  # the size class of each sphere
    largest: FloatArray  # radius in each size class
    shape: IntArray  # number of cells along each axis, shape (classes, 3)
    start: IntArray  # the first cell of each class
    first: IntArray  # sphere in each cell, or -1
    following: IntArray  # the next one in the same cell, or -1
    home: IntArray  # the cell of each sphere


def cells_for(radius: FloatArray, lengths: FloatArray, axes: int = 3) -> Cells:
    """Empty cells for spheres of these radii, as wide as the largest spheres of their class; columns of any height where `axes` is 2."""
    size = np.floor(np.log2(radius.max() / radius)).astype(np.int64)
    classes, size = np.unique(size, return_inverse=True)
    largest = np.array([radius[size == k].max() for k in range(len(classes))])
    most = lengths[:axes] * (max(8.0, 4.0 * len(radius)) / float(np.prod(lengths[:axes]))) ** (1.0 / axes)  # no multitude of empty cells
    shape = np.ones((len(classes), 3), dtype=np.int64)
    shape[:, :axes] = np.maximum(1, np.minimum(lengths[:axes] / (2.0 * largest[:, None]), most))
    start = np.concatenate(([0], np.cumsum(shape.prod(axis=1))))
    empty = np.full(len(radius), -1)
    return Cells(lengths, size, largest, shape, start[:-1], np.full(start[-1], -1), empty, empty.copy())


@kernel
def put(i, position, cells):  # type: ignore[no-untyped-def]
    k, cell = cells.size[i], 0
    for axis in range(3):
        number = cells.shape[k, axis]
        cell = cell * number + min(int(position[i, axis] / cells.lengths[axis] * number), number - 1)
    cell += cells.start[k]
    cells.home[i] = cell
    cells.following[i] = cells.first[cell]
    cells.first[cell] = i


@kernel
def take(i, cells):  # type: ignore[no-untyped-def]
    k = cells.first[cells.home[i]]
    if k == i:
        cells.first[cells.home[i]] = cells.following[i]
        return
    while cells.following[k] != i:
        k = cells.following[k]
    cells.following[k] = cells.following[i]


@kernel
def separation(position, radius, lengths, i, j):  # type: ignore[no-untyped-def]
    """Distance to the nearest image over the sum of the radii."""
    square = 0.0
    for axis in range(3):
        d = abs(position[j, axis] - position[i, axis])
        d = min(d, lengths[axis] - d)
        square += d * d
    return math.sqrt(square) / (radius[i] + radius[j])


@kernel
def _range(x, reach, length, number):  # type: ignore[no-untyped-def]
    """The cells, not wrapped, within reach of a coordinate: each once, however narrow the box is."""
    low, high = math.floor((x - reach) / length * number), math.floor((x + reach) / length * number)
    return (0, number) if high - low >= number else (low, high + 1)


@kernel
def _around(a, number):  # type: ignore[no-untyped-def]
    """`a % number` for what `_range` yields, without a division."""
    return a + number if a < 0 else (a - number if a >= number else a)


@kernel
def near(i, position, radius, bound, cells, found):  # type: ignore[no-untyped-def]
    """Write into `found` whatever may have a separation below `bound` from sphere i, itself among them; their number is returned."""
    count, lengths, following = 0, cells.lengths, cells.following
    for size in range(len(cells.largest)):
        reach = bound * (radius[i] + cells.largest[size])
        nx, ny, nz = cells.shape[size, 0], cells.shape[size, 1], cells.shape[size, 2]
        x0, x1 = _range(position[i, 0], reach, lengths[0], nx)
        y0, y1 = _range(position[i, 1], reach, lengths[1], ny)
        z0, z1 = _range(position[i, 2], reach, lengths[2], nz)
        for a in range(x0, x1):
            for b in range(y0, y1):
                row = cells.start[size] + (_around(a, nx) * ny + _around(b, ny)) * nz
                for c in range(z0, z1):
                    k = cells.first[row + _around(c, nz)]
                    while k >= 0:
                        found[count] = k
                        count += 1
                        k = following[k]
    return count


@kernel
def _smallest_separation(position, radius, cells, number, bound):  # type: ignore[no-untyped-def]
    """The smallest separation below `bound` of one of the first `number` spheres from any other, or `bound`."""
    found = np.empty(len(position), np.int64)
    for i in range(len(position)):
        put(i, position, cells)
    for i in range(number):
        for k in found[: near(i, position, radius, bound, cells, found)]:
            if k != i:
                bound = min(bound, separation(position, radius, cells.lengths, i, k))
    return bound


def worst_overlap(position: FloatArray, radius: float | FloatArray, box: Box) -> float:
    """The largest overlap of two spheres, or of one with its own image, over the sum of their radii; negative where all have a gap.

    position: m, shape (n, 3); they may lie outside the box along its periodic axes. Right for boxes of any width: where a box is too narrow
    for the nearest image to be the only one that counts, it is doubled. A sphere alone in an open box has -inf. Raises `InputError` for a
    tilted box.
    """
    if any(box.tilt):
        raise InputError(Problem("box tilt", box.tilt, "overlaps are measured in cuboids", "shear the packing back"))
    radii = np.broadcast_to(np.asarray(radius, dtype=float), (len(position),))
    if len(position) == 0:
        return -math.inf
    unit, periodic = float(radii.max()), np.array(box.periodic)
    own = float(min(np.array(box.lengths)[periodic], default=math.inf)) / (2.0 * unit)  # separation of the largest from its own image
    bound = min(1.0, own)
    while len(position) > 1:
        tiled, radii_tiled, lengths = _tiled(position / unit, radii / unit, np.array(box.lengths) / unit, periodic, 2.0 * bound)
        found = _smallest_separation(tiled, radii_tiled, cells_for(radii_tiled, lengths), len(position), bound)
        if found < bound or bound >= own:
            return 1.0 - found
        bound = min(2.0 * bound, own)
    return 1.0 - own


def _tiled(
    position: FloatArray, radii: FloatArray, lengths: FloatArray, periodic: npt.NDArray[np.bool_], reach: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Positions, radii and lengths of a box that repeats along all axes and where only nearest images lie within `reach`.

    Open axes are made so long that nothing is reached across their ends; narrow ones are doubled.
    """
    low = np.where(periodic, 0.0, position.min(axis=0))
    lengths = np.where(periodic, lengths, np.ptp(position, axis=0) + 2.0 * reach)
    position = position - low
    position = position - np.floor(position / lengths) * lengths
    for axis in np.flatnonzero(lengths < 2.0 * reach):
        position = np.concatenate((position, position + lengths[axis] * np.eye(3)[axis]))
        radii, lengths = np.tile(radii, 2), lengths * (1.0 + np.eye(3)[axis])
    return np.ascontiguousarray(position), np.ascontiguousarray(radii), lengths
