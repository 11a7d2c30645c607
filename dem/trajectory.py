"""The result of a run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from dem.measure import Energies
from dem.record import COLUMNS, Beyond, Frame
from dem.requirements import QUASI_STATIC, typical_force
from dem.scene import Scene
from dem.timestep import scene_time_step

FloatArray = npt.NDArray[np.float64]

#: what the energy balance must close to
BALANCE = 1e-3
#: an energy that counts, over that of a force which does on a way of one radius: some 1e-10 of the radius deep; below lies round-off
SMALLEST_ENERGY = 1e-24
#: kinetic over stored energy at the highest pressure, beyond which a loading is not slow
SLOW = 0.01
#: time step over the critical one beyond which leap-frog is no longer accurate
CAREFUL = 0.5
#: how far from the largest stress asked for a stage may end
MISSED = 0.05


@dataclass(frozen=True)
class Trajectory:
    """One row per output; the first is the start. Compression is positive in strain and stress."""

    time: FloatArray  # s
    stage: npt.NDArray[np.int64]  # of the programme
    strain: FloatArray  # engineering, per axis, shape (n, 3)
    stress: FloatArray  # Pa, shape (n, 3, 3); contact and kinetic part
    coordination_number: FloatArray  # mean over all particles, contacts that carry force
    coordination_number_held: FloatArray  # mean over those that are no rattlers, rattlers' contacts not counted
    rattlers: npt.NDArray[np.int64]
    packing_fraction: FloatArray
    shear: FloatArray  # change of tilt over the height: xy, xz, yz; shape (n, 3)
    fabric: FloatArray  # mean of n n over contacts of spheres, shape (n, 3, 3)
    contacts_beyond: npt.NDArray[np.int64]  # contacts outside the range that their law was fitted for
    beyond: tuple[Beyond, ...]  # the deepest of them, of each output that has any
    energies: Energies
    frames: tuple[Frame, ...]
    statistics: Mapping[str, Any]  # dt, dt over critical, steps, lists made, cost in CPU seconds, code version, law, ...; JSON types
    notes: tuple[str, ...]  # what was left out and why, how the box moves, how fast
    warnings: tuple[str, ...]  # what to distrust
    stopped: str | None = None  # why it ends before its programme does

    @property
    def pressure(self) -> FloatArray:
        """Pa; a third of the trace of the stress."""
        return np.trace(self.stress, axis1=1, axis2=2) / 3.0


def trajectory(
    scene: Scene,
    rows: list[list[float]],
    frames: list[Frame],
    beyond: list[Beyond],
    statistics: dict[str, Any],
    notes: tuple[str, ...],
    warnings: tuple[str, ...],
    stopped: str | None,
) -> Trajectory:
    """The record made of the rows of a run (see record.COLUMNS), with the warnings that only its end can give."""
    column = dict(zip(COLUMNS, np.array(rows).T, strict=True))
    energies = Energies(*(column[name] for name in Energies._fields))
    stress, fabric = (
        np.stack([column[f"{n} {a}{b}"] for a in "xyz" for b in "xyz"], axis=-1).reshape(-1, 3, 3) for n in ("stress", "fabric")
    )
    top = int(np.argmax(energies.stored))
    held = float(np.max(sum(energies[:-1])))
    worth = SMALLEST_ENERGY * typical_force(scene) * float(np.mean(scene.particles.radii)) if scene.particles.size else 0.0
    summary = {
        "energy_balance": float(np.abs(energies.balance).max()) * (held / worth if held < worth else 1.0),
        "kinetic_over_stored_at_peak": float(energies.kinetic[top] / energies.stored[top]) if energies.stored[top] > 0.0 else None,
        "largest_overlap": float(column["largest overlap"].max()),
        "inertial_number_at_peak": _inertial_number_at(top, scene, column),
        "time_step_over_critical_at_largest_overlap": _step_over_critical(scene, float(column["largest overlap"].max()), statistics["dt"]),
    }
    late = _late_warnings(scene, column, summary, beyond)
    return Trajectory(
        time=column["time"],
        stage=column["stage"].astype(np.int64),
        strain=np.stack([column[f"strain {a}"] for a in "xyz"], axis=-1),
        stress=stress,
        coordination_number=column["coordination"],
        coordination_number_held=column["coordination held"],
        rattlers=column["rattlers"].astype(np.int64),
        packing_fraction=column["packing fraction"],
        shear=np.stack([column[f"shear {a}"] for a in ("xy", "xz", "yz")], axis=-1),
        fabric=fabric,
        contacts_beyond=column["contacts beyond"].astype(np.int64),
        beyond=tuple(beyond),
        energies=energies,
        frames=tuple(frames),
        statistics=statistics | summary,
        notes=notes,
        warnings=(*warnings, *late, *(() if stopped is None else (stopped,))),
        stopped=stopped,
    )


def _inertial_number_at(output: int, scene: Scene, column: dict[str, FloatArray]) -> float | None:
    """Strain rate times d sqrt(rho/p) with the pressure there; None without motion or pressure."""
    if output == 0:
        return None
    moved = ("time", *(f"strain {a}" for a in "xyz"), *(f"shear {a}" for a in ("xy", "xz", "yz")))
    steps = [column[name][output] - column[name][output - 1] for name in moved]
    rate = max(abs(step) for step in steps[1:]) / steps[0]
    pressure = sum(column[f"stress {axis}{axis}"][output] for axis in "xyz") / 3.0
    if rate == 0.0 or pressure <= 0.0:
        return None
    bodies = scene.particles
    return float(rate) * 2.0 * float(bodies.radii.mean()) * math.sqrt(float(scene.masses.sum() / bodies.solid_volume / pressure))


def _step_over_critical(scene: Scene, relative_overlap: float, steps: list[float]) -> float:
    """The largest time step over the critical one of a scene whose deepest contact was this deep (one body, over its radius)."""
    if not scene.particles.size or relative_overlap == 0.0 or not steps:
        return 0.0
    overlap = 2.0 * relative_overlap * float(scene.particles.radii.max())
    return max(steps, default=0.0) / scene_time_step(scene, overlap, 1.0).critical


def _late_warnings(scene: Scene, column: dict[str, FloatArray], summary: dict[str, Any], beyond: list[Beyond]) -> Iterator[str]:
    deepest, still = summary["largest_overlap"], scene.quasi_static is not None
    limits = [contact.fitted_overlap for contact in scene.contacts]
    if beyond:
        most, worst = int(column["contacts beyond"].max()), max(beyond, key=lambda contact: contact.depth)
        where = "a wall" if worst.second is None else f"particle {worst.second}"
        x, y, z = worst.position
        yield (
            f"overlap left the range the law was fitted for: up to {most} contacts at an output, largest D = {worst.depth:.4g} between "
            f"particle {worst.first} at ({x:.4g}, {y:.4g}, {z:.4g}) m and {where} at output {worst.output}"
        )
    elif None not in limits and deepest > max(limit or 0.0 for limit in limits):
        yield f"overlap left the range the law was fitted for between outputs: largest D = {deepest:.4g}; ask for more outputs to see where"
    yield from _missed_stresses(scene, column)
    if not still and summary["time_step_over_critical_at_largest_overlap"] > max(CAREFUL, 1.001 * scene.time_step_fraction):
        yield f"contacts got deeper than expected (D = {deepest:.4g}): the time step is no longer small, take a smaller time_step_fraction"
    if summary["energy_balance"] > BALANCE:
        yield f"the energy balance closes to {summary['energy_balance']:.2g} only: take smaller {'strain' if still else 'time'} steps"
    if (scene.drag is not None or scene.density_scaling != 1.0) and not still:
        ratio, number = summary["kinetic_over_stored_at_peak"], summary["inertial_number_at_peak"]
        if ratio is not None and ratio > SLOW:
            yield f"kinetic energy is {ratio:.2g} > {SLOW:g} of the stored one at the peak: take a smaller inertial_number to be slow"
        if number is not None and number > QUASI_STATIC:
            yield f"inertial number {number:.2g} > {QUASI_STATIC:g} with the pressure that was reached: inertia shows in the stress"


def _missed_stresses(scene: Scene, column: dict[str, FloatArray]) -> Iterator[str]:
    """Stages that end away from the stress they were to reach."""
    for number, stage in enumerate(scene.programme):
        rows = np.flatnonzero((column["stage"] == number) & (column["time"] > 0.0))
        largest = max((stress for stress in stage.stress if stress is not None), default=0.0)
        if len(rows) < scene.outputs:
            continue
        for axis, wanted in zip("xyz", stage.stress, strict=True):
            reached = float(column[f"stress {axis}{axis}"][rows[-1]])
            if wanted is not None and abs(reached - wanted) > MISSED * largest:
                yield f"stage {number} ends with {reached:.3g} Pa along {axis} in place of {wanted:.3g} Pa: give it a longer duration"
