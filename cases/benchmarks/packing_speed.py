"""Packing fraction reached against CPU time: beds, and random close packings by fraction and by contraction rate.

    python -m cases.benchmarks.packing_speed

The last table is where `dem.packing.RATES` and `JAMMED` come from. One thread; compiling is done before.
"""

from __future__ import annotations

import math
import time

import numpy as np

from dem.drop_and_roll import USUAL_FRACTION, drop_and_roll, periodic_in_height
from dem.jodrey_tory import push_apart
from dem.packing import DENSE, RATES, random_close_packing
from dem.packing_cells import cells_for

RADIUS = 5e-6
SEEDS = {250: range(6), 1000: range(3), 10_000: range(1)}
ASKED = (0.6, 0.62, 0.635, 0.64, None)


def jammed(count: int, rate: float, seed: int) -> tuple[float, float]:
    """Packing fraction at which equal spheres jam at a contraction rate, and moves per sphere."""
    nominal, lengths = np.full(count, (0.75 / (math.pi * count)) ** (1.0 / 3.0)), np.ones(3)
    position = np.random.default_rng(seed).random((count, 3))
    ratio, moves = push_apart(position, nominal, cells_for(nominal, lengths), math.inf, rate, int(4.0 * count / rate))
    return ratio**3, moves / count


def print_rates() -> None:
    """Where equal spheres jam, for each contraction rate."""
    for rate in RATES:
        for count, seeds in SEEDS.items():
            if rate < DENSE and count > 1000:
                continue  # many minutes
            began = time.process_time()
            runs = np.array([jammed(count, rate, seed) for seed in seeds])
            seconds = (time.process_time() - began) / len(seeds)
            mean, scatter, moves = runs[:, 0].mean(), runs[:, 0].std(), runs[:, 1].mean()
            print(
                f"rate {rate:7g} {count:6d} spheres  jammed at {mean:.4f} +- {scatter:.4f} ({len(seeds)} seeds), "
                f"{moves:6.0f} moves per sphere, {seconds:7.2f} CPU s",
                flush=True,
            )


def print_fractions() -> None:
    """What an asked packing fraction costs, all attempts included."""
    for asked in ASKED:
        for count, seeds in SEEDS.items():
            began = time.process_time()
            packings = [random_close_packing(count, asked, RADIUS, seed) for seed in seeds]
            seconds = (time.process_time() - began) / len(seeds)
            least, worst = min(p.packing_fraction for p in packings), max(p.worst_overlap for p in packings)
            name = "as dense as it gets" if asked is None else f"asked for {asked:.3f}"
            print(
                f"{name:19s} {count:6d} spheres  at least {least:.4f} ({len(seeds)} seeds), worst {worst:8.1e}, {seconds:7.2f} CPU s",
                flush=True,
            )


def print_beds() -> None:
    """Dropped and rolled spheres: the interior of the bed, and boxes made of it that repeat in height."""
    for count, seeds in SEEDS.items():
        began = time.process_time()
        beds = [drop_and_roll(count, RADIUS, seed) for seed in seeds]
        seconds = (time.process_time() - began) / len(seeds)
        interior, whole = (np.mean([bed.interior_fraction for bed in beds]), np.mean([bed.packing.packing_fraction for bed in beds]))
        lowest = np.mean([periodic_in_height(bed).packing_fraction for bed in beds])
        began = time.process_time()
        closed = [periodic_in_height(bed, packing_fraction=USUAL_FRACTION) for bed in beds]
        closing, worst = (time.process_time() - began) / len(seeds), max(packing.worst_overlap for packing in closed)
        print(
            f"bed of {count:6d} spheres  interior {interior:.4f}, with floor and surface {whole:.4f}, {seconds:.3f} CPU s; "
            f"as its own image on top allows "
            f"{lowest:.4f}; closed at {USUAL_FRACTION} with worst overlap {worst:8.1e} in {closing:.2f} CPU s ({len(seeds)} seeds)",
            flush=True,
        )


def main() -> None:
    """Measure and print."""
    random_close_packing(20, 0.5, RADIUS)
    periodic_in_height(drop_and_roll(20, RADIUS), packing_fraction=0.3)
    periodic_in_height(drop_and_roll(20, RADIUS))
    print_beds()
    print_fractions()
    print_rates()


if __name__ == "__main__":
    main()
