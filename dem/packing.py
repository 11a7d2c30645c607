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
from dem.packing_cells import cells_for
from dem.particles import Particles, spheres

FloatArray = npt.NDArray[np.float64]

#: random packings of equal spheres end here (about 0.64); beyond it they crystallise, up to 0.7405
DENSEST_RANDOM = 0.645
#: a filling of gaps by ever smaller spheres: 1 - (1 - 0.645)^2, reached only when the sizes differ by more than ten times
DENSEST_RANDOM_MIXED = 0.874
#: contraction rates and the packing fractions at which equal spheres, however many, jam: means over seeds, measured by
#: `python -m cases.benchmarks.packing_speed`
RATES = (3e-5, 1e-4, 2e-4, 3e-4, 5e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1, 3e-1)
JAMMED = (0.6465, 0.6435, 0.641, 0.639, 0.635, 0.6285, 0.609, 0.564, 0.492, 0.368, 0.236)
#: the rate of a packing that is to be as dense as it gets, and the first one where nothing is known about the mixture of sizes
DENSE, PILOT = 1e-4, 1e-2


class Packing(NamedTuple):
    """Spheres in a box."""

    position: FloatArray  # m, shape (n, 3)
    radius: float | FloatArray  # m
    box: Box
    packing_fraction: float  # volume of the spheres over that of the box
    worst_overlap: float  # over the sum of the two radii; negative: a gap
    moves: int = 0  # of the packing algorithm, over all attempts
    contraction_rate: float = 0.0  # of the attempt that succeeded; 0 for other packings

    def particles(self, density: float) -> Particles:
        """At rest, of one density (kg/m3)."""
        return spheres(self.position, self.radius, density)


def random_close_packing(
    count: int,
    packing_fraction: float | None,
    radius: float | npt.ArrayLike,
    seed: int = 0,
    edges: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> Packing:
    """Overlap-free random packing of `count` spheres in a periodic box, of exactly the fraction asked for (Jodrey & Tory 1985).

    `radius` is one number or one for each sphere, in m; `edges` are in proportion to those of the box. The same seed gives the same
    packing. Without a fraction, the packing is as dense as it gets (0.64 for equal spheres; at five times the cost of 0.635). The slower
    the contraction, the denser the packing: the rate is chosen for the fraction, and a new attempt is made with a slower one where the
    spheres jammed before it. Raises `InputError` before computing for a fraction that no random packing has, and afterwards, with the
    fraction that was reached, for one that this algorithm cannot find.

    >>> packing = random_close_packing(20, 0.5, 5e-6, seed=1)
    >>> packing.position.shape, round(packing.packing_fraction, 12), bool(packing.worst_overlap <= 1e-12)
    ((20, 3), 0.5, True)
    """
    require(_problems(count, packing_fraction, radius, edges))
    radii = np.broadcast_to(np.asarray(radius, dtype=float), (count,))
    equal = bool(np.all(radii == radii[0]))
    solid = volume_of(radii)
    nominal, lengths = (
        radii / solid ** (1.0 / 3.0),
        np.array(edges) / math.prod(edges) ** (1.0 / 3.0),
    )  # in a unit volume that they would fill
    own = float(lengths.min() / (2.0 * nominal.max()))  # the ratio at which the largest sphere touches its own image
    target = math.inf if packing_fraction is None else packing_fraction ** (1.0 / 3.0)
    rate, best, moves = _first_rate(packing_fraction, count, equal), 0.0, 0
    while True:
        position = np.random.default_rng(seed).random((count, 3)) * lengths
        ratio, used = push_apart(position, nominal, cells_for(nominal, lengths), target, rate, int(4.0 * count / rate))
        ratio, moves = min(ratio, own), moves + used
        if packing_fraction is None:
            target = ratio
        if ratio >= target:
            scale = (solid / target**3) ** (1.0 / 3.0)
            x, y, z = (lengths * scale).tolist()
            one = float(radii[0]) if equal else radii.copy()
            return Packing(position * scale, one, Box((x, y, z)), packing_fraction or target**3, 1.0 - ratio / target, moves, rate)
        best, missing = max(best, ratio**3), _jams_at(rate) - ratio**3
        hoped = best + 2.0 * (JAMMED[0] - _jams_at(rate)) + 0.1 / math.sqrt(count)  # slowing down gains up to 1.7 times as much in mixtures
        if rate <= RATES[0] or hoped < target**3:
            reached = f"{best:.4f} was reached with {count} spheres (seed {seed}); slower contraction promises too little more"
            raise InputError(Problem("packing_fraction", packing_fraction, reached, "ask for less, or try another seed"))
        rate = max(RATES[0], rate / 10.0, min(rate / 2.0, _rate_for(target**3 + missing)))


def _jams_at(rate: float) -> float:
    """The packing fraction at which equal spheres jam."""
    return float(np.interp(math.log(rate), np.log(RATES), JAMMED))


def _rate_for(packing_fraction: float) -> float:
    """The contraction rate at which equal spheres jam at this fraction."""
    return float(np.exp(np.interp(packing_fraction, JAMMED[::-1], np.log(RATES[::-1]))))


def _first_rate(packing_fraction: float | None, count: int, equal: bool) -> float:
    """Slow enough that the scatter between packings of so many equal spheres (measured: 0.03/sqrt(n)) seldom calls for a second attempt."""
    if packing_fraction is None:
        return DENSE
    rate = _rate_for(packing_fraction + 0.03 / math.sqrt(count))
    return rate if equal else max(rate, PILOT)  # mixtures jam later: an attempt that costs little tells by how much


def _problems(
    count: int, packing_fraction: float | None, radius: float | npt.ArrayLike, edges: tuple[float, float, float]
) -> Iterator[Problem]:
    wrong = tuple(problems_with_radii(count, radius))
    if wrong:
        yield from wrong
        return
    radii = np.atleast_1d(np.asarray(radius, dtype=float))
    if len(edges) != 3 or not all(0.0 < edge < math.inf for edge in edges):
        yield Problem("edges", edges, "must be three positive finite numbers", "(1, 1, 1) is a cube")
        return
    if packing_fraction is None:
        return
    equal = bool(np.all(radii == radii[0]))
    limit, kind = (DENSEST_RANDOM, "equal spheres") if equal else (DENSEST_RANDOM_MIXED, "spheres of any sizes")
    solid = math.pi / 6.0 * float(np.sum((radii / radii.max()) ** 3)) * (count if len(radii) == 1 else 1)  # over the largest diameter cubed
    if solid * min(edges) ** 3 / math.prod(edges) < limit:
        limit, kind = solid * min(edges) ** 3 / math.prod(edges), "spheres that must not touch their own images"
    if not 0.0 < packing_fraction <= limit:
        bound = f"random packings of {kind} lie in (0, {limit:.4g}]"
        reason = "denser ones are crystals: use a lattice, or compress a packing of 0.64" if equal and count > 1 else "ask for less"
        yield Problem("packing_fraction", packing_fraction, bound, reason)


def problems_with_radii(count: int, radius: float | npt.ArrayLike) -> Iterator[Problem]:
    """Yield what is wrong with a number of spheres and their radii, in m: one, or one for each."""
    radii = np.atleast_1d(np.asarray(radius, dtype=float))
    bad = radii[~(np.isfinite(radii) & (radii > 0.0))]
    if count < 1:
        yield Problem("count", count, "must be at least 1", "ask for some spheres")
    elif radii.shape not in ((1,), (count,)):
        yield Problem("radius", radii.shape, f"must be one number or {count} of them", "one radius per sphere")
    elif len(bad):
        yield Problem("radius", float(bad[0]), "must be positive and finite", "give it in m")


def volume_of(radii: FloatArray) -> float:
    """Of all these spheres together, m3."""
    return float(np.sum(4.0 / 3.0 * math.pi * radii**3))


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
    return Packing(position, radius, Box(lengths), fraction, 0.0)  # type: ignore[arg-type]
