"""Which spheres of a rank may touch soon, from LAMMPS's neighbour list; made again whenever LAMMPS has made a new one.

LAMMPS lists each pair of own spheres once, and each own sphere with a ghost. A contact reaches its memory without a search: the list says
in which slot of which sphere it lies. And it says for each own sphere which pairs it is in, in the order of the numbers of the others: in
this order forces are added, so that their sum does not depend, to the bit, on how many ranks there are.
"""

from __future__ import annotations

import ctypes
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.compiled import kernel
from dem.lammps_forces import ONE_SIDED, SLIP, TURNED

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]

#: the bits of an entry of LAMMPS's neighbour list that are the row of a sphere
ROW_BITS = 0x1FFFFFFF
_ELEMENT = ctypes.PYFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


class Pairs(NamedTuple):
    """Pairs of a rank whose contacts share their physics."""

    first: IntArray  # row of an own sphere, shape (m,)
    second: IntArray  # row of the other, own or a ghost; or number of the wall
    slots: IntArray  # of both, where each keeps what the contact remembers: sphere times slots plus slot; -1: none yet; see ONE_SIDED
    begin: IntArray  # entries of own sphere i are begin[i] to begin[i + 1], shape (n + 1,)
    entry: IntArray  # twice the pair, and 1 more where the sphere is its second
    touching: npt.NDArray[np.bool_]  # whether the force kernel has written a row for the pair, shape (m,)


def from_lammps(lmp: Any) -> tuple[IntArray, IntArray]:
    """The rows of both spheres of all pairs, shape (m,) each; the first is an own one."""
    index = lmp.find_pair_neighlist("zero")
    size = lmp.get_neighlist_size(index)
    rows, counts, places = np.empty(size, np.int32), np.empty(size, np.int32), np.empty(size, np.int64)
    element = _ELEMENT(("lammps_neighlist_element_neighbors", lmp.lib))
    at_rows, at_counts, at_places = (array.ctypes.data for array in (rows, counts, places))
    handle = ctypes.cast(lmp.lmp, ctypes.c_void_p)
    for e in range(size):
        element(handle, index, e, at_rows + 4 * e, at_counts + 4 * e, at_places + 8 * e)
    places[counts == 0] = places[counts > 0].min(initial=places[0]) if counts.any() else 0
    low = int(places.min(initial=0 if not size else places[0]))
    span = int((places + 4 * counts).max(initial=low)) - low
    # LAMMPS keeps its neighbours in pages here and there; one view over all of them, of which the kernel reads what is theirs
    memory = np.ctypeslib.as_array((ctypes.c_int32 * (span // 4)).from_address(low)) if span else np.zeros(0, np.int32)
    first, second = _flat(rows, counts, (places - low) // 4, memory)
    return first, second


def of_kinds(first: IntArray, second: IntArray, kind: IntArray, one: int, other: int) -> tuple[IntArray, IntArray]:
    """Those of two kinds of spheres; `kind` of each row."""
    ends = np.stack([kind[first], kind[second]])
    chosen = (ends.min(axis=0) == min(one, other)) & (ends.max(axis=0) == max(one, other))
    return first[chosen], second[chosen]


def near_walls(position: FloatArray, radius: FloatArray, walls: FloatArray, reach: float) -> tuple[IntArray, IntArray]:
    """Own spheres whose surface is within `reach` (m) of a wall, and its number; `walls` as in `forces.Frame`."""
    near = [np.flatnonzero(side * (position[:, int(axis)] - place) - radius <= reach) for axis, side, place, _ in walls.tolist()]
    numbers = np.repeat(np.arange(len(near)), [len(rows) for rows in near])
    return np.concatenate(near).astype(np.int32), numbers.astype(np.int32)


def arranged(
    first: IntArray,
    second: IntArray,
    walls: bool | None,
    tag: IntArray,
    partner: IntArray,
    memory: FloatArray,
    beyond: int,
    unseen: npt.NDArray[Any],
) -> Pairs:
    """The pairs with their slots, and which sphere is in which; of walls unless None.

    `tag` of all spheres; `partner` of the slots of the own ones, shape (n, SLOTS), and their `memory`, a row each, whose columns from
    `beyond` on are not the law's. Takes the slots that it finds out of `unseen`, of the shape of `partner`.

    Across the border of the box each of two spheres sees the other where round-off puts its image, so they may remember a contact
    differently by that. Where it comes to lie within one rank, it stays a contact of two sides, as it would be on two ranks.
    """
    slots = _slots(first, second, walls, tag, partner, unseen)
    if walls is None:
        apart = np.flatnonzero(_unlike(slots, memory, beyond))
        other = np.stack([slots[apart, 1], np.full(len(apart), ONE_SIDED, np.int32)], axis=1)
        slots[apart, 1] = ONE_SIDED
        first, second = np.concatenate([first, second[apart]]), np.concatenate([second, first[apart]])
        slots = np.concatenate([slots, other])
    begin, entry = _entries(first, second, slots, walls, tag, len(partner))
    return Pairs(first, second, slots, begin, entry, np.zeros(len(first), np.bool_))


def images_of(first: IntArray, second: IntArray, position: FloatArray, unwrapped: FloatArray, edges: FloatArray) -> FloatArray:
    """By how many edges the second sphere of each pair lies off where its way has led, seen from the first; shape (m, 3).

    `position` as LAMMPS has it in a box of these `edges` (m), `unwrapped` where the spheres were a moment ago, without jumps.
    """
    image = np.rint((position - unwrapped) / edges)
    return np.asarray(image[second] - image[first])


@kernel
def _flat(rows, counts, places, memory):  # type: ignore[no-untyped-def]
    """Two columns of LAMMPS's list."""
    first, second = np.empty(counts.sum(), np.int32), np.empty(counts.sum(), np.int32)
    at = 0
    for e in range(len(rows)):
        for k in range(places[e], places[e] + counts[e]):
            first[at], second[at] = rows[e], memory[k] & ROW_BITS
            at += 1
    return first, second


@kernel
def _slots(first, second, walls, tag, partner, unseen):  # type: ignore[no-untyped-def]
    """`slots` of `Pairs`."""
    count, room = partner.shape
    slots = np.full((len(first), 2), -1, np.int32)
    for k in range(len(first)):
        for side in range(2):
            i, j = (first[k], second[k]) if side == 0 else (second[k], first[k])
            if side == 1 and (walls is not None or i >= count):
                slots[k, 1] = ONE_SIDED
                continue
            name = -1 - j
            if walls is None:
                name = tag[j]
            for s in range(room):
                if partner[i, s] == name:
                    slots[k, side] = i * room + s
                    unseen[i, s] = False
    return slots


@kernel
def _unlike(slots, memory, beyond):  # type: ignore[no-untyped-def]
    """Whether both spheres of a pair are own ones and remember their contact otherwise than by sides."""
    unlike = np.zeros(len(slots), np.bool_)
    for k in range(len(slots)):
        here, there = slots[k, 0], slots[k, 1]
        if there == ONE_SIDED or (here < 0 and there < 0):
            continue
        unlike[k] = here < 0 or there < 0
        if not unlike[k]:
            for c in range(memory.shape[1]):
                turned = SLIP <= c - beyond < SLIP + 3 or TURNED <= c - beyond < TURNED + 3
                unlike[k] = unlike[k] or memory[there, c] != (-memory[here, c] if turned else memory[here, c])
    return unlike


@kernel
def _entries(first, second, slots, walls, tag, count):  # type: ignore[no-untyped-def]
    """`begin` and `entry` of `Pairs`."""
    begin = np.zeros(count + 1, np.int32)
    for k in range(len(first)):
        begin[first[k] + 1] += 1
        if slots[k, 1] != ONE_SIDED:
            begin[second[k] + 1] += 1
    begin = np.cumsum(begin).astype(np.int32)
    entry, filled = np.empty(begin[count], np.int32), begin[:-1].copy()
    for k in range(len(first)):
        for side in range(1 if slots[k, 1] == ONE_SIDED else 2):
            i, j = (first[k], second[k]) if side == 0 else (second[k], first[k])
            at = filled[i]
            while at > begin[i]:  # insertion: there are about ten
                before = entry[at - 1]
                other = second[before >> 1] if before & 1 == 0 else first[before >> 1]
                if walls is not None or tag[other] <= tag[j]:  # walls come in their order
                    break
                entry[at] = before
                at -= 1
            entry[at] = 2 * k + side
            filled[i] += 1
    return begin, entry
