"""Radii of a packing's spheres, drawn from a distribution."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from contactlaws.errors import Problem, require

FloatArray = npt.NDArray[np.float64]


def uniform_radii(count: int, smallest: float, largest: float, seed: int = 0) -> FloatArray:
    """`count` radii in m, each between the two equally likely. Raises `InputError` for bounds that aren't 0 < smallest <= largest."""
    require(_problems(count, smallest=smallest, largest=largest))
    if largest < smallest:
        require([Problem("largest", largest, f"must be at least smallest = {smallest}", "exchange the two")])
    return np.random.default_rng(seed).uniform(smallest, largest, count)


def lognormal_radii(count: int, median: float, deviation: float, seed: int = 0) -> FloatArray:
    """`count` radii in m whose logarithm is normal around that of `median`, with this standard deviation (0.2: two thirds within 20 %)."""
    require(_problems(count, median=median, deviation=deviation))
    return np.random.default_rng(seed).lognormal(np.log(median), deviation, count)


def tabulated_radii(count: int, table: Sequence[tuple[float, float]], by_volume: bool = False, seed: int = 0) -> FloatArray:
    """`count` radii from rows (radius in m, share), as near to the shares as whole numbers get, in an order drawn by the seed.

    Shares are of the number of spheres or, with `by_volume`, of their volume, as sieves and laser diffraction give it; in any unit. Raises
    `InputError` for an empty table, a radius that is not positive, and shares that are negative or all 0.

    >>> sorted(tabulated_radii(10, [(1e-6, 80.0), (2e-6, 20.0)]).tolist())[7:]
    [1e-06, 2e-06, 2e-06]
    >>> int((tabulated_radii(90, [(1e-6, 50.0), (2e-6, 50.0)], by_volume=True) == 2e-6).sum())  # each has 8 times the volume
    10
    """
    rows = np.array(table, dtype=float)
    bound = "must be rows of a positive radius and a share of at least 0, not all 0"
    fine = rows.ndim == 2 and rows.shape[1:] == (2,) and np.isfinite(rows).all() and (rows >= [np.nextafter(0.0, 1.0), 0.0]).all()
    require(_problems(count))
    require([] if fine and rows[:, 1].sum() > 0.0 else [Problem("table", table, bound, "give (radius in m, share) for each size")])
    radius, share = rows.T
    share = share / (radius / radius.max()) ** 3 if by_volume else share
    exact = count * share / share.sum()
    number = np.floor(exact).astype(int)
    number[np.argsort(number - exact, kind="stable")[: count - number.sum()]] += 1  # the largest remainders
    return np.random.default_rng(seed).permutation(np.repeat(radius, number))


def _problems(count: int, **positive: float) -> Iterator[Problem]:
    if count < 1:
        yield Problem("count", count, "must be at least 1", "ask for some spheres")
    for name, value in positive.items():
        if not 0.0 < value < np.inf:
            yield Problem(name, value, "must be positive and finite", "give radii in m")
