"""Where the spheres are at the start: random close packings and lattices."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.errors import InputError, Problem, require
from dem.box import Box
from dem.jodrey_tory import push_apart

FloatArray = npt.NDArray[np.float64]

#: random packings of equal spheres end here (about 0.64); beyond it they crystallise, up to 0.7405
DENSEST_RANDOM = 0.645
#: a filling of gaps by ever smaller spheres: 1 - (1 - 0.645)^2, reached only when the sizes differ by more than ten times
DENSEST_RANDOM_MIXED = 0.874
#: contraction rates, tried in turn: the slower, the denser and the dearer
RATES = (3e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5)


class Packing(NamedTuple):
    """Positions in a periodic box, without overlaps beyond `worst_overlap`."""

    position: FloatArray  # m, shape (n, 3)
    radius: float | FloatArray  # m
    box: Box
    packing_fraction: float
    worst_overlap: float  # over the sum of the two radii; negative: a gap
    moves: int  # of the packing algorithm, over all attempts
    contraction_rate: float  # of the attempt that succeeded; 0 for a lattice


def random_close_packing(count: int, packing_fraction: float, radius: float | npt.ArrayLike, seed: int = 0) -> Packing:
    """Overlap-free random packing of `count` spheres in a periodic cube, of exactly the fraction asked for (Jodrey & Tory 1985).

    `radius` is one number or one for each sphere, in m. The same seed gives the same packing. Contraction starts fast and is slowed down
    until the fraction is reached. Raises `InputError` before computing for a fraction that no random packing has, and afterwards, with the
    fraction that was reached, for one that this algorithm cannot find.

    >>> packing = random_close_packing(20, 0.5, 5e-6, seed=1)
    >>> packing.position.shape, round(packing.packing_fraction, 12), bool(packing.worst_overlap <= 1e-12)
    ((20, 3), 0.5, True)
    """
    require(_problems(count, packing_fraction, radius))
    radii = np.broadcast_to(np.asarray(radius, dtype=float), (count,))
    solid = float(np.sum(4.0 / 3.0 * math.pi * radii**3))
    nominal = radii / solid ** (1.0 / 3.0)  # in a unit cube that they would fill
    target = packing_fraction ** (1.0 / 3.0)
    cells = max(1, int(0.5 / float(nominal.max())))
    start = np.random.default_rng(seed).random((count, 3))
    best, moves = 0.0, 0
    for rate in RATES:
        position = start.copy()
        ratio, used = push_apart(position, nominal, cells, target, rate, int(4.0 * count / rate))
        moves += used
        if ratio >= target:
            edge = (solid / packing_fraction) ** (1.0 / 3.0)
            one = float(radii[0]) if np.ndim(radius) == 0 or np.all(radii == radii[0]) else radii.copy()
            worst = 1.0 - min(ratio, 0.5 / float(nominal.max())) / target
            return Packing(position * edge, one, Box((edge, edge, edge)), packing_fraction, worst, moves, rate)
        best = max(best, ratio**3)
    reached = f"{best:.4f} was reached with {count} spheres (seed {seed})"
    raise InputError(Problem("packing_fraction", packing_fraction, reached, "ask for less, or try another seed"))


def _problems(count: int, packing_fraction: float, radius: float | npt.ArrayLike) -> Iterator[Problem]:
    radii = np.atleast_1d(np.asarray(radius, dtype=float))
    if count < 1:
        yield Problem("count", count, "must be at least 1", "ask for some spheres")
        return
    if radii.shape not in ((1,), (count,)):
        yield Problem("radius", radii.shape, f"must be one number or {count} of them", "one radius per sphere")
        return
    if not (np.isfinite(radii) & (radii > 0.0)).all():
        yield Problem("radius", float(radii[~(np.isfinite(radii) & (radii > 0.0))][0]), "must be positive and finite", "give it in m")
        return
    equal = bool(np.all(radii == radii[0]))
    limit, kind = (DENSEST_RANDOM, "equal spheres") if equal else (DENSEST_RANDOM_MIXED, "spheres of any sizes")
    largest = float(np.sum((radii / radii.max()) ** 3)) * (count if len(radii) == 1 else 1)  # ... that fits beside its own image
    if math.pi / 6.0 * largest < limit:
        limit, kind = math.pi / 6.0 * largest, "spheres that must not touch their own images"
    if not 0.0 < packing_fraction <= limit:
        bound = f"random packings of {kind} lie in (0, {limit:.4g}]"
        reason = "denser ones are crystals: use a lattice, or compress a packing of 0.64" if equal and count > 1 else "ask for less"
        yield Problem("packing_fraction", packing_fraction, bound, reason)


def simple_cubic(cells: tuple[int, int, int], radius: float) -> Packing:
    """Spheres that just touch their 6 neighbours; packing fraction pi/6."""
    return _lattice(cells, radius, 2.0, ((0.0, 0.0, 0.0),))


def body_centred_cubic(cells: tuple[int, int, int], radius: float) -> Packing:
    """Spheres that just touch their 8 neighbours; packing fraction pi sqrt(3)/8."""
    return _lattice(cells, radius, 4.0 / math.sqrt(3.0), ((0.0, 0.0, 0.0), (0.5, 0.5, 0.5)))


def face_centred_cubic(cells: tuple[int, int, int], radius: float) -> Packing:
    """Spheres that just touch their 12 neighbours; packing fraction pi sqrt(2)/6, the densest there is."""
    return _lattice(cells, radius, 2.0 * math.sqrt(2.0), ((0.0, 0.0, 0.0), (0.0, 0.5, 0.5), (0.5, 0.0, 0.5), (0.5, 0.5, 0.0)))


def _lattice(cells: tuple[int, int, int], radius: float, edge: float, basis: tuple[tuple[float, float, float], ...]) -> Packing:
    """`edge` of the cubic cell in radii, `basis` in edges."""
    corners = np.stack(np.meshgrid(*(np.arange(n) for n in cells), indexing="ij"), axis=-1).reshape(-1, 1, 3)
    position = (corners + np.array(basis)).reshape(-1, 3) * edge * radius
    lengths = tuple(float(n * edge * radius) for n in cells)
    fraction = len(position) * 4.0 / 3.0 * math.pi * radius**3 / math.prod(lengths)
    return Packing(position, radius, Box(lengths), fraction, 0.0, 0, 0.0)  # type: ignore[arg-type]
