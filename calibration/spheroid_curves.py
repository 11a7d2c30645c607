"""The command that presses spheroids against a flat, for the law of ellipsoids: `python -m calibration.spheroid_curves FOLDER [--jobs 2]`.

A spheroid a : b : b, pressed along a, is a body of revolution. Shapes b/a from 1/2 to 2, E/Y from 5 to 1000, Poisson's ratios from 0 to
.45, the elastic bodies, and the material of Becker & Kamlah 2021; to .2 of the mean radius (a b^2)^(1/3). Each curve is a file of its own,
which appears when it is complete: interrupted, the command goes on from what is there. 369 curves, 40 CPU minutes. With --unseen COUNT it
is that many bodies drawn at random from the same range (one sequence of draws), to judge the law by.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np

from contactlaws.curve_files import write_curve
from contactlaws.material import Material

#: equatorial over axial semi-axis; next to each other by the fourth root of 2
ASPECTS = tuple(2.0 ** (k / 4.0) for k in (-4, 4, 0, -2, 2, -3, 3, -1, 1))
MODULUS_RATIOS = (1000.0, 30.0, 5.0, 120.0, 12.0, 300.0, 60.0, 8.0, 20.0)
POISSONS_RATIOS = (0.3, 0.0, 0.45, 0.15)
#: E/Y of lithium nickel manganese cobalt oxide as the authors have it, table 1
NMC = Material(142e9 / 7.9e9, 0.25, 1.0)
#: overlaps over the mean radius to unload from; the last is beyond the range that is asked for
STARTS = (0.0045, 0.01, 0.022, 0.045, 0.08, 0.115, 0.15, 0.2)
TOLERANCE = 0.005


class Spheroid(NamedTuple):
    """One curve; half height and yield stress are 1 (of elastic ones Young's modulus is)."""

    material: Material
    aspect: float

    @property
    def mean_radius(self) -> float:
        """Over half the height: aspect^(2/3)."""
        return self.aspect ** (2.0 / 3.0)

    @property
    def file_name(self) -> str:
        """Of its curve.

        >>> Spheroid(Material(50.0, 0.3, 1.0), 0.5).file_name
        'b0.5_E50_nu0.3.parquet'
        """
        material = self.material
        start = "elastic" if material.yield_stress is None else f"E{material.youngs_modulus:.6g}"
        return f"b{self.aspect:.5g}_{start}_nu{material.poissons_ratio:g}.parquet"


def spheroids() -> Iterator[Spheroid]:
    """All bodies: the authors' material first, then so that a run broken off has covered the whole range coarsely."""
    for aspect in ASPECTS:
        yield Spheroid(NMC, aspect)
    for nu in POISSONS_RATIOS:
        yield from (Spheroid(Material(1.0, nu), aspect) for aspect in ASPECTS)
        for ratio in MODULUS_RATIOS:
            yield from (Spheroid(Material(ratio, nu, 1.0), aspect) for aspect in ASPECTS)


def unseen(count: int) -> Iterator[Spheroid]:
    """Bodies drawn at random, in even proportion of the logarithms of E/Y and b/a, and of Poisson's ratio."""
    for ratio, nu, aspect in np.random.default_rng(2021).random((count, 3)):
        yield Spheroid(Material(float(5.0 * 200.0**ratio), float(0.45 * nu), 1.0), float(0.5 * 4.0**aspect))


def compute_one(body: Spheroid, folder: Path) -> str:
    """One curve, into its file."""
    import fem

    starts = tuple(start * body.mean_radius for start in STARTS)
    if body.material.yield_stress is None:  # unloaded once, so that it is resolved from the same overlap on
        curve = fem.press(body.material, aspect=body.aspect, unload_from=starts[:1], max_overlap=starts[-1], tolerance=TOLERANCE)
    else:
        curve = fem.press(body.material, aspect=body.aspect, unload_from=starts, tolerance=TOLERANCE)
    path = write_curve(curve, folder / body.file_name)
    return f"{path.name} {curve.provenance['cpu_seconds']:.1f} CPU s{'' if curve.stopped is None else f', stopped: {curve.stopped}'}"


def main(arguments: Sequence[str] | None = None) -> None:
    """See the module."""
    parser = argparse.ArgumentParser(prog="python -m calibration.spheroid_curves", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--unseen", type=int, metavar="COUNT")
    options = parser.parse_args(arguments)
    options.folder.mkdir(parents=True, exist_ok=True)
    bodies = spheroids() if options.unseen is None else unseen(options.unseen)
    missing = [body for body in bodies if not (options.folder / body.file_name).exists()]
    with ProcessPoolExecutor(options.jobs, mp_context=get_context("spawn")) as pool:
        futures = [pool.submit(compute_one, body, options.folder) for body in missing]
        for number, future in enumerate(as_completed(futures), 1):
            print(f"{number}/{len(missing)} {future.result()}", flush=True)


if __name__ == "__main__":
    main()
