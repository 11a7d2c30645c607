"""The loop of Jodrey & Tory's random close packing: again and again, push the worst pair apart.

Lengths are such that the box has the volume 1. `ratio` of a pair is its distance over the sum of its nominal radii, those that would fill
the box, so ratio**3 is a packing fraction. The smallest ratio, the inner one, rises as pairs are moved; the outer one, to which the worst
pair is spread, sinks by a small step with every move, the smaller the closer the two are. The worst pair is found through a tournament
tree over what each particle last knew of its nearest neighbour. That is a lower bound, since neighbours may have gone away meanwhile: only
a particle that wins with an outdated bound looks again. So a move costs a few searches among near cells, whatever the number of particles.
"""

from __future__ import annotations

import math

import numpy as np

from contactlaws.compiled import kernel
from dem.packing_cells import near, put, separation, take


@kernel
def _play(tree, i, ratio):  # type: ignore[no-untyped-def]
    """Enter `ratio` as the leaf of particle i in the tree of minima."""
    k = tree.size // 2 + i
    tree[k] = ratio
    while k > 1:
        k //= 2
        smaller = min(tree[2 * k], tree[2 * k + 1])
        if tree[k] == smaller:
            return
        tree[k] = smaller


@kernel
def _winner(tree):  # type: ignore[no-untyped-def]
    """The particle with the smallest ratio."""
    k = 1
    half = tree.size // 2
    while k < half:
        k = 2 * k if tree[2 * k] <= tree[2 * k + 1] else 2 * k + 1
    return k - half


@kernel
def _settle(i, position, radius, outer, cells, partner, tree, found):  # type: ignore[no-untyped-def]
    """Find the nearest neighbour of i anew, if nearer than `outer`, and let those that i is now nearest to know."""
    half, nearest = tree.size // 2, outer
    partner[i] = -1
    for k in found[: near(i, position, radius, outer, cells, found)]:
        ratio = separation(position, radius, cells.lengths, i, k)
        if ratio < outer and k != i:
            if ratio < nearest:
                nearest, partner[i] = ratio, k
            if ratio < tree[half + k]:
                partner[k] = i
                _play(tree, k, ratio)
    _play(tree, i, nearest if partner[i] >= 0 else np.inf)


@kernel
def _worst(position, radius, outer, cells, partner, tree, found):  # type: ignore[no-untyped-def]
    """The particle with the smallest ratio, after those that won with a bound below the truth have looked again."""
    while True:
        i = _winner(tree)
        if tree[1] >= outer or separation(position, radius, cells.lengths, i, partner[i]) <= tree[1]:
            return i
        _settle(i, position, radius, outer, cells, partner, tree, found)


@kernel
def _spread(i, j, position, radius, outer, lengths):  # type: ignore[no-untyped-def]
    """Move the two apart along their line to the ratio `outer`, their common centre of mass staying where it is."""
    ratio = separation(position, radius, lengths, i, j)
    share = radius[j] ** 3 / (radius[i] ** 3 + radius[j] ** 3)
    for axis in range(3):
        d = position[j, axis] - position[i, axis]
        d -= lengths[axis] * np.rint(d / lengths[axis])
        push = (outer / ratio - 1.0) * d if ratio > 0.0 else outer * (radius[i] + radius[j]) / math.sqrt(3.0)
        position[i, axis] -= share * push
        position[j, axis] += (1.0 - share) * push
        for k in (i, j):
            position[k, axis] -= math.floor(position[k, axis] / lengths[axis]) * lengths[axis]


@kernel
def push_apart(position, radius, cells, target, rate, most, outer=1.0):  # type: ignore[no-untyped-def]
    """Move pairs of `position` (in place) until the inner ratio reaches `target` or the outer one, or `most` moves are done.

    Returns the ratio up to which no two particles overlap and the number of moves. `rate` is the contraction rate of Jodrey & Tory 1985:
    the outer ratio sinks by rate/(2^j n) a move, j = floor(-log10(outer - inner packing fraction)).
    """
    count = len(position)
    leaves = 1
    while leaves < count:
        leaves *= 2
    tree, partner, found = np.full(2 * leaves, np.inf), np.full(count, -1), np.empty(count, np.int64)
    moves = 0
    for i in range(count):
        put(i, position, cells)
        _settle(i, position, radius, outer, cells, partner, tree, found)
    while moves < most:
        i = _worst(position, radius, outer, cells, partner, tree, found)
        inner = min(tree[1], outer)
        if moves > 0:
            gap = max(outer**3 - inner**3, 1e-16)
            outer -= 0.5 ** math.floor(-math.log10(gap)) * rate / count if gap < 1.0 else rate / count
        if inner >= min(target, outer):
            break
        j = partner[i]
        take(i, cells)
        take(j, cells)
        _spread(i, j, position, radius, outer, cells.lengths)
        put(i, position, cells)
        put(j, position, cells)
        _settle(i, position, radius, outer, cells, partner, tree, found)
        _settle(j, position, radius, outer, cells, partner, tree, found)
        moves += 1
    _worst(position, radius, outer, cells, partner, tree, found)
    return min(tree[1], outer), moves
