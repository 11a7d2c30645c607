"""A scene from start to end with LAMMPS as its engine: the same programme, the same table and frames as `dem.run`.

Between two outputs LAMMPS is on its own. At an output all ranks gather the spheres and what their contacts remember, and the first reads
off the state as if our own loop had come there, by the same functions.
"""

from __future__ import annotations

import dataclasses
import time as clock

import numpy as np
import numpy.typing as npt

from contactlaws import dispatch
from contactlaws.errors import require
from contactlaws.version import code_version
from dem import forces, lammps_forces, requirements
from dem.lammps_engine import Engine, Snapshot
from dem.lammps_forces import HELD, REMEMBERED, SLIP, TURNED
from dem.lammps_scope import problems_with
from dem.measure import largest_overlap
from dem.reduction import reduced
from dem.scene import Scene
from dem.simulation import Log, Progress, interval_of, prepare, progress_line, reason_to_stop, statistics_of, write_down
from dem.trajectory import Trajectory, trajectory
from dem.working import Working, renew_forces, working


def run(scene: Scene, progress: Progress | None = None) -> Trajectory | None:
    """Simulate `scene`; on several ranks each of them calls this, and the first gets the trajectory, the others None.

    Raises `InputError`, before computing, for anything that cannot be simulated by LAMMPS or at all.
    """
    require([*requirements.problems_with(scene), *problems_with(scene)])
    report, began = progress or (lambda fraction, text: None), clock.process_time()
    scene, replaced = reduced(scene, requirements.durations(scene))
    work = working(scene)
    require(requirements.overlap_problems(scene, largest_overlap(work)))
    plan = prepare(scene, work, replaced)
    for line in (*plan.notes, *(f"warning: {line}" for line in plan.warnings)):
        report(0.0, line)
    log, stopped = Log([], [], [], {"steps": 0, "pair_lists": 0, "cpu_seconds": 0.0}), None
    identity = {"scene": scene.content_hash, "code": code_version()}
    write_down(scene, work, plan, log, 0.0, 0)
    engine, total = Engine.of_scene(scene), len(scene.programme) * scene.outputs
    first = engine.rank == 0
    try:
        for number in range(1, total + 1):
            interval = interval_of(scene, work, plan, *divmod(number - 1, scene.outputs))
            engine.follow(interval)
            snapshot = engine.snapshot()
            if first or scene.adaptive_step:
                work = state(scene, interval.end, snapshot)._replace(begun=work.begun)
            else:
                work = _outline(work, snapshot)
            stopped = reason_to_stop(work, number, interval.dt)
            if stopped is not None:
                break
            log.counts["steps"] += interval.steps
            log.counts["cpu_seconds"] = clock.process_time() - began
            if first:
                write_down(scene, work, plan, log, interval.dt, number)
                report(number / total, progress_line(log.rows[-1]))
    finally:
        engine.close()
    if not first:
        return None
    statistics = statistics_of(scene, plan, log, identity, work) | {"engine": "lammps"}
    return trajectory(scene, log.rows, log.frames, log.beyond, statistics, plan.notes, plan.warnings, stopped)


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


def _outline(work: Working, snapshot: Snapshot) -> Working:
    """As much of `state` as tells whether a run can go on."""
    work.tally[0, forces.LARGEST] = snapshot.sums[:, lammps_forces.LARGEST].max(initial=0.0)
    return work._replace(bodies=work.bodies._replace(position=snapshot.position, velocity=snapshot.velocity))


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
