"""One packing under compression and release with one setting: three stresses and a cost, a file of numbers for each, never half written."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import calibration
import dem
from cases.tradeoff.dem_settings import DENSITY, FITTED_TO, MATERIAL, PACKING_FRACTION, RADIUS, SCENE, STRAIN, Setting
from cases.tradeoff.kept import kept, place
from contactlaws.whole_range import whole_range_compact
from dem.packing import Packing, random_close_packing
from dem.requirements import durations
from dem.scene import QuasiStatic

#: axial stresses in Pa, compression positive; the means are over strain: work per volume over the largest strain
QUANTITIES = ("peak", "loading", "release")
OUTPUTS = 30  # per stage
#: spheres and strain of the run that compiles what a setting needs
FEW, LITTLE = 30, 1e-4

Progress = Callable[[float, str], None]
Results = dict[tuple[Setting, int], dict[str, Any]]


def measure(runs: Sequence[tuple[Setting, int]], folder: Path, progress: Progress = lambda fraction, text: None) -> Results:
    """The result of each setting on the packing of each seed; those whose file is in `folder` already are read."""
    _compile([setting for setting, seed in runs if not place(folder, __name__, *_values(setting, seed)).exists()], progress)
    found, whole, done = {}, sum(map(_effort, runs)), 0.0
    for setting, seed in runs:
        progress(done / whole, f"{setting.spheres} spheres, packing {seed}")
        found[setting, seed] = kept(folder, __name__, _values(setting, seed), partial(_run, setting, seed, folder))
        done += _effort((setting, seed))
    return found


def _values(setting: Setting, seed: int) -> tuple[object, ...]:
    """All that a run depends on."""
    return *SCENE, *setting, seed


def _effort(run: tuple[Setting, int]) -> float:
    """What a run costs beside others, roughly."""
    setting = run[0]
    steps = 1.0 / (setting.time_step_fraction * setting.inertial_number * setting.density_scaling**0.5)
    return setting.spheres * (steps if setting.strain_step is None else 20.0 / setting.strain_step)


@functools.cache
def law_of(name: str) -> Any:
    """The record of a law for the material: made of its constants alone, or fitted to what the atlas of finite-element curves foretells."""
    if name == "whole_range_compact":
        return whole_range_compact(MATERIAL, RADIUS)
    return calibration.predict(MATERIAL, radius=RADIUS, max_overlap=FITTED_TO, law=name).law.law


def scene_of(setting: Setting, packing: Packing, strain: float = STRAIN) -> dem.Scene:
    """Uniaxial compression and release. Density scaling leaves the strain rate as it is."""
    contact = dem.Contact(law_of(setting.law), setting.tangential, fitted_overlap=FITTED_TO)
    options: dict[str, Any] = {"inertial_number": setting.inertial_number, "time_step_fraction": setting.time_step_fraction}
    if setting.strain_step is not None:
        options["quasi_static"] = QuasiStatic(strain_step=setting.strain_step)
    asked = partial(dem.packed_scene, packing, DENSITY, contact, outputs=OUTPUTS, frames=1, **options)
    programme = dem.uniaxial_compression(strain)
    true = asked(programme=programme)
    timed = tuple(stage._replace(duration=duration) for stage, duration in zip(programme, durations(true), strict=True))
    return asked(programme=timed, density_scaling=setting.density_scaling)


def run(setting: Setting, packing: Packing) -> dict[str, Any]:
    """Numbers of one run; JSON types."""
    done = dem.run(scene_of(setting, packing))
    facts = {name: done.statistics[name] for name in ("cpu_seconds", "steps", "kinetic_over_stored_at_peak", "largest_overlap")}
    facts["stopped"] = done.stopped
    return facts if done.stopped else facts | stresses(done)


def stresses(done: dem.Trajectory) -> dict[str, float]:
    """Each of `QUANTITIES`."""
    strain, stress = done.strain[:, 2], done.stress[:, 2, 2]
    top = OUTPUTS
    work = [float(np.trapezoid(stress[rows], strain[rows])) for rows in (slice(0, top + 1), slice(top, None))]
    return {"peak": float(stress[top]), "loading": work[0] / float(strain[top]), "release": -work[1] / float(strain[top])}


def _run(setting: Setting, seed: int, folder: Path) -> dict[str, Any]:
    packing, cost = _packing(setting.spheres, seed, folder)
    return run(setting, packing) | {"packing_cpu_seconds": cost}


def _packing(spheres: int, seed: int, folder: Path) -> tuple[Packing, float]:
    """From its file, and what it cost in CPU seconds."""
    position, lengths, cost = kept(folder, __name__, (*SCENE, "packing", spheres, seed), partial(_packed, spheres, seed))
    return Packing(np.array(position), RADIUS, dem.Box(tuple(lengths)), PACKING_FRACTION, 0.0), cost


def _packed(spheres: int, seed: int) -> tuple[list[list[float]], tuple[float, float, float], float]:
    began = time.process_time()
    made = random_close_packing(spheres, PACKING_FRACTION, RADIUS, seed)
    return made.position.tolist(), made.box.lengths, time.process_time() - began


def _compile(settings: Sequence[Setting], progress: Progress) -> None:
    """Compiled code is there before time is taken."""
    kinds = {(s.law, s.tangential is None, s.strain_step is None): s for s in settings}
    if not kinds:
        return
    packing = random_close_packing(FEW, PACKING_FRACTION - 0.05, RADIUS, 1)
    for number, setting in enumerate(kinds.values()):
        progress(0.0, f"compiling {number + 1} of {len(kinds)}: {setting.law.replace('_', ' ')}")
        quick = setting._replace(inertial_number=0.1, time_step_fraction=0.4)
        dem.run(scene_of(quick, packing, LITTLE))
