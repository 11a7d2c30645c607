"""A scene from start to end with LAMMPS as its engine: the same programme, the same table and frames as `dem.run`.

Between two outputs LAMMPS is on its own. At an output all ranks gather the spheres and what their contacts remember, and the state is read
off as if our own loop had come there, by the same functions.
"""

from __future__ import annotations

import dataclasses
import time as clock

import numpy as np
import numpy.typing as npt

from contactlaws.errors import require
from contactlaws.version import code_version
from dem import forces, lammps_forces, requirements
from dem.lammps_engine import Engine, Snapshot, problems_with
from dem.measure import largest_overlap
from dem.reduction import reduced
from dem.scene import Scene
from dem.simulation import Log, Progress, _end_of, _interval, _line, _statistics, _write_down, prepare
from dem.trajectory import Trajectory, trajectory
from dem.working import Working, renew_forces, working

#: steps between two outputs, below which it shows that the box stands still in the first of them: 2.5e-3 of the stress was seen with six
FEWEST_STEPS = 50


def run(scene: Scene, progress: Progress | None = None) -> Trajectory:
    """Simulate `scene`; on several ranks each of them calls this, and each gets the whole trajectory.

    Raises `InputError`, before computing, for anything that cannot be simulated by LAMMPS or at all. The energy given by the box and that
    taken by the drag are split at outputs to half a step.
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
    _write_down(scene, work, plan, log, 0.0, 0)
    engine, total, fewest = Engine.of_scene(scene), len(scene.programme) * scene.outputs, FEWEST_STEPS
    try:
        for number in range(1, total + 1):
            interval = _interval(scene, work, plan, *divmod(number - 1, scene.outputs))
            engine.follow(interval)
            work = state(scene, interval.end, engine.snapshot())._replace(begun=work.begun)
            stopped = _end_of(work, number, interval.dt)
            if stopped is not None:
                break
            log.counts["steps"] += interval.steps
            fewest = min(fewest, interval.steps)
            log.counts["cpu_seconds"] = clock.process_time() - began
            _write_down(scene, work, plan, log, interval.dt, number)
            report(number / total, _line(log.rows[-1]))
    finally:
        engine.close()
    statistics = _statistics(scene, plan, log, identity, work) | {"engine": "lammps"}
    warnings = plan.warnings
    if fewest < FEWEST_STEPS:
        rests = f"{fewest} steps between two outputs are few: LAMMPS's box rests in the first"
        warnings = (*warnings, f"{rests}; ask for fewer outputs, or load more slowly")
    return trajectory(scene, log.rows, log.frames, log.beyond, statistics, plan.notes, warnings, stopped)


def state(scene: Scene, cell: npt.NDArray[np.float64], snapshot: Snapshot) -> Working:
    """Our own record of a state of LAMMPS's, in the box of edge vectors `cell` (m)."""
    own = scene.particles.id - 1
    particles = scene.particles._replace(position=snapshot.position[own], velocity=snapshot.velocity[own])
    work = working(dataclasses.replace(scene, particles=particles, box=scene.box.with_cell(cell)))
    group, numbers = work.groups[0], scene.particles.id[work.order]
    if group.memory is not None:
        first, second = (numbers[rows] for rows in (group.rows.first, group.rows.partner))
        slots = snapshot.partner[first - 1] == second[:, None]
        found, memory = slots.any(axis=1), snapshot.memory[first - 1, slots.argmax(axis=1), :-1]
        group.memory[:] = np.where(found[:, None], memory, 0.0)
        renew_forces(work)
    sums = snapshot.sums
    work.tally[:] = 0.0
    work.tally[0, forces.LARGEST] = sums[:, lammps_forces.LARGEST].max(initial=0.0)
    for ours, theirs in ((forces.LOST, lammps_forces.LOST), (forces.DRAGGED, lammps_forces.DRAGGED), (forces.WORK, lammps_forces.WORK)):
        work.tally[0, ours] = sums[:, theirs].sum()
    return work
