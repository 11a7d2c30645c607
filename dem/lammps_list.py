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

IntArray = npt.NDArray[np.int32]

#: the bits of an entry of LAMMPS's neighbour list that are the row of a sphere
ROW_BITS = 0x1FFFFFFF
_ELEMENT = ctypes.PYFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


class Pairs(NamedTuple):
    """The pairs of a rank."""

    first: IntArray  # row of an own sphere, shape (m,)
    second: IntArray  # row of the other, own or a ghost
    slots: IntArray  # of the first and the second, where each keeps what the contact remembers: sphere times slots plus slot; -1: none yet
    begin: IntArray  # entries of own sphere i are begin[i] to begin[i + 1], shape (n + 1,)
    entry: IntArray  # twice the pair, and 1 more where the sphere is its second
    touching: npt.NDArray[np.bool_]  # whether the force kernel has written a row for the pair, shape (m,)


def from_lammps(lmp: Any, tag: IntArray, partner: IntArray) -> tuple[Pairs, IntArray]:
    """The pairs, and the slots whose contacts are in no pair any more. `tag` of all spheres, `partner` of the slots of the own ones."""
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
    begin, entry, slots, left = _arranged(first, second, tag, partner)
    return Pairs(first, second, slots, begin, entry, np.zeros(len(first), np.bool_)), left


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
def _arranged(first, second, tag, partner):  # type: ignore[no-untyped-def]
    """`begin`, `entry` and `slots` of `Pairs`, and the slots in use that none of them is in."""
    count, room = partner.shape
    begin = np.zeros(count + 1, np.int32)
    for k in range(len(first)):
        begin[first[k] + 1] += 1
        if second[k] < count:
            begin[second[k] + 1] += 1
    begin = np.cumsum(begin).astype(np.int32)
    entry, slots = np.empty(begin[count], np.int32), np.full((len(first), 2), -1, np.int32)
    filled = begin[:-1].copy()
    unseen = partner != 0
    for k in range(len(first)):
        for side in range(2):
            i, j = (first[k], second[k]) if side == 0 else (second[k], first[k])
            if i >= count:
                continue
            at = filled[i]
            while at > begin[i]:  # insertion: there are about ten
                before = entry[at - 1]
                other = second[before >> 1] if before & 1 == 0 else first[before >> 1]
                if tag[other] <= tag[j]:
                    break
                entry[at] = before
                at -= 1
            entry[at] = 2 * k + side
            filled[i] += 1
            for s in range(room):
                if partner[i, s] == tag[j]:
                    slots[k, side] = i * room + s
                    unseen[i, s] = False
    return begin, entry, slots, np.flatnonzero(unseen.ravel()).astype(np.int32)
