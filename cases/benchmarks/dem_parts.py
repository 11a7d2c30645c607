"""What each part of a scene costs that can be left out: nanoseconds and bytes per particle-step, in one run.

    python -m cases.benchmarks.dem_parts [--count 2000]

The same settled packing runs without anything and with one part more at a time; the runs take turns and the fastest of each counts, so the
differences hold on a busy machine. `dem.requirements` prints these differences at the start of a run.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import dem
from cases.benchmarks.settled_packing import MATERIAL, hertz, settled
from contactlaws.elastoplastic import Thornton
from contactlaws.tangential import damper, mindlin, rolling
from dem.motion import Deformation
from dem.timestep import scene_time_step
from dem.working import follow, working

PACKING_FRACTION, PARTICLE_STEPS, REPEATS = 0.635, 400_000, 7


def variants() -> dict[str, dict[str, Any]]:
    """Settings of a scene with one part more; the first has none."""
    friction = dem.Contact(hertz(), mindlin(0.3, MATERIAL))
    plastic = dem.Contact(Thornton(hertz().radius, MATERIAL.reduced_modulus, 1.6 * 1e3 * MATERIAL.reduced_modulus))
    return {
        "nothing": {"contact": dem.Contact(hertz())},
        "radius": {"contact": dem.Contact(hertz()), "carry": ("radius",)},
        "mass": {"contact": dem.Contact(hertz()), "carry": ("mass",)},
        "rates": {"contact": dem.Contact(hertz()), "carry": ("rates",)},
        "rotation": {"contact": dem.Contact(hertz()), "carry": ("rotation",)},
        "memory": {"contact": plastic},  # that never yields: the same forces, but what they come from is remembered
        "friction": {"contact": friction},
        "rolling": {"contact": friction._replace(rolling=rolling(0.1))},
        "damper": {"contact": dem.Contact(hertz(), damping=damper(0.9, MATERIAL))},
    }


def measure(count: int) -> dict[str, tuple[float, float]]:
    """ns per particle-step and bytes per particle of every variant."""
    particles, box = settled(count, PACKING_FRACTION)
    steps = max(1, PARTICLE_STEPS // count)
    scenes = {name: dem.Scene(particles, box, programme=(), skin=0.05, **settings) for name, settings in variants().items()}
    states = {name: working(scene) for name, scene in scenes.items()}
    dt = min(scene_time_step(scene, 0.02 * hertz().radius, 0.2).dt for scene in scenes.values())
    still = Deformation(box.cell, box.cell, steps, dt)
    best = dict.fromkeys(states, float("inf"))
    for turn in range(REPEATS + 1):
        for name, work in states.items():
            began = time.process_time()
            states[name], _ = follow(work, still, 0, steps)
            if turn:  # the first compiles
                best[name] = min(best[name], (time.process_time() - began) / (steps * count) * 1e9)
    return {name: (best[name], states[name].bytes_used / count) for name in states}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=2000, help="spheres")
    found = measure(parser.parse_args().count)
    base = found["nothing"]
    print(f"{'part':12s}{'ns per particle-step':>24s}{'more than nothing':>20s}{'bytes per particle':>22s}{'more':>8s}")
    for name, (cost, used) in found.items():
        print(f"{name:12s}{cost:24.1f}{cost - base[0]:20.1f}{used:22.0f}{used - base[1]:8.0f}")


if __name__ == "__main__":
    main()
