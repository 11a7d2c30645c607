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
from dem.working import Working, renew_forces, working

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
        log, engine = _restored(scene, *disk.load(checkpoint, identity), checkpoint)
        reached = int(log.counts["output"])
        report(reached / total, f"going on from {checkpoint}")
    else:
        engine, reached = Engine.of_scene(scene), 0
        write_down(scene, work, plan, log, 0.0, 0)
    first, before, saved = engine.rank == 0, log.counts["cpu_seconds"], 0.0
    try:
        for number in range(reached + 1, total + 1):
            interval = interval_of(scene, work, plan, *divmod(number - 1, scene.outputs))
            engine.follow(interval)
            (deepest, now), snapshot = engine.agreed(), engine.snapshot()
            if snapshot is not None:
                work = state(scene, interval.end, snapshot)._replace(begun=work.begun)
                stopped = reason_to_stop(work, number, interval.dt)
            if deepest >= 1.0:  # then there is a reason
                break
            log.counts["steps"] += interval.steps
            log.counts["cpu_seconds"] = before + clock.process_time() - began
            if first:
                write_down(scene, work, plan, log, interval.dt, number)
            if checkpoint is not None and (now - saved >= SAVE_EVERY or number == total):
                _save(engine, log, number, identity, checkpoint)
                saved = now
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


def _save(engine: Engine, log: Log, output: int, identity: dict[str, str], checkpoint: Path) -> None:
    """LAMMPS's file first, then ours, which names it: a kill at any moment leaves a whole pair."""
    engine.save(_restart_file(checkpoint, output))
    if engine.rank == 0:
        log.counts["output"] = output
        disk.save(checkpoint, identity, *saved_log(log))
        for file in checkpoint.parent.glob(_restart_file(checkpoint, "*").name):
            if file != _restart_file(checkpoint, output):
                file.unlink()


def _restored(scene: Scene, numbers: dict[str, Any], arrays: dict[str, npt.NDArray[Any]], checkpoint: Path) -> tuple[Log, Engine]:
    log = restored_log(scene, numbers, arrays)
    file, widest = _restart_file(checkpoint, int(log.counts["output"])), float(scene.particles.radii.max())
    if not file.exists():
        raise InputError(Problem("checkpoint", str(file), "is missing", f"delete {checkpoint} to start from the beginning"))
    return log, Engine.restored(file, scene.contact, 2.0 * widest * scene.skin, widest)


def state(scene: Scene, cell: npt.NDArray[np.float64], snapshot: Snapshot) -> Working:
    """Our own record of a state of LAMMPS's, in the box of edge vectors `cell` (m)."""
    own = scene.particles.id - 1
    spin = None if scene.contact.tangential is None else snapshot.spin[own]
    particles = scene.particles._replace(position=snapshot.position[own], velocity=snapshot.velocity[own], spin=spin)
    work = working(dataclasses.replace(scene, particles=particles, box=scene.box.with_cell(cell)))
    _remember(work, scene.particles.id[work.order], snapshot)
    renew_forces(work)
    sums = snapshot.sums
    work.tally[:] = 0.0
    work.tally[0, forces.LARGEST] = sums[:, lammps_forces.LARGEST].max(initial=0.0)
    for name in ("LOST", "SHEARED", "DAMPED", "DRAGGED", "WORK"):
        work.tally[0, getattr(forces, name)] = sums[:, getattr(lammps_forces, name)].sum()
    return work


def _remember(work: Working, numbers: npt.NDArray[np.int64], snapshot: Snapshot) -> None:
    """Give the contacts of a state what they remember; `numbers` are those of its spheres."""
    group, past = work.groups[0], work.groups[0].past
    first, second = (numbers[rows] for rows in (group.rows.first, group.rows.partner))
    slots = snapshot.partner[first - 1] == second[:, None]
    remembered = np.where(slots.any(axis=1)[:, None], snapshot.memory[first - 1, slots.argmax(axis=1)], 0.0)
    if group.memory is not None:
        group.memory[:] = remembered[:, : dispatch.floats_of_state(group.roles.normal)]
    beyond = remembered[:, -REMEMBERED:].T  # of the law; not there, and not asked for, where nothing asks for speeds
    for array, column, size in ((past.slip, SLIP, 4), (past.roll, TURNED, 3)):
        if array is not None:
            array[:] = beyond[column : column + size]
    if past.damping is not None:
        past.damping[:] = beyond[HELD]
