"""What a contact of ellipsoids costs beside one of spheres, and which share of it finds the contact.

    python -m cases.benchmarks.ellipsoids [--count 1000] [--aspect 1.5]

Both beds are pressed by the same strain beyond where they begin to bear, calmed down, and go on with warm contacts under the same drag: of
beds that are hot, those without friction lose contacts while one measures. They take turns in one process and the fastest of each counts,
so the ratio holds on a busy machine. A step is taken apart by leaving out: a law without any force, motion alone. "Detection" is the search
for the common normal with everything around it (gathering, book-keeping, scattering, the call from Python).
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

import dem
from cases.benchmarks.no_force import NoForce
from cases.benchmarks.settled_packing import MATERIAL
from contactlaws.elastic import Hertz
from contactlaws.hertz_ellipse import HertzEllipse
from contactlaws.material import Material
from contactlaws.tangential import mindlin
from contactlaws.whole_range import whole_range
from contactlaws.whole_range_ellipsoid import whole_range_ellipsoid
from dem.ellipsoid_packing import half_axes, random_ellipsoids
from dem.measure import network
from dem.motion import Deformation
from dem.packing import random_close_packing
from dem.timestep import scene_time_step
from dem.working import Working, follow, renew_forces, working

RADIUS, DENSITY = 5e-6, 4750.0
#: NMC (Becker & Kamlah 2021), which yields before the strain below is reached
PLASTIC = Material(142e9, 0.25, 7.9e9)
#: packing fractions to begin with: a little below where spheres, and ellipsoids, jam
FRACTIONS = (0.635, 0.68)
#: strain of all edges, in how many steps, decay of velocities over the critical step, and how long things then calm down
STRAIN, PRESSED, DECAY, CALM = 0.02, 4000, 0.02, 5000
PARTICLE_STEPS, REPEATS = 200_000, 15


class Cost(NamedTuple):
    """Of a bed, in the fastest of its turns."""

    step: float  # ns per particle-step
    contacts: float  # touching, per particle
    listed: float  # pairs, per particle

    @property
    def contact(self) -> float:
        """ns of a step per touching contact."""
        return self.step / self.contacts


def pressed(made: dem.Scene, dt: float, drag: float) -> Working:
    """The bed after a strain of all edges, calmed down; `drag` in 1/s."""
    work = working(made)
    for target, steps in ((work.cell * (1.0 - STRAIN), PRESSED), (work.cell * (1.0 - STRAIN), CALM)):
        work, _ = follow(work, Deformation(work.cell.copy(), target, steps, dt, drag), 0, steps)
    return work


def beds(count: int, aspect: float) -> dict[str, tuple[dem.Scene, dem.Scene]]:
    """Scenes of spheres and of ellipsoids of the same volume (1 : sqrt(aspect) : aspect): elastic and plastic ones."""
    balls = random_close_packing(count, FRACTIONS[0], RADIUS, seed=1)
    others = random_ellipsoids(count, FRACTIONS[1], half_axes((1.0, aspect**0.5, aspect), RADIUS), seed=1)
    modulus, friction = MATERIAL.reduced_modulus, mindlin(0.3, MATERIAL)
    elastic, plastic = (Hertz(RADIUS, modulus), HertzEllipse(modulus)), (whole_range(PLASTIC, RADIUS), whole_range_ellipsoid(PLASTIC))
    made = {}
    for name, (round_law, law), role in (
        ("elastic, no friction", elastic, None),
        ("elastic, friction", elastic, friction),
        ("plastic, friction", plastic, friction),
    ):
        spheres = dem.Scene(dem.spheres(balls.position, RADIUS, DENSITY), balls.box, dem.Contact(round_law, role), ())
        shaped = dem.Scene(others.particles(DENSITY), others.box, dem.Contact(law, role), ())
        made[name] = (spheres, shaped)
    return made


def fastest(tasks: dict[str, Callable[[], None]]) -> dict[str, float]:
    """CPU seconds of each task in its fastest turn; the first compiles."""
    best = dict.fromkeys(tasks, float("inf"))
    for turn in range(REPEATS + 1):
        for name, task in tasks.items():
            began = time.process_time()
            task()
            if turn:
                best[name] = min(best[name], time.process_time() - began)
    return best


def without_force(work: Working) -> Working:
    """The same state under a law that does nothing, and without friction."""
    groups = []
    for group in work.groups:
        assert group.past.memory is not None
        roles = group.roles._replace(normal=NoForce(1.0), tangential=None, rates=None)
        groups.append(group._replace(roles=roles, past=group.past._replace(memory=group.past.memory.copy(), slip=None)))
    return work._replace(groups=tuple(groups))


def advance(works: dict[str, Working], kind: str, still: Deformation) -> None:
    """Steps of one of the beds in a box that stands still."""
    work = works[kind]
    still = still._replace(start=work.cell.copy(), end=work.cell.copy())
    works[kind], _ = follow(work, still, 0, still.steps)


def repeat_forces(work: Working, steps: int) -> None:
    """The forces of the state as it is, again and again."""
    for _ in range(steps):
        renew_forces(work)


def measure_beds(scenes: tuple[dem.Scene, dem.Scene], count: int) -> dict[str, Cost | float]:
    """Costs of the beds, and ns per particle-step of all forces of ellipsoids, and of forces by a law of none."""
    steps, dt = max(1, PARTICLE_STEPS // count), min(scene_time_step(made, 0.02 * RADIUS, 0.2).dt for made in scenes)
    drag = DECAY / min(scene_time_step(made, 0.02 * RADIUS, 1.0).critical for made in scenes)
    works = {kind: pressed(made, dt, drag) for kind, made in zip(("spheres", "ellipsoids"), scenes, strict=True)}
    still = Deformation(np.eye(3), np.eye(3), steps, dt, drag)
    idle = without_force(works["ellipsoids"])
    tasks: dict[str, Callable[[], None]] = {
        "spheres": lambda: advance(works, "spheres", still),
        "ellipsoids": lambda: advance(works, "ellipsoids", still),
        "forces": lambda: repeat_forces(works["ellipsoids"], steps),
        "detection": lambda: repeat_forces(idle, steps),
    }
    best = {task: seconds / (steps * count) * 1e9 for task, seconds in fastest(tasks).items()}
    found: dict[str, Cost | float] = {"forces": best["forces"], "detection": best["detection"]}
    for kind in ("spheres", "ellipsoids"):
        found[kind] = Cost(best[kind], len(network(works[kind]).first) / count, len(works[kind].groups[0].rows.first) / count)
    return found


def measure(count: int, aspect: float) -> dict[str, dict[str, Cost | float]]:
    """`measure_beds` of every kind."""
    return {name: measure_beds(scenes, count) for name, scenes in beds(count, aspect).items()}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000, help="bodies")
    parser.add_argument("--aspect", type=float, default=1.5, help="longest half axis over the shortest")
    given = parser.parse_args()
    for name, row in measure(given.count, given.aspect).items():
        spheres, others = row["spheres"], row["ellipsoids"]
        assert isinstance(spheres, Cost)
        assert isinstance(others, Cost)
        forces, detection = float(row["forces"]), float(row["detection"])  # type: ignore[arg-type]
        print(f"{name}:")
        for kind, cost in (("spheres", spheres), ("ellipsoids", others)):
            print(
                f"  {kind:11s}{cost.step:8.1f} ns per particle-step, {cost.contacts:.2f} contacts and {cost.listed:.2f} listed pairs each: "
                f"{cost.contact:6.1f} ns per contact"
            )
        print(f"  ratio per contact {others.contact / spheres.contact:.2f} (goal 4)")
        law, motion = (forces - detection) / others.step, 1.0 - forces / others.step
        print(f"  of a step of ellipsoids: detection {detection / others.step:.0%}, law and friction {law:.0%}, motion {motion:.0%}")


if __name__ == "__main__":
    main()
