"""Where the time step breaks: of the critical step that is derived from the law, for every kind of law, and where the estimate ends."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

import dem
from cases.verification.dem_extreme_trial import DENSITY, HERTZ, MATERIAL, RADIUS, FloatArray, Trial, shaken
from contactlaws.curve import Curve
from contactlaws.elastoplastic import Thornton, thornton_recovered, thornton_yield_overlap
from contactlaws.maxwell_zener import maxwell_zener
from contactlaws.path import scan
from contactlaws.prony import Relaxation
from contactlaws.tabulate import from_curve
from contactlaws.tabulated_record import Tabulated
from contactlaws.tangential import damper, mindlin
from contactlaws.whole_range import whole_range
from dem.measure import energies, kinetic_energy, largest_overlap
from dem.motion import Deformation
from dem.timestep import scene_time_step
from dem.working import follow, working

#: of the critical step
FRACTIONS = (0.01, 0.1, 0.4, 0.8, 0.95, 1.0, 1.1, 1.3, 1.5, 1.7, 1.8, 2.0, 2.2)
#: steps after which a motion that grows has grown beyond doubt, and by how much
STEPS_TAKEN, GROWN = 3000, 100.0


@cache
def tabulated() -> Tabulated:
    """The table of a curve that Thornton's law gives."""
    law, top = Thornton(RADIUS, MATERIAL.reduced_modulus, 1.6 * 7.9e9), 0.05 * RADIUS
    branches = [np.geomspace(1e-4, 1.0, 80) * top]
    scans = [scan(law, branches[0])]
    for share in (0.6, 0.8, 1.0):
        there = branches[0][branches[0] <= share * top * (1.0 + 1e-12)]
        down = np.linspace(there[-1], there[-1] - thornton_recovered(law, there[-1]), 40)
        branches.append(down)
        scans.append(scan(law, np.concatenate((there, down[1:]))))
    tails = [slice(-path.size, None) for path in branches]
    force = [part.force[rows].copy() for part, rows in zip(scans, tails, strict=True)]
    for unloading in force[1:]:
        unloading[-1] = 0.0
    return from_curve(
        Curve(
            time=np.arange(sum(path.size for path in branches), dtype=float),
            overlap=np.concatenate(branches),
            force=np.concatenate(force),
            branch=np.concatenate([np.full(path.size, k) for k, path in enumerate(branches)]),
            radius=RADIUS,
            contact_radius=np.concatenate([part.contact_radius[rows] for part, rows in zip(scans, tails, strict=True)]),
            material=MATERIAL,
            yield_overlap=float(thornton_yield_overlap(law)),
        )
    )


def contacts() -> dict[str, dem.Contact]:
    """Of every kind of law, and with the other roles."""
    return {
        "hertz": dem.Contact(HERTZ),
        "thornton": dem.Contact(Thornton(RADIUS, MATERIAL.reduced_modulus, 1e-3 * MATERIAL.reduced_modulus)),
        "whole_range": dem.Contact(whole_range(MATERIAL, RADIUS)),
        "maxwell_zener": dem.Contact(maxwell_zener(Relaxation(2175.3e6, (0.2285,), (1.8,)), RADIUS)),
        "tabulated": dem.Contact(tabulated()),
        "hertz with friction": dem.Contact(HERTZ, mindlin(10.0, MATERIAL)),
        "hertz with a damper (e = .3)": dem.Contact(HERTZ, None, None, damper(0.3, MATERIAL)),
    }


def grows(contact: dem.Contact, fraction: float, squeezed: float = 0.99) -> bool:
    """Whether small random motion about a compressed lattice grows, at this fraction of the critical step."""
    packing = shaken(squeezed, 0.0)
    velocity = np.random.default_rng(1).normal(size=packing.position.shape) * 1e-3
    bodies = dem.spheres(packing.position, RADIUS, DENSITY, velocity)
    made = dem.Scene(bodies, packing.box, contact, (dem.hold(1.0),))
    work = working(made)
    start = kinetic_energy(work)
    dt = scene_time_step(made, largest_overlap(work), fraction).dt
    with np.errstate(all="ignore"):
        for _ in range(0, STEPS_TAKEN, 100):
            work, _ = follow(work, Deformation(work.cell.copy(), work.cell.copy(), 10**9, dt), 0, 100)
            if not kinetic_energy(work) <= GROWN * start:
                return True
    return False


def breaks(contact: dem.Contact) -> float | None:
    """The smallest of the fractions at which motion grows; None if none is."""
    return next((fraction for fraction in FRACTIONS if grows(contact, fraction)), None)


def _text(found: float | None) -> str:
    return f"stable to {FRACTIONS[-1]}" if found is None else f"breaks at {found:g} of the critical step"


def lattices() -> list[Trial]:
    """Small motion about a compressed crystal, twelve contacts on each sphere, for every law."""
    trials = []
    for name, contact in contacts().items():
        found = breaks(contact)
        sound = found is None or found > 1.0
        verdict = "finite and right" if sound else "ESTIMATE UNSAFE"
        done = f"steps of {FRACTIONS[0]} to {FRACTIONS[-1]} of the critical one, crystal, {name}"
        trials.append(Trial(done, _text(found), "> 1", sound, verdict))
    return trials


def sphere_points(count: int) -> FloatArray:
    """Directions spread evenly (a spiral)."""
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    return np.stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z], axis=1)


def shell(ratio: float, count: int, light: float, fraction: float) -> bool:
    """Whether energy grows where a large sphere, `light` times as heavy as each of `count` small ones, is held by them all around."""
    large, depth = ratio * RADIUS, 1e-3 * RADIUS
    places = np.concatenate([np.zeros((1, 3)), sphere_points(count) * (large + RADIUS - depth)])
    bodies = dem.spheres(places, np.concatenate([[large], np.full(count, RADIUS)]), DENSITY)
    mass = np.full(count + 1, 1.0)
    mass[0] = light
    bodies = bodies._replace(mass=mass)
    box = dem.Box((10.0 * large,) * 3, (False,) * 3)
    made = dem.Scene(bodies, box, dem.Contact(HERTZ), (dem.hold(1.0),), skin=0.01)
    work = working(made)
    held = sum(energies(work)[:2])
    dt = scene_time_step(made, largest_overlap(work), fraction).dt
    work, _ = follow(work, Deformation(work.cell.copy(), work.cell.copy(), 10**9, dt), 0, 500)
    return not sum(energies(work)[:2]) <= 1.1 * held


def light_spheres() -> list[Trial]:
    """More than twelve contacts on the lightest sphere: a large light one among small heavy ones, at the step that runs take."""
    trials = []
    for ratio, count in ((3.0, 50), (5.0, 110), (10.0, 380), (20.0, 1400)):
        found = shell(ratio, count, 1e-6, 0.4)
        done = f"{count} small spheres, each 1e6 times as heavy, all around one of {ratio:g} times their radius, .4 of the critical step"
        trials.append(Trial(done, "grows" if found else "stable", "stable", not found, "ESTIMATE UNSAFE" if found else "finite and right"))
    return trials


STEPS: dict[str, Callable[[], list[Trial]]] = {"time-step": lattices, "light-spheres": light_spheres}
