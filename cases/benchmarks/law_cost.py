"""What each law of this project costs: nanoseconds per contact alone and in the DEM's pair kernel, while loading, unloading and reloading.

    python -m cases.benchmarks.law_cost [LAW ...]

Every law is that of one material, as the atlas foretells its curve (`calibration.predict`). A law in time belongs to the same elastic body,
whose modulus relaxes in 1 to 8 terms from 1000 time steps on. Alone: one compiled loop over contacts with
their memory in an array, as a simulation keeps it. In the pair kernel: packed spheres, shrunk or swelled a little before every pass so that
every contact goes on; the time of a pass over the contacts that touch. A law that does not know what it went through unloads as it loads.
The laws take turns and the least of many passes counts, so their ratios hold on a busy machine. One thread; compiled before.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

import calibration
import dem
from calibration.recipes import recipe_for
from contactlaws import dispatch
from contactlaws.compiled import kernel
from contactlaws.errors import InputError, Problem
from contactlaws.material import Material
from contactlaws.maxwell_zener import maxwell_zener
from contactlaws.maxwell_zener_ting import maxwell_zener_ting
from contactlaws.prony import Relaxation
from contactlaws.rivals.hertz_spring_dashpot import hertz_spring_dashpot
from contactlaws.rivals.kuwabara_kono import kuwabara_kono
from contactlaws.rivals.wahn_gan_kamlah import wahn_gan_kamlah
from contactlaws.whole_range import whole_range_compact
from dem.measure import network
from dem.packing import Packing, random_close_packing
from dem.working import renew_forces, working

FloatArray = npt.NDArray[np.float64]

RADIUS, MATERIAL = 5e-6, Material(142e9, 0.25, 7.9e9, 4750.0)
SPHERES, PACKING_FRACTION, SQUEEZE = 4_000, 0.6, 0.95
CONTACTS, DEEPEST = 10_000, 0.2  # alone: contacts, and their largest overlap over the radius
STEP, PASSES, WARM_UP = 1e-6, 60, 2
BASE = "hertz"
TERMS, RELAXING, TIME_STEP = (1, 2, 3, 5, 8), 0.5, 1e-9
#: the way of the overlap in each phase; the last pass of reloading ends where unloading began, so no last pass counts
PHASES = {"loading": 1.0, "unloading": -1.0, "reloading": 1.0}


class Cost(NamedTuple):
    """ns per contact, in the order of `PHASES`."""

    alone: tuple[float, ...]
    pair: tuple[float, ...]


@kernel
def _alone(law, overlap, closing, memory):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(overlap.size):
        force, state = dispatch.normal_force(law, overlap[i], closing * overlap[i], TIME_STEP, dispatch.load_state(law, memory, i))
        dispatch.put_back(law, memory, i, state)
        total += force
    return total


def records(names: Sequence[str] = ()) -> dict[str, Any]:
    """One record of each law of this project (or of those named, and Hertz's) for the same material, Hertz's first; by name and terms."""
    known = [name for name, law in dispatch.laws().items() if law.record.__module__.startswith(f"{dispatch.OWN}.")]
    for name in names:
        if name not in known:
            raise InputError(Problem("law", name, f"must be one of {', '.join(known)}", "leave it out for all of them"))
    wanted = [name for name in known if name in names or not names]
    return {label: law for name in dict.fromkeys((BASE, *wanted)) for label, law in _records(name).items()}


def _records(name: str) -> dict[str, Any]:
    """One, or one for each number of terms."""
    if name == "maxwell_zener":
        return {f"{name}, N = {terms}": maxwell_zener(_relaxation(terms), RADIUS, MATERIAL.poissons_ratio) for terms in TERMS}
    if name == "maxwell_zener_ting":
        return {f"{name}, N = {terms}": maxwell_zener_ting(_relaxation(terms), RADIUS, MATERIAL.poissons_ratio) for terms in TERMS}
    return {name: _record(name)}


def _relaxation(terms: int) -> Relaxation:
    """Equal terms, a factor of ten apart."""
    return Relaxation(MATERIAL.reduced_modulus, (RELAXING / terms,) * terms, tuple(float(TIME_STEP * 10.0**k) for k in range(3, 3 + terms)))


def _record(name: str) -> Any:
    if name == "wahn_gan_kamlah":
        return wahn_gan_kamlah(_relaxation(1), RADIUS)
    if name == "kuwabara_kono":
        return kuwabara_kono(_relaxation(1), RADIUS)
    if name == "hertz_spring_dashpot":
        return hertz_spring_dashpot(MATERIAL, RADIUS, 0.5)
    if name == "whole_range_compact":  # made of the material alone
        return whole_range_compact(MATERIAL, RADIUS)
    return calibration.predict(MATERIAL, radius=RADIUS, max_overlap=DEEPEST, law=recipe_for(name).law).law.law


class _Contacts:
    """Contacts of all depths on one law, moved a little for each pass."""

    def __init__(self, law: Any):
        self.law, self.scale = law, 1.0
        self.overlap = np.random.default_rng(1).uniform(0.01, 1.0, CONTACTS) * DEEPEST * RADIUS
        self.memory = np.zeros((CONTACTS, dispatch.floats_of_state(law)))

    def timed(self, way: float) -> float:
        """Move by one step, then time one pass; ns per contact."""
        self.scale += way * STEP
        moved = self.overlap * self.scale
        began = time.perf_counter()
        _alone(self.law, moved, way * STEP / TIME_STEP, self.memory)
        return (time.perf_counter() - began) / CONTACTS * 1e9


class _Packed:
    """The packed spheres on one law, to be passed over again and again."""

    def __init__(self, law: Any, packing: Packing):
        bodies, box = dem.spheres(SQUEEZE * packing.position, RADIUS, 4750.0), packing.box.stretched((SQUEEZE,) * 3)
        self.work = working(dem.Scene(bodies, box, dem.Contact(law), (dem.hold(1.0),)))
        self.start, self.cell, self.scale = self.work.bodies.position.copy(), self.work.cell.copy(), 1.0
        self.contacts = len(network(self.work).first)

    def timed(self, way: float) -> float:
        """Scale lengths by one step, then time one pass over all pairs; ns per contact."""
        work, self.scale = self.work, self.scale - way * STEP
        work.bodies.position[:], work.cell[:] = self.start * self.scale, self.cell * self.scale
        began = time.perf_counter()
        renew_forces(work, -way * STEP / TIME_STEP * np.eye(3), TIME_STEP)
        return (time.perf_counter() - began) / self.contacts * 1e9


def measure(laws: Mapping[str, Any]) -> dict[str, Cost]:
    """The least of `PASSES` passes of each phase, the laws taking turns."""
    packing = random_close_packing(SPHERES, PACKING_FRACTION, RADIUS, seed=1)
    alone = {name: _Contacts(law) for name, law in laws.items()}
    packed = {name: _Packed(law, packing) for name, law in laws.items()}
    found = {name: Cost((), ()) for name in laws}
    for way in PHASES.values():
        rows = np.array([[(alone[name].timed(way), packed[name].timed(way)) for name in laws] for _ in range(PASSES)])
        for name, (own, pair) in zip(laws, rows[WARM_UP:-1].min(axis=0).tolist(), strict=True):
            found[name] = Cost((*found[name].alone, own), (*found[name].pair, pair))
    return found


def rows(found: Mapping[str, Cost], laws: Mapping[str, Any]) -> list[str]:
    """One line per law: bytes that a contact remembers, ns per contact, and in brackets how many times Hertz's in the same phase."""
    heads = [f"{place}: {phase}" if not number else phase for place in ("alone", "pair kernel") for number, phase in enumerate(PHASES)]
    lines = [f"{'ns per contact (times Hertz)':30s}{'bytes':>8s}" + "".join(f"{head:>22s}" for head in heads)]
    base = found[BASE]
    for name, cost in found.items():
        memory, timeless = dispatch.floats_of_state(laws[name]), not dispatch.law_of(laws[name]).in_time
        cells = f"{8 * memory:8d}"
        for own, other in ((cost.alone, base.alone), (cost.pair, base.pair)):
            for number, (value, hertz) in enumerate(zip(own, other, strict=True)):
                same = number and timeless and not memory
                cells += f"{'as loading' if same else f'{value:.1f} ({value / hertz:.2f})':>22s}"
        lines.append(f"{name:30s}{cells}")
    return lines


def main(names: Sequence[str]) -> None:
    """Measure and print."""
    laws = records(names)
    print("\n".join(rows(measure(laws), laws)))


if __name__ == "__main__":
    main(sys.argv[1:])
