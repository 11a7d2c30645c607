"""The loop of Jodrey & Tory's random close packing: again and again, push the worst pair apart.

Everything is in units of the (cubic) box's edge. `ratio` of a pair is its distance over the sum of its nominal radii, those that would
fill the box, so ratio**3 is a packing fraction. The smallest ratio, the inner one, rises as pairs are moved; the outer one, to which the
worst pair is spread, sinks by a small step with every move, the smaller the closer the two are. The worst pair is found through a
tournament tree over each particle's nearest neighbour, so a move costs a few searches of 27 cells, whatever the number of particles.
"""

from __future__ import annotations

import math

import numpy as np

from contactlaws.compiled import kernel


@kernel
def _cell_of(position, i, cells):  # type: ignore[no-untyped-def]
    x = min(int(position[i, 0] * cells), cells - 1)
    y = min(int(position[i, 1] * cells), cells - 1)
    z = min(int(position[i, 2] * cells), cells - 1)
    return (x * cells + y) * cells + z


@kernel
def _insert(i, cell, first, following, home):  # type: ignore[no-untyped-def]
    home[i] = cell
    following[i] = first[cell]
    first[cell] = i


@kernel
def _remove(i, first, following, home):  # type: ignore[no-untyped-def]
    k = first[home[i]]
    if k == i:
        first[home[i]] = following[i]
        return
    while following[k] != i:
        k = following[k]
    following[k] = following[i]


@kernel
def _play(tree, i, ratio):  # type: ignore[no-untyped-def]
    """Enter `ratio` as the leaf of particle i in the tree of minima."""
    k = tree.size // 2 + i
    tree[k] = ratio
    while k > 1:
        k //= 2
        tree[k] = min(tree[2 * k], tree[2 * k + 1])


@kernel
def _winner(tree):  # type: ignore[no-untyped-def]
    """The particle with the smallest ratio."""
    k = 1
    half = tree.size // 2
    while k < half:
        k = 2 * k if tree[2 * k] <= tree[2 * k + 1] else 2 * k + 1
    return k - half


@kernel
def _ratio(position, radius, i, j):  # type: ignore[no-untyped-def]
    """Distance to the nearest image over the sum of the radii."""
    square = 0.0
    for axis in range(3):
        d = position[j, axis] - position[i, axis]
        d -= np.rint(d)
        square += d * d
    return math.sqrt(square) / (radius[i] + radius[j])


@kernel
def _settle(i, position, radius, cells, first, following, home, partner, tree):  # type: ignore[no-untyped-def]
    """Find the nearest neighbour of i anew, and let those that i is now nearest to know."""
    x, y, z = home[i] // (cells * cells), home[i] // cells % cells, home[i] % cells
    half = tree.size // 2
    nearest, found = np.inf, -1
    for a in range(x - 1, x + 2):
        for b in range(y - 1, y + 2):
            for c in range(z - 1, z + 2):
                k = first[(a % cells * cells + b % cells) * cells + c % cells]
                while k >= 0:
                    if k != i:
                        ratio = _ratio(position, radius, i, k)
                        if ratio < nearest:
                            nearest, found = ratio, k
                        if ratio < tree[half + k]:
                            partner[k] = i
                            _play(tree, k, ratio)
                    k = following[k]
    partner[i] = found
    _play(tree, i, nearest)


@kernel
def _forsaken(i, cells, first, following, home, partner, lost, count):  # type: ignore[no-untyped-def]
    """Append to `lost` the neighbours of i that have it as their nearest: it is about to move away. Their number is returned."""
    x, y, z = home[i] // (cells * cells), home[i] // cells % cells, home[i] % cells
    for a in range(x - 1, x + 2):
        for b in range(y - 1, y + 2):
            for c in range(z - 1, z + 2):
                k = first[(a % cells * cells + b % cells) * cells + c % cells]
                while k >= 0:
                    if partner[k] == i and count < lost.size:
                        lost[count] = k
                        partner[k] = -1
                        count += 1
                    k = following[k]
    return count


@kernel
def push_apart(position, radius, cells, target, rate, most):  # type: ignore[no-untyped-def]
    """Move pairs of `position` (in place) until the inner ratio reaches `target`, the outer one falls below it, or `most` moves are done.

    Returns the inner ratio and the number of moves. `rate` is the contraction rate of Jodrey & Tory 1985: the outer ratio sinks by
    rate/(2^j n) a move, j = floor(-log10(outer - inner packing fraction)).
    """
    count = len(position)
    leaves = 1
    while leaves < count:
        leaves *= 2
    tree = np.full(2 * leaves, np.inf)
    first, following = np.full(cells**3, -1), np.full(count, -1)
    home, partner, lost = np.zeros(count, np.int64), np.full(count, -1), np.empty(4096, np.int64)
    for i in range(count):
        _insert(i, _cell_of(position, i, cells), first, following, home)
    for i in range(count):
        _settle(i, position, radius, cells, first, following, home, partner, tree)
    outer, inner, moves = 1.0, tree[1], 0
    while inner < target <= outer and moves < most:
        i = _winner(tree)
        j = partner[i]
        ratio = _ratio(position, radius, i, j)
        abandoned = _forsaken(i, cells, first, following, home, partner, lost, 0)
        abandoned = _forsaken(j, cells, first, following, home, partner, lost, abandoned)
        _remove(i, first, following, home)
        _remove(j, first, following, home)
        for axis in range(3):
            d = position[j, axis] - position[i, axis]
            d -= np.rint(d)
            push = 0.5 * (outer / ratio - 1.0) * d if ratio > 0.0 else 0.5 * outer * (radius[i] + radius[j]) / math.sqrt(3.0)
            position[i, axis] -= push
            position[i, axis] -= math.floor(position[i, axis])
            position[j, axis] += push
            position[j, axis] -= math.floor(position[j, axis])
        _insert(i, _cell_of(position, i, cells), first, following, home)
        _insert(j, _cell_of(position, j, cells), first, following, home)
        _settle(i, position, radius, cells, first, following, home, partner, tree)
        _settle(j, position, radius, cells, first, following, home, partner, tree)
        for k in range(abandoned):
            _settle(lost[k], position, radius, cells, first, following, home, partner, tree)
        gap = max(outer**3 - inner**3, 1e-16)
        outer -= 0.5 ** math.floor(-math.log10(gap)) * rate / count if gap < 1.0 else rate / count
        inner = min(tree[1], outer)
        moves += 1
    return tree[1], moves
