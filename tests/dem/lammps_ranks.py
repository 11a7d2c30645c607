"""What the tests of the engine LAMMPS run on several ranks, or on one: `mpiexec -n 2 python lammps_ranks.py WHAT OUT.npz`."""

from __future__ import annotations

import sys

import numpy as np

import dem
from contactlaws.material import Material
from contactlaws.tangential import damper, mindlin, rolling
from contactlaws.whole_range import whole_range
from dem import lammps_run
from dem.box import Box
from dem.lammps_engine import Engine, Snapshot
from dem.lammps_library import library
from dem.motion import Deformation
from dem.packing import random_close_packing
from dem.particles import spheres

RADIUS, DENSITY = 5e-6, 4750.0
NMC = Material(142e9, 0.25)
LAW = whole_range(NMC._replace(yield_stress=1.42e9), RADIUS)
SMOOTH = dem.Contact(LAW)
ROUGH = dem.Contact(LAW, mindlin(0.3, NMC), rolling(0.1), damper(0.5, NMC))
EDGE = 12.0 * RADIUS
#: speed with which a pair flies through the box, in m/s, and the density in kg/m3 with which no force can slow it
SPEED, HEAVY = 100.0, 1e25


def packing(count: int = 200, contact: dem.Contact = SMOOTH, strain: float = 0.03, rate: float = 5e4) -> dem.Scene:
    """Spheres compressed and released; in five outputs each way."""
    programme = dem.uniaxial_compression(strain, strain_rate=rate)
    bed = random_close_packing(count, 0.635, radius=RADIUS, seed=1)
    return dem.packed_scene(bed, DENSITY, contact, programme, outputs=5, frames=2)


def pair(density: float = HEAVY, speed: float = 0.0, contact: dem.Contact = SMOOTH) -> dem.Scene:
    """Two spheres that touch, along x, in the middle of a box."""
    place = [[0.5 * EDGE - RADIUS, 0.3 * EDGE, 0.3 * EDGE], [0.5 * EDGE + RADIUS, 0.3 * EDGE, 0.3 * EDGE]]
    bodies = spheres(place, RADIUS, density, [[speed, speed, speed]] * 2)
    return dem.Scene(bodies, Box((EDGE,) * 3), contact, (dem.hold(1.0),))


def squeezed(engine: Engine, before: float, after: float, steps: int = 7, dt: float = 1e-12) -> Snapshot | None:
    """Change the edges along x from 1 - `before` to 1 - `after` of `EDGE`."""
    start, end = (np.diag([EDGE * (1.0 - strain), EDGE, EDGE]) for strain in (before, after))
    engine.follow(Deformation(start, end, steps, dt))
    return engine.snapshot()


def flight() -> dict[str, np.ndarray]:
    """A pair is loaded, unloaded in part, and flies once through the box along its diagonal, over every border of ranks; then goes on."""
    engine, found = Engine.of_scene(pair(speed=SPEED)), []
    found += [squeezed(engine, 0.0, 0.02), squeezed(engine, 0.02, 0.0195)]
    for _ in range(10):
        found.append(squeezed(engine, 0.0195, 0.0195, 50, EDGE / SPEED / 500.0))
    found += [squeezed(engine, 0.0195, 0.0192), squeezed(engine, 0.0192, 0.03)]
    engine.close()
    found = [snapshot for snapshot in found if snapshot is not None]
    virial = np.array([snapshot.sums[:, 0].sum() for snapshot in found])
    return {"virial": virial, "position": np.array([snapshot.position for snapshot in found])}


def compression() -> dict[str, np.ndarray]:
    """The path of a packing with friction, rolling resistance and dampers."""
    found = lammps_run.run(packing(120, ROUGH, 0.01, 2e5))
    if found is None:
        return {}
    energies = np.stack(found.energies[:-1])
    return {"stress": found.stress, "coordination": found.coordination_number, "energies": energies}


if __name__ == "__main__":
    lammps = library()
    results = {"flight": flight, "compression": compression}[sys.argv[1]]()
    end = lammps.lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
    if end.extract_setting("world_rank") == 0:
        np.savez(sys.argv[2], ranks=end.extract_setting("world_size"), **results)
    end.finalize()
