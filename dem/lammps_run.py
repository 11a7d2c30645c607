"""A scene from start to end with LAMMPS as its engine: the same programme, the same table and frames as `dem.run`.

Between two outputs LAMMPS is on its own. At an output the first rank gets the spheres and what their contacts remember, and reads off the
state as if our own loop had come there, by the same functions. What all ranks must agree on, when to stop and when to save, is reduced.
"""

from __future__ import annotations

import dataclasses
import time as clock
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from contactlaws import dispatch
from contactlaws.errors import InputError, Problem, require
from contactlaws.version import code_version
from dem import checkpoint as disk
from dem import forces, lammps_forces, requirements
from dem.lammps_engine import Engine, Snapshot
from dem.lammps_forces import HELD, REMEMBERED, SLIP, TURNED
from dem.lammps_scope import problems_with
from dem.measure import largest_overlap
from dem.reduction import reduced
from dem.scene import Scene
from dem.simulation import (
    Log,
    Progress,
    counts_anew,
    interval_of,
    prepare,
    progress_line,
    reason_to_stop,
    restored_log,
    saved_log,
    statistics_of,
    write_down,
)
from dem.trajectory import Trajectory, trajectory
from dem.working import Working, relisted, turns, working

FloatArray = npt.NDArray[np.float64]

#: seconds between two checkpoints
SAVE_EVERY = 30.0


def run(scene: Scene, progress: Progress | None = None, checkpoint: Path | None = None) -> Trajectory | None:
    """Simulate `scene`; on several ranks each of them calls this, and the first gets the trajectory, the others None.

    With `checkpoint` (an .npz file) the state is saved now and then, LAMMPS's part of it beside that file. A run that finds it, on any
    number of ranks, goes on with the same bits as if it had never stopped; `forget` takes it away. Raises `InputError`, before computing,
    for anything that cannot be simulated by LAMMPS or at all.
    """
    require([*requirements.problems_with(scene), *problems_with(scene), *(disk.writable_problems(checkpoint) if checkpoint else ())])
    report, began = progress or (lambda fraction, text: None), clock.process_time()
    identity = {"scene": scene.content_hash, "code": code_version()}
    scene, replaced = reduced(scene, requirements.durations(scene))
    work = working(scene)
    require(requirements.overlap_problems(scene, largest_overlap(work)))
    plan = prepare(scene, work, replaced)
    for line in (*plan.notes, *(f"warning: {line}" for line in plan.warnings)):
        report(0.0, line)
    log, stopped, total = Log([], [], [], {"steps": 0, "pair_lists": 0, "cpu_seconds": 0.0}), None, len(scene.programme) * scene.outputs
    if checkpoint is not None and checkpoint.exists():
        log, engine, begun = _restored(scene, *disk.load(checkpoint, identity), checkpoint)
        reached = int(log.counts["output"])
        report(reached / total, f"going on from {checkpoint}")
    else:
        engine, reached, begun = Engine.of_scene(scene), 0, scene.box.cell
        write_down(scene, work, plan, log, 0.0, 0)
    first, before, saved, found = engine.rank == 0, log.counts["cpu_seconds"], 0.0, engine.agreed()
    try:
        for number in range(reached + 1, total + 1):
            stage, part = divmod(number - 1, scene.outputs)
            if part == 0 and counts_anew(scene, stage):
                begun = engine.cell
            interval = interval_of(scene, plan, begun, found.overlap, stage, part)
            engine.follow(interval)
            found, snapshot, crowded = engine.agreed(), engine.snapshot(), engine.crowded()
            if snapshot is not None:
                work = state(scene, engine.cell, engine.walls, snapshot)
                stopped = reason_to_stop(work, number, interval.dt) or crowded
            if found.depth >= 1.0 or crowded:  # then there is a reason
                break
            log.counts["steps"] += interval.steps
            log.counts["cpu_seconds"] = before + clock.process_time() - began
            if first:
                write_down(scene, work, plan, log, interval.dt, number)
            if checkpoint is not None and (found.clock - saved >= SAVE_EVERY or number == total):
                _save(engine, log, begun, number, identity, checkpoint)
                saved = found.clock
            if first:
                report(number / total, progress_line(log.rows[-1]))
    finally:
        engine.close()
    if not first:
        return None
    statistics = statistics_of(scene, plan, log, identity, work) | {"engine": "lammps"}
    return trajectory(scene, log.rows, log.frames, log.beyond, statistics, plan.notes, plan.warnings, stopped)


def forget(checkpoint: Path) -> None:
    """Delete a checkpoint, with LAMMPS's part of it."""
    checkpoint.unlink(missing_ok=True)
    for file in checkpoint.parent.glob(_restart_file(checkpoint, "*").name):
        file.unlink()


def _restart_file(checkpoint: Path, output: int | str) -> Path:
    return checkpoint.with_name(f"{checkpoint.stem}-{output}.restart")


def _save(engine: Engine, log: Log, begun: FloatArray, output: int, identity: dict[str, str], checkpoint: Path) -> None:
    """LAMMPS's file first, then ours, which names it: a kill at any moment leaves a whole pair."""
    engine.save(_restart_file(checkpoint, output))
    if engine.rank == 0:
        log.counts["output"] = output
        numbers, arrays = saved_log(log)
        disk.save(checkpoint, identity, numbers, arrays | {"cell": engine.cell, "walls": engine.walls, "begun": begun})
        for file in checkpoint.parent.glob(_restart_file(checkpoint, "*").name):
            if file != _restart_file(checkpoint, output):
                file.unlink()


def _restored(
    scene: Scene, numbers: dict[str, Any], arrays: dict[str, npt.NDArray[Any]], checkpoint: Path
) -> tuple[Log, Engine, FloatArray]:
    log = restored_log(scene, numbers, arrays)
    file = _restart_file(checkpoint, int(log.counts["output"]))
    if not file.exists():
        raise InputError(Problem("checkpoint", str(file), "is missing", f"delete {checkpoint} to start from the beginning"))
    return log, Engine.restored(file, scene, arrays["cell"], arrays["walls"]), arrays["begun"]


def state(scene: Scene, cell: FloatArray, walls: FloatArray, snapshot: Snapshot) -> Working:
    """Our own record of a state of LAMMPS's, in the box of edge vectors `cell` (m) with `walls` as in `forces.Frame`."""
    own = scene.particles.id - 1
    spin = snapshot.spin[own] if turns(scene) else None
    particles = scene.particles._replace(position=snapshot.position[own], velocity=snapshot.velocity[own], spin=spin)
    work = working(dataclasses.replace(scene, particles=particles, box=scene.box.with_cell(cell)))
    if len(walls):
        work.walls[:] = walls
        work = relisted(work)
    _remember(work, scene.particles.id[work.order], snapshot)
    sums = snapshot.sums
    work.virial[:] = 0.0
    work.virial[0] = np.diag(sums[:, lammps_forces.VIRIAL : lammps_forces.VIRIAL + 3].sum(axis=0))
    for column, axes in enumerate(lammps_forces.ACROSS):
        work.virial[0][axes] = sums[:, lammps_forces.LEANING + column].sum()
    work.tally[:] = 0.0
    work.tally[0, forces.LARGEST] = sums[:, lammps_forces.LARGEST].max(initial=0.0)
    for name in ("LOST", "SHEARED", "DAMPED", "DRAGGED", "WORK"):
        work.tally[0, getattr(forces, name)] = sums[:, getattr(lammps_forces, name)].sum()
    return work


def _remember(work: Working, numbers: npt.NDArray[np.int64], snapshot: Snapshot) -> None:
    """Give the contacts of a state what they remember; `numbers` are those of its spheres."""
    for kind, group in zip(work.kinds, work.groups, strict=True):
        past, first = group.past, numbers[group.rows.first]
        second = -1 - group.rows.partner.astype(np.int64) if kind.second is None else numbers[group.rows.partner]
        slots = snapshot.partner[first - 1] == second[:, None]
        remembered = np.where(slots.any(axis=1)[:, None], snapshot.memory[first - 1, slots.argmax(axis=1)], 0.0)
        if group.memory is not None:
            group.memory[:] = remembered[:, : dispatch.floats_of_state(group.roles.normal)]
        beyond = remembered[:, -REMEMBERED:].T  # of the laws; not there, and not asked for, where nothing asks for speeds
        for array, column, size in ((past.slip, SLIP, 4), (past.roll, TURNED, 3)):
            if array is not None:
                array[:] = beyond[column : column + size]
        if past.damping is not None:
            past.damping[:] = beyond[HELD]
