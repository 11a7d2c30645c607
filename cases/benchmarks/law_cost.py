"""What each registered law costs: nanoseconds per contact alone and in the DEM's pair kernel, while loading and while unloading.

    python -m cases.benchmarks.law_cost

Alone: one compiled loop over contacts with their memory in an array, as a simulation keeps it. In the pair kernel: the packed spheres of
`dem_speed`, shrunk or swelled a little before every pass so that every contact loads or unloads; the time of a pass over the contacts that
touch. The laws take turns and the least of many passes counts, so their ratios hold on a busy machine. One thread; compiled before.
"""

from __future__ import annotations

import time
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws import dispatch
from contactlaws.compiled import kernel
from contactlaws.edmans_sinka import EdmansSinka
from contactlaws.elastic import Hertz, HertzFiniteSize
from contactlaws.elastoplastic import Thornton
from contactlaws.material import Material
from contactlaws.whole_range import whole_range
from dem.box import Box
from dem.forces import pair_forces
from dem.packing import random_close_packing
from dem.particles import spheres
from dem.working import working

RADIUS, MATERIAL = 5e-6, Material(142e9, 0.25, 7.9e9, 4750.0)
SPHERES, PACKING_FRACTION, SQUEEZE = 4_000, 0.6, 0.95
CONTACTS, DEEPEST = 10_000, 0.2  # alone: contacts, and their largest overlap over the radius
STEP, PASSES = 1e-6, 60


class Cost(NamedTuple):
    """ns per contact."""

    alone_loading: float
    alone_unloading: float
    pair_loading: float
    pair_unloading: float


@kernel
def _alone(law, overlap, memory):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(overlap.size):
        force, state = dispatch.normal_force(law, overlap[i], 0.0, 0.0, dispatch.load_state(law, memory, i))
        dispatch.store_state(law, memory, i, state)
        total += force
    return total


def laws() -> dict[str, Any]:
    """One record of each law for the same material, Hertz first."""
    reduced = MATERIAL.reduced_modulus
    assert MATERIAL.yield_stress is not None
    shape = (0.1, 0.8, 0.3, 0.05, 0.6)
    edmans_sinka = (0.25, 0.0, 0.0, 1.5, 2.8, 1.0, 1.0, 1.42, 2.5, 0.454, 0.41, 2.0, 2.9932, 0.1206, 0.4865, 0.2563, 0.3429)
    return {
        "hertz": Hertz(RADIUS, reduced),
        "hertz_finite_size": HertzFiniteSize(RADIUS, reduced, *shape),
        "thornton": Thornton(RADIUS, reduced, 1.6 * MATERIAL.yield_stress),
        "edmans_sinka": EdmansSinka(RADIUS, reduced, MATERIAL.poissons_ratio, MATERIAL.yield_stress, *shape, *edmans_sinka),
        "whole_range": whole_range(MATERIAL, RADIUS),
    }


def _timed_alone(law: Any, overlap: npt.NDArray[np.float64], memory: npt.NDArray[np.float64]) -> float:
    began = time.perf_counter()
    _alone(law, overlap, memory)
    return time.perf_counter() - began


class _Packed:
    """The packed spheres on one law, to be passed over again and again."""

    def __init__(self, law: Any):
        packing = random_close_packing(SPHERES, PACKING_FRACTION, RADIUS, seed=1)
        x, y, z = (SQUEEZE * edge for edge in packing.box.lengths)
        self.law, self.work = law, working(law, spheres(SQUEEZE * packing.position, RADIUS, 4750.0), Box((x, y, z)), 0.1 * RADIUS)
        self.scale = 1.0

    def timed(self, factor: float) -> float:
        """Scale lengths by `factor`, then time one pass over all pairs; ns per contact."""
        work, self.scale = self.work, self.scale * factor
        work.position[:] *= factor
        motion = (work.position, work.velocity, work.radius, work.one_radius, work.pairs.lengths * self.scale, np.zeros(3), 0.0)
        contacts = (work.pairs.start, work.pairs.partner, work.pairs.image, work.pairs.images, work.memory, work.magnitude)
        began = time.perf_counter()
        pair_forces(self.law, *motion, *contacts, work.force, work.virial, work.tally)
        return (time.perf_counter() - began) / np.count_nonzero(work.magnitude) * 1e9


def measure(records: dict[str, Any]) -> dict[str, Cost]:
    """The least of `PASSES` passes of each kind, the laws taking turns."""
    packed = {name: _Packed(law) for name, law in records.items()}
    depth = np.random.default_rng(1).uniform(0.01, 1.0, CONTACTS) * DEEPEST * RADIUS
    memory = {name: np.zeros((CONTACTS, len(dispatch.law_of(law).memory))) for name, law in records.items()}
    rows: dict[str, list[list[float]]] = {name: [[], [], [], []] for name in records}
    for sign, column in ((1.0, 0), (-1.0, 1)):
        for turn in range(PASSES):
            for name, law in records.items():
                moved = depth * (1.0 + sign * STEP * (turn + 1))
                rows[name][column].append(_timed_alone(law, moved, memory[name]) / CONTACTS * 1e9)
                rows[name][column + 2].append(packed[name].timed(1.0 - sign * STEP))
    return {name: Cost(*(float(np.min(times[2:])) for times in columns)) for name, columns in rows.items()}


def main() -> None:
    """Measure and print."""
    found = measure(laws())
    hertz = found["hertz"]
    print("ns per contact (times Hertz)     alone: loading    unloading     pair kernel: loading     unloading")
    for name, cost in found.items():
        print(f"{name:20s}" + "".join(f"{value:14.1f} ({value / base:5.2f})" for value, base in zip(cost, hertz, strict=True)))


if __name__ == "__main__":
    main()
