"""Beds of spheres that were dropped one after another: each falls, rolls over one sphere, then over two, until it rests on three.

The stability criterion is that of Wahn, Gan & Kamlah 2022, section 2.1: the vertical through the centre meets the triangle of the centres
of the three supports. The bed repeats sideways and lies on a floor; `periodic_in_height` makes a box of it that repeats in all directions.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.compiled import kernel
from contactlaws.errors import InputError, Problem, require
from dem.box import Box
from dem.jodrey_tory import push_apart
from dem.packing import Packing, problems_with_radii, volume_of
from dem.packing_cells import cells_for, put, worst_overlap
from dem.rolling import about, pile_up

FloatArray = npt.NDArray[np.float64]

#: what beds of equal spheres reach in their interior, measured by `python -m cases.benchmarks.packing_speed`
USUAL_FRACTION = 0.58
#: largest diameters near the floor and near the surface that are no interior: there the floor orders the spheres, or they lie loosely
MARGIN = 2.0
#: the seam of a periodic bed is closed by moves of Jodrey & Tory: to so much more than touching, so slowly, with so many per sphere at most
SEAM_OUTER, SEAM_RATE, SEAM_MOVES = 1.001, 1e-6, 2000


class Bed(NamedTuple):
    """Spheres at rest on a floor at the height 0."""

    packing: Packing  # in the order of dropping; open along z, where the box ends at the highest sphere: a fraction with floor and surface
    interior: tuple[float, float] | None  # m, heights between which floor and surface are not felt; None: the bed is too low
    interior_fraction: float | None  # packing fraction between them, spheres cut exactly


def drop_and_roll(count: int, radius: float | npt.ArrayLike, seed: int = 0, width: float | None = None) -> Bed:
    """Drop spheres one after another on a floor, at places drawn by the seed, into a square of this width that repeats sideways.

    `radius` in m is one number or one for each sphere, in the order of dropping. `width` in m: without it, about as wide as the bed becomes
    high. Equal spheres reach 0.58 in the interior. No dynamics: a sphere at rest stays, and none bounces. Raises `InputError` for a radius
    that is not positive and a width below the largest diameter.

    >>> bed = drop_and_roll(30, 5e-6, seed=1)
    >>> bed.packing.box.periodic, bool(bed.packing.worst_overlap < 1e-9)
    ((True, True, False), True)
    """
    require(problems_with_radii(count, radius))
    radii = np.array(np.broadcast_to(np.asarray(radius, dtype=float), (count,)))
    if width is not None and not 2.0 * radii.max() <= width < math.inf:
        bound = f"must be at least the largest diameter, {2.0 * radii.max():g} m"
        raise InputError(Problem("width", width, bound, "give a wider bed"))
    unit, solid = float(radii.max()), volume_of(radii)
    width = max((solid / USUAL_FRACTION) ** (1.0 / 3.0), 4.0 * unit) if width is None else float(width)
    lengths, scaled, position = np.array([width / unit, width / unit, 1.0]), radii / unit, np.zeros((count, 3))
    start = np.random.default_rng(seed).random((2 * count + 100, 2)) * width / unit
    if not pile_up(start, scaled, position, cells_for(scaled, lengths, 2)):
        raise InputError(Problem("seed", seed, "half of the spheres found no place to rest", "try another seed, or a wider bed"))
    position, top = position * unit, float(np.max(position[:, 2] + scaled)) * unit
    box, one = Box((width, width, top), (True, True, False)), unit if np.ptp(radii) == 0.0 else radii
    return Bed(Packing(position, one, box, solid / box.volume, worst_overlap(position, radii, box)), *_interior(position, radii, width))


def periodic_in_height(bed: Bed, count: int | None = None, packing_fraction: float | None = None) -> Packing:
    """A box that repeats in all directions, made of the whole bed or of the `count` spheres just above its floor layers.

    Without `packing_fraction` the bed stays as it is, and the box is the lowest in which its own image on top does not overlap it: the two
    rough faces leave gaps there, so its fraction is well below that of the interior (0.51 with 200 spheres, 0.54 with 5000). With it (0.58
    makes equal spheres as dense as the interior) the box has exactly this fraction, and whatever then overlaps is pushed apart as by Jodrey
    & Tory; that moves spheres by a tenth of their radius, in small beds everywhere, and undoes many contacts. Raises `InputError` for more
    spheres than the bed has above its floor layers and below its surface, and for a fraction that cannot be reached.
    """
    position, radii, box = bed.packing.position, np.broadcast_to(bed.packing.radius, (len(bed.packing.position),)), bed.packing.box
    if count is not None:
        above = np.argsort(position[:, 2], kind="stable")[np.sort(position[:, 2]) > 2.0 * MARGIN * radii.max()]
        most = int(np.count_nonzero(position[above, 2] < bed.interior[1])) if bed.interior else 0
        if not 0 < count <= most:
            raise InputError(Problem("count", count, f"the interior of this bed has {most} spheres", "drop more spheres, or ask for fewer"))
        position, radii = position[above[:count]], radii[above[:count]]
    radii = np.ascontiguousarray(radii)
    one, solid, width = float(radii[0]) if np.ptp(radii) == 0.0 else radii, volume_of(radii), box.lengths[0]
    position = position - [0.0, 0.0, position[:, 2].min()]
    if packing_fraction is None:
        unit = float(radii.max())
        lengths, order = np.array([width / unit, width / unit, 1.0]), np.argsort(-position[:, 2])
        height = _lowest(position[order] / unit, radii[order] / unit, cells_for(radii[order] / unit, lengths, 2)) * unit
        box = Box((width, width, height))
        return Packing(position, one, box, solid / box.volume, worst_overlap(position, radii, box))
    if not 0.0 < packing_fraction < 1.0:
        raise InputError(Problem("packing_fraction", packing_fraction, "must lie in (0, 1)", f"beds have about {USUAL_FRACTION}"))
    box = Box((width, width, solid / packing_fraction / width**2))
    unit, target = box.volume ** (1.0 / 3.0), packing_fraction ** (1.0 / 3.0)
    lengths, nominal, scaled = np.array(box.lengths) / unit, radii / solid ** (1.0 / 3.0), position / unit
    scaled -= np.floor(scaled / lengths) * lengths
    _, moves = push_apart(scaled, nominal, cells_for(nominal, lengths), target, SEAM_RATE, SEAM_MOVES * len(radii), SEAM_OUTER * target)
    overlap = worst_overlap(scaled * unit, radii, box)
    if overlap > 1e-12:
        bound = f"an overlap of {overlap:.2g} of the sum of the radii is left"
        raise InputError(Problem("packing_fraction", packing_fraction, bound, "ask for less, or compress a looser box"))
    return Packing(scaled * unit, one, box, packing_fraction, overlap, moves, SEAM_RATE)


@kernel
def _lowest(position, radius, cells):  # type: ignore[no-untyped-def]
    """The smallest height of a box in which no sphere overlaps an image above; spheres are ordered from the highest down."""
    found, height = np.empty((16 * len(radius) + 64, 4)), 2.0
    for i in range(len(radius)):
        put(i, position, cells)
    for i in range(len(radius)):
        x, y, z = position[i]
        for k in range(about(x, y, -1.0, z - height, radius[i], 0.0, position, radius, cells, found)):
            square = (radius[i] + found[k, 3]) ** 2 - (found[k, 0] - x) ** 2 - (found[k, 1] - y) ** 2
            if square > 0.0:
                height = max(height, z - found[k, 2] + math.sqrt(square))
    return height


def _interior(position: FloatArray, radii: FloatArray, width: float) -> tuple[tuple[float, float] | None, float | None]:
    """Heights between which floor and surface are not felt, and the fraction there. An even bed is twice as high as its centre of mass."""
    margin = 2.0 * MARGIN * float(radii.max())
    low, high = margin, 2.0 * float(np.average(position[:, 2], weights=radii**3)) - margin
    if high < low + 2.0 * radii.max():
        return None, None
    above, below = (np.clip(z - position[:, 2], -radii, radii) for z in (low, high))
    cut = math.pi * float(np.sum((radii**2 * below - below**3 / 3.0) - (radii**2 * above - above**3 / 3.0)))
    return (low, high), cut / (width**2 * (high - low))
