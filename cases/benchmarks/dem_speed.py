"""Particle-steps per CPU second of the DEM on an elastic law and on one that remembers, and what the memory costs.

    python -m cases.benchmarks.dem_speed

A random packing is squeezed by 3 % along each axis and settles under drag, as scenes do; what is timed is what follows, with the pair lists
made on the way. The cost of one pair list is measured apart. One thread; compiling is done before.
"""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np

import dem
from contactlaws.elastic import Hertz
from contactlaws.elastoplastic import Thornton
from dem.measure import coordination, network
from dem.motion import Deformation
from dem.packing import Packing, random_close_packing
from dem.timestep import time_step
from dem.working import Working, follow, relisted, working

RADIUS, DENSITY = 5e-6, 4750.0
LAWS: tuple[Hertz | Thornton, ...] = (Hertz(RADIUS, 151.47e9), Thornton(RADIUS, 151.47e9, 12.64e9))
COUNTS, PACKING_FRACTION = (1_000, 10_000), 0.6
SQUEEZE, SQUEEZING_STEPS, SETTLING_STEPS = 0.97, 300, 1000
PARTICLE_STEPS = 4_000_000  # timed, at least
SKIN, TIME_STEP_FRACTION = 0.05, 0.4  # as in `dem.Scene`
DRAG = 0.02  # share of its speed that a sphere loses per step


class Speed(NamedTuple):
    """How fast one law runs on one packing."""

    particle_steps: float  # per CPU second
    coordination: float
    lists: int  # pair lists made while the clock ran
    list_seconds: float  # CPU seconds for one pair list


def _squeezed(law: object, packing: Packing, dt: float) -> Working:
    """The packing settled in its smaller box."""
    bodies, cell, drag = dem.spheres(packing.position, packing.radius, DENSITY), packing.box.cell, DRAG / dt
    work = working(dem.Scene(bodies, packing.box, dem.Contact(law), (dem.hold(1.0),), skin=SKIN))
    work, _ = follow(work, Deformation(cell, SQUEEZE * cell, SQUEEZING_STEPS, dt, drag), 0, SQUEEZING_STEPS)
    work, _ = follow(work, Deformation(SQUEEZE * cell, SQUEEZE * cell, SETTLING_STEPS, dt, drag), 0, SETTLING_STEPS)
    return work


def measure(law: object, packing: Packing, particle_steps: int) -> Speed:
    """Squeeze, then run for at least this many particle-steps and time them."""
    count = len(packing.position)
    dt = time_step(law, dem.spheres(packing.position, packing.radius, DENSITY), 4.0 * RADIUS * (1.0 - SQUEEZE), TIME_STEP_FRACTION).dt
    work = _squeezed(law, packing, dt)
    steps, cell = -(-particle_steps // count), work.cell.copy()
    began = time.process_time()
    work, lists = follow(work, Deformation(cell, cell, steps, dt, DRAG / dt), 0, steps)
    seconds = time.process_time() - began
    if not np.isfinite(work.bodies.position).all():
        raise RuntimeError("the motion diverged: nothing was measured")
    began = time.process_time()
    relisted(work)
    one_list = time.process_time() - began
    return Speed(steps * count / seconds, coordination(network(work), count)[0], lists, one_list)


def main() -> None:
    """Measure and print."""
    began = time.process_time()
    small = random_close_packing(50, 0.5, RADIUS, seed=1)
    for law in LAWS:
        measure(law, small, 1)
    print(f"compiling or loading compiled kernels: {time.process_time() - began:.1f} CPU s, not in what follows", flush=True)
    for count in COUNTS:
        packing = random_close_packing(count, PACKING_FRACTION, RADIUS, seed=1)
        speeds = [measure(law, packing, PARTICLE_STEPS) for law in LAWS]
        for law, speed in zip(LAWS, speeds, strict=True):
            share = speed.particle_steps / speeds[0].particle_steps
            print(
                f"{count:7d} spheres  {type(law).__name__:10s}{speed.particle_steps / 1e6:7.2f} million particle-steps per CPU s, "
                f"{share:5.2f} of Hertz; {speed.coordination:.2f} contacts on each, {speed.lists} pair lists made, "
                f"one costs as much as {speed.list_seconds * speed.particle_steps / count:.0f} steps",
                flush=True,
            )


if __name__ == "__main__":
    main()
