"""Which pairs may touch soon: linked cells, and a half list with a skin that lasts until something has moved through half of it.

Positions are never wrapped while a run goes on, so the image in which a pair meets stays the same, and (i, j, image) names a contact for as
long as it lives. Images are written out: a box narrower than a few cells, in which a particle meets several images of another, or its own,
needs no special case. A box that has been sheared far is searched in the most upright of the cells that repeat to the same lattice.
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
    """Half list: each pair once."""

    first: IntArray  # i, shape (m,)
    partner: IntArray  # j >= i, shape (m,)
    image: IntArray  # row of `images`, shape (m,)
    images: IntArray  # the image of j that i meets, in edges; shape (k, 3)


def neighbours(position: FloatArray, radii: FloatArray, box: Box, skin: float) -> PairList:
    """All pairs whose surfaces are at most `skin` (m) apart, in every image."""
    count, periodic = len(position), np.array(box.periodic)
    upright, turns = upright_cell(box)
    reach = max(2.0 * float(radii.max(initial=0.0)) + skin, np.finfo(float).tiny)
    part = position @ np.linalg.inv(upright)  # in edges
    heights = 1.0 / np.linalg.norm(np.linalg.inv(upright), axis=0)  # between opposite faces
    low = np.where(periodic, 0.0, part.min(axis=0) if count else 0.0)
    width = np.where(periodic, 1.0, np.maximum(part.max(axis=0) - low if count else 0.0, reach / heights))
    most = max(1, int(np.ceil(count ** (1.0 / 3.0))) * 2)  # more cells than that would be empty
    cells = np.clip(np.floor(width * heights / reach), 1, most).astype(np.int64)
    wraps = np.where(periodic, np.floor(part), 0.0).astype(np.int64)
    home = np.clip(((part - low - wraps) / width * cells).astype(np.int64), 0, cells - 1)
    cell = (home[:, 0] * cells[1] + home[:, 1]) * cells[2] + home[:, 2]
    order = np.argsort(cell, kind="stable")
    occupants = np.searchsorted(cell[order], np.arange(cells.prod() + 1))
    span = np.ceil(reach / (width * heights / cells)).astype(np.int64)
    inside = (position - wraps @ upright)[order]
    grid = (inside, radii[order], upright, periodic, skin, cells, span, home[order], occupants, order, wraps[order], turns)
    room, kinds = PAIRS_EXPECTED * count + PAIRS_EXPECTED, IMAGES_EXPECTED
    while True:
        pairs, codes = np.empty((3, room), np.int64), np.zeros(kinds, np.int64)
        size, different = _visit(*grid, pairs, codes)
        if size <= room and different <= kinds:
            break
        room, kinds = max(room, size), max(kinds, 2 * different)
    return PairList(pairs[0, :size].copy(), pairs[1, :size].copy(), pairs[2, :size].copy(), images_of(codes[:different]))


#: per particle, to begin with
PAIRS_EXPECTED = 7
#: different images, to begin with
IMAGES_EXPECTED = 64
#: images are told apart by one number: their three counts of edges, each from -BASE/2 to BASE/2
BASE = 1 << 20


def codes_of(images: IntArray) -> IntArray:
    """One number for each image, shape (m, 3)."""
    code = images + BASE // 2
    return (code[:, 0] * BASE + code[:, 1]) * BASE + code[:, 2]


def images_of(codes: IntArray) -> IntArray:
    """The images of these numbers."""
    return np.stack([codes // (BASE * BASE), codes // BASE % BASE, codes % BASE], axis=1) - BASE // 2


def upright_cell(box: Box) -> tuple[FloatArray, IntArray]:
    """Edge vectors of the least tilted cell that repeats to the same lattice, and how many of the box's edges each of them is."""
    cell, turns = box.cell, np.eye(3, dtype=np.int64)
    for row, axis in ((1, 0), (2, 1), (2, 0)):
        if box.periodic[axis]:
            whole = int(np.rint(cell[row, axis] / cell[axis, axis]))
            cell[row] -= whole * cell[axis]
            turns[row] -= whole * turns[axis]
    return cell, turns


@kernel
def _visit(  # type: ignore[no-untyped-def]
    inside, radii, cell_vectors, periodic, skin, cells, span, home, occupants, order, wraps, turns, pairs, codes
):
    """Write first, partner and row of the image of each pair as far as there is room; return how many pairs and images there are.

    Particles come in the order of their cells. Of two cells only one looks into the other: the one from which the other lies ahead along x,
    or y, or z. A pair is named from its lower number, and from the image ahead if a particle meets itself.
    """
    row, different = 0, 0
    k = np.zeros(3, np.int64)
    for i in range(len(inside)):
        for a in range(home[i, 0], home[i, 0] + span[0] + 1):
            sx = a // cells[0]
            if sx != 0 and not periodic[0]:
                continue
            for b in range(home[i, 1] - span[1], home[i, 1] + span[1] + 1):
                sy = b // cells[1]
                if (sy != 0 and not periodic[1]) or (a == home[i, 0] and b < home[i, 1]):
                    continue
                for c in range(home[i, 2] - span[2], home[i, 2] + span[2] + 1):
                    sz = c // cells[2]
                    level = a == home[i, 0] and b == home[i, 1]
                    if (sz != 0 and not periodic[2]) or (level and c < home[i, 2]):
                        continue
                    cell = ((a - sx * cells[0]) * cells[1] + b - sy * cells[1]) * cells[2] + c - sz * cells[2]
                    x = sx * cell_vectors[0, 0] + sy * cell_vectors[1, 0] + sz * cell_vectors[2, 0] - inside[i, 0]
                    y = sy * cell_vectors[1, 1] + sz * cell_vectors[2, 1] - inside[i, 1]
                    z = sz * cell_vectors[2, 2] - inside[i, 2]
                    begin = i + 1 if level and c == home[i, 2] else occupants[cell]
                    for j in range(begin, occupants[cell + 1]):
                        dx, dy, dz = inside[j, 0] + x, inside[j, 1] + y, inside[j, 2] + z
                        limit = radii[i] + radii[j] + skin
                        if dx * dx + dy * dy + dz * dz > limit * limit:
                            continue
                        if row < pairs.shape[1]:
                            # from images of wrapped positions in the upright cell to images of the positions as they are in the box's
                            ix, iy, iz = sx + wraps[i, 0] - wraps[j, 0], sy + wraps[i, 1] - wraps[j, 1], sz + wraps[i, 2] - wraps[j, 2]
                            for m in range(3):
                                k[m] = ix * turns[0, m] + iy * turns[1, m] + iz * turns[2, m]
                            one, other = order[i], order[j]
                            ahead = k[0] > 0 or (k[0] == 0 and (k[1] > 0 or (k[1] == 0 and k[2] > 0)))
                            if one > other or (one == other and not ahead):
                                one, other, k[0], k[1], k[2] = other, one, -k[0], -k[1], -k[2]
                            code = ((k[0] + BASE // 2) * BASE + k[1] + BASE // 2) * BASE + k[2] + BASE // 2
                            image = 0
                            while image < min(different, len(codes)) and codes[image] != code:
                                image += 1
                            if image == different:
                                different += 1
                            if image < len(codes):
                                codes[image] = code
                            pairs[0, row], pairs[1, row], pairs[2, row] = one, other, image
                        row += 1
    return row, different


def cell_order(position: FloatArray, radii: FloatArray) -> IntArray:
    """The order that puts particles of one cell next to each other in memory."""
    reach = 2.0 * float(radii.max(initial=0.0))
    cell = np.floor(position / max(reach, np.finfo(float).tiny)).astype(np.int64)
    return np.lexsort((cell[:, 2], cell[:, 1], cell[:, 0]))


def rows_before(old: tuple[IntArray, IntArray, IntArray], new: tuple[IntArray, IntArray, IntArray], count: int) -> IntArray:
    """For each of the new pairs (first, partner, code of the image) its row among the old ones, -1 for one that was not listed."""
    if not len(old[0]) or not len(new[0]):
        return np.full(len(new[0]), -1)
    codes, place = np.unique(np.concatenate([old[2], new[2]]), return_inverse=True)
    keys = (np.concatenate([old[0], new[0]]) * count + np.concatenate([old[1], new[1]])) * len(codes) + place
    before, now = keys[: len(old[0])], keys[len(old[0]) :]
    order = np.argsort(before)
    found = np.minimum(np.searchsorted(before[order], now), len(before) - 1)
    return np.where(before[order][found] == now, order[found], -1)
