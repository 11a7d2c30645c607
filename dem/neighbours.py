"""Which pairs may touch soon: linked cells, and a half list with a skin that lasts until something has moved through half of it.

Positions are never wrapped while a run goes on, so the image in which a pair meets stays the same, and (i, j, image) names a contact for as
long as it lives. Images are written out: a box narrower than a few cells, in which a particle meets several images of another, or its own,
needs no special case.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.compiled import kernel
from dem.box import Box

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


class PairList(NamedTuple):
    """Half list: the pairs of particle i stand in rows start[i] to start[i + 1], each pair once, i <= j."""

    start: IntArray  # shape (n + 1,)
    partner: IntArray  # j, shape (m,)
    image: IntArray  # row of `images`, shape (m,)
    images: IntArray  # the image of j that i meets, in box lengths; shape (k, 3)
    position: FloatArray  # m, where the particles were when the list was made
    lengths: FloatArray  # m, the box then
    skin: float  # m

    @property
    def first(self) -> IntArray:
        """The particle i of each pair, shape (m,)."""
        return np.repeat(np.arange(len(self.start) - 1), np.diff(self.start))


def neighbours(position: FloatArray, radii: FloatArray, box: Box, skin: float) -> PairList:
    """All pairs whose surfaces are at most `skin` (m) apart, in every image."""
    count = len(position)
    lengths, periodic = np.array(box.lengths), np.array(box.periodic)
    reach = max(2.0 * float(radii.max(initial=0.0)) + skin, np.finfo(float).tiny)
    low = np.where(periodic, 0.0, position.min(axis=0) if count else 0.0)
    extent = np.where(periodic, lengths, np.maximum(position.max(axis=0) - low if count else 0.0, reach))
    most = max(1, int(np.ceil(count ** (1.0 / 3.0))) * 2)  # more cells than that would be empty
    cells = np.clip(np.floor(extent / reach), 1, most).astype(np.int64)
    wraps = np.where(periodic, np.floor((position - low) / extent), 0.0).astype(np.int64)
    inside = position - low - wraps * extent
    home = np.clip((inside / extent * cells).astype(np.int64), 0, cells - 1)
    cell = (home[:, 0] * cells[1] + home[:, 1]) * cells[2] + home[:, 2]
    order = np.argsort(cell, kind="stable")
    occupants = np.searchsorted(cell[order], np.arange(cells.prod() + 1))
    grid = (inside, radii, extent, periodic, skin, cells, np.ceil(reach / (extent / cells)).astype(np.int64), home, order, occupants)
    start = np.zeros(count + 1, np.int64)
    _visit(*grid, start, None, None)
    start = np.cumsum(start)
    partner, found = np.empty(start[-1], np.int64), np.empty((start[-1], 3), np.int64)
    _visit(*grid, start, partner, found)
    # from images of wrapped positions to images of the positions as they are
    found += wraps[np.repeat(np.arange(count), np.diff(start))] - wraps[partner]
    images, image = np.unique(found, axis=0, return_inverse=True)
    return PairList(start, partner, image.reshape(-1).astype(np.int64), images, position.copy(), lengths, skin)


@kernel
def _visit(inside, radii, extent, periodic, skin, cells, span, home, order, occupants, start, partner, found):  # type: ignore[no-untyped-def]
    """Count the pairs of i in start[i + 1] (partner None), or write them from row start[i] on."""
    for i in range(len(inside)):
        row = start[i] if partner is not None else 0
        for a in range(home[i, 0] - span[0], home[i, 0] + span[0] + 1):
            sx = a // cells[0]
            if sx != 0 and not periodic[0]:
                continue
            for b in range(home[i, 1] - span[1], home[i, 1] + span[1] + 1):
                sy = b // cells[1]
                if sy != 0 and not periodic[1]:
                    continue
                for c in range(home[i, 2] - span[2], home[i, 2] + span[2] + 1):
                    sz = c // cells[2]
                    if sz != 0 and not periodic[2]:
                        continue
                    cell = ((a - sx * cells[0]) * cells[1] + b - sy * cells[1]) * cells[2] + c - sz * cells[2]
                    for k in range(occupants[cell], occupants[cell + 1]):
                        j = order[k]
                        if j < i or (j == i and not (sx > 0 or (sx == 0 and (sy > 0 or (sy == 0 and sz > 0))))):
                            continue
                        dx = inside[j, 0] - inside[i, 0] + sx * extent[0]
                        dy = inside[j, 1] - inside[i, 1] + sy * extent[1]
                        dz = inside[j, 2] - inside[i, 2] + sz * extent[2]
                        limit = radii[i] + radii[j] + skin
                        if dx * dx + dy * dy + dz * dz > limit * limit:
                            continue
                        if partner is not None:
                            partner[row] = j
                            found[row, 0] = sx
                            found[row, 1] = sy
                            found[row, 2] = sz
                        row += 1
        if partner is None:
            start[i + 1] = row


def cell_order(position: FloatArray, radii: FloatArray) -> IntArray:
    """The order that puts particles of one cell next to each other in memory."""
    reach = 2.0 * float(radii.max(initial=0.0))
    cell = np.floor(position / max(reach, np.finfo(float).tiny)).astype(np.int64)
    return np.lexsort((cell[:, 2], cell[:, 1], cell[:, 0]))


def pair_keys(pairs: PairList, reach: int) -> IntArray:
    """One number per pair, the same in every list; `reach` bounds the images' absolute values."""
    base = 2 * reach + 1
    image = ((pairs.images[:, 0] + reach) * base + pairs.images[:, 1] + reach) * base + pairs.images[:, 2] + reach
    return (pairs.first * (len(pairs.start) - 1) + pairs.partner) * base**3 + image[pairs.image]


def carried_over(old: PairList, memory: FloatArray, new: PairList) -> tuple[FloatArray, IntArray]:
    """The memory of the pairs of `old`, shape (m, floats), in the rows of `new`; and the rows of `old` whose memory found no place."""
    fresh = np.zeros((len(new.partner), memory.shape[1]))
    used = np.flatnonzero(memory.any(axis=1))
    reach = int(max(np.abs(old.images).max(initial=0), np.abs(new.images).max(initial=0)))
    keys = pair_keys(new, reach)
    order = np.argsort(keys)
    wanted = pair_keys(old, reach)[used]
    place = np.minimum(np.searchsorted(keys[order], wanted), max(len(keys) - 1, 0))
    if not len(keys):
        return fresh, used
    there = keys[order][place] == wanted
    fresh[order[place[there]]] = memory[used[there]]
    return fresh, used[~there]
