"""What the tests of the engine LAMMPS run on several ranks, or on one: `mpiexec -n 2 python lammps_ranks.py WHAT OUT.npz`."""

from __future__ import annotations

import dataclasses
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

import dem
from contactlaws.elastic import Hertz
from contactlaws.elastoplastic import Thornton
from contactlaws.material import Material
from contactlaws.maxwell_zener_ting import maxwell_zener_ting
from contactlaws.prony import PronyViscoelastic
from contactlaws.tangential import damper, mindlin, rolling
from contactlaws.whole_range import whole_range
from dem import lammps_run
from dem.box import Box
from dem.lammps_engine import Engine, Snapshot
from dem.lammps_library import library
from dem.motion import Deformation
from dem.packing import face_centred_cubic, random_close_packing
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


def faces() -> dem.Scene:
    """A box of which only the faces move, on spheres that have gone through it here and there: each moves with the image that it is."""
    bed = packing(120, ROUGH, 0.005, 2e5)
    turns = np.random.default_rng(5).integers(-1, 2, size=(120, 3))
    bodies = bed.particles._replace(position=bed.particles.position + turns @ bed.box.cell)
    return dataclasses.replace(bed, particles=bodies, affine=False)


def stress() -> dem.Scene:
    """All edges are moved to hold a pressure; what follows starts from there. The step follows the deepest contact."""
    programme = (dem.confined(PRESSURE, 1e-7), *dem.uniaxial_compression(0.005, strain_rate=2e5))
    return dataclasses.replace(packing(120, ROUGH), programme=programme, adaptive_step=True)


def sheared() -> dem.Scene:
    """A box that leans in each of the three ways, under stress control, then simply sheared, and back."""
    bed = packing(120, ROUGH)
    tilted = bed.box._replace(tilt=tuple(part * bed.box.lengths[0] for part in (0.02, -0.01, 0.015)))
    place = bed.particles.position @ np.linalg.inv(bed.box.cell) @ tilted.cell
    programme = (dem.confined(PRESSURE, 2e-8), dem.simple_shear(0.01, 5e-8), dem.Stage((1.0, 1.0, 1.0), 5e-8))
    return dataclasses.replace(bed, particles=bed.particles._replace(position=place), box=tilted, programme=programme)


def walled(contact: dem.Contact = ROUGH) -> dem.Scene:
    """A lattice moved at random, periodic along x and y, just between two walls along z, pressed and released."""
    crystal, random = face_centred_cubic((3, 3, 3), RADIUS), np.random.default_rng(0)
    place = crystal.position + random.uniform(-0.01, 0.01, crystal.position.shape) * RADIUS
    place[:, 2] += RADIUS - place[:, 2].min()
    lengths = (*crystal.box.lengths[:2], float(place[:, 2].max()) + RADIUS)
    programme = dem.uniaxial_compression(0.005, strain_rate=2e5)
    box = Box(lengths, (True, True, False))
    return dem.Scene(spheres(place, RADIUS, DENSITY), box, contact, programme, walls=(False, False, True), outputs=5, frames=2)


def pressed_walls() -> dem.Scene:
    """The same between walls that move by themselves, both of them, to hold a pressure."""
    programme = (dem.Stage((1.0, 1.0, 1.0), 5e-8, stress=(None, None, PRESSURE)), dem.Stage((1.0, 1.0, 0.99), 5e-8))
    return dataclasses.replace(walled(), affine=False, moving_walls=0.3, programme=programme)


def kinds() -> dem.Scene:
    """Between walls, large and small spheres that meet by three laws of different memory, of which two have friction."""
    small = np.arange(108) % 3 == 0
    own = dem.Contact(Hertz(RADIUS, NMC.reduced_modulus), mindlin(0.2, NMC), None, damper(0.8, NMC))
    mixed = dem.Contact(Thornton(RADIUS, NMC.reduced_modulus, 1.42e9))
    bed = walled()
    bodies = spheres(bed.particles.position, np.where(small, 0.97 * RADIUS, RADIUS), DENSITY)._replace(kind=small.astype(np.int64))
    return dataclasses.replace(bed, particles=bodies, between=((0, 1, mixed), (1, 1, own)))


def relaxing() -> dem.Scene:
    """A law that depends on time, with friction and dampers, pressed and released in times that it sees."""
    material = PronyViscoelastic(NMC.youngs_modulus, NMC.poissons_ratio, (2e-8, 2e-7), (0.3, 0.3))
    law = maxwell_zener_ting(material.reduced, RADIUS, NMC.poissons_ratio)
    return packing(120, ROUGH._replace(normal=law), 0.005, 2e5)


#: pressure to hold in Pa
PRESSURE = 2e8
#: one of each thing that a scene may have
SCENES: dict[str, Callable[[], dem.Scene]] = {
    "compression": lambda: packing(120, ROUGH, 0.01, 2e5),
    "faces": faces,
    "stress": stress,
    "sheared": sheared,
    "walled": walled,
    "pressed walls": pressed_walls,
    "kinds": kinds,
    "relaxing": relaxing,
}


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


def paths(folder: Path | None = None) -> dict[str, np.ndarray]:
    """The path of each scene; of one that has a checkpoint in the folder, from there on."""
    results = {}
    for name, scene in SCENES.items():
        found = lammps_run.run(scene(), checkpoint=None if folder is None else folder / f"{name}.npz")
        if found is not None:
            energies = np.stack(found.energies[:-1])
            own = {"stress": found.stress, "coordination": found.coordination_number, "energies": energies, "strain": found.strain}
            results |= {f"{name} {quantity}": values for quantity, values in own.items()}
    return results


def _dying(fraction: float, text: str) -> None:
    if fraction > 0.5:
        os.kill(os.getpid(), signal.SIGKILL)


def killed(folder: Path) -> None:
    """Begin each scene in a process that dies halfway as if the power had failed, with the state saved at each output."""
    lammps_run.SAVE_EVERY = 0.0
    for name, scene in SCENES.items():
        child = os.fork()  # before anything of LAMMPS or MPI is loaded
        if child == 0:
            lammps_run.run(scene(), _dying, folder / f"{name}.npz")
            os._exit(0)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL, name


if __name__ == "__main__":
    what, place, *more = sys.argv[1:]
    if what == "killed":
        killed(Path(place))
        sys.exit()
    lammps = library()
    results = flight() if what == "flight" else paths(*map(Path, more))
    end = lammps.lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
    if end.extract_setting("world_rank") == 0:
        np.savez(place, ranks=end.extract_setting("world_size"), **results)
    end.finalize()
