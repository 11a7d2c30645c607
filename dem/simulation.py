"""The run: from a scene to a trajectory."""

from __future__ import annotations

import hashlib
import math
import time as clock
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contactlaws import dispatch
from contactlaws.errors import require
from contactlaws.sources import source_hash
from contactlaws.version import code_version
from dem import checkpoint as disk
from dem import requirements
from dem.box import Box
from dem.motion import Deformation, lengths_at
from dem.record import COLUMNS, Frame, in_scene_order, observe
from dem.scene import Scene, law_bytes
from dem.timestep import TimeStep, collision_overlap, time_step
from dem.trajectory import Trajectory, trajectory
from dem.working import Working, arrays_of, follow, largest_overlap, with_arrays, working

Progress = Callable[[float, str], None]

#: particles are pushed around, so contacts get deeper than the affine motion alone makes them
NON_AFFINE = 2.0
#: CPU seconds between two checkpoints
CHECKPOINT_EVERY = 5.0


class Plan(NamedTuple):
    """Everything decided before the first step."""

    deformations: tuple[Deformation, ...]
    outputs: tuple[tuple[int, int], ...]  # stage and step of each output after the start
    kept: frozenset[int]  # the outputs whose positions are kept
    step: TimeStep
    notes: tuple[str, ...]
    warnings: tuple[str, ...]


class Log(NamedTuple):
    """What a run has written down so far."""

    rows: list[list[float]]  # see record.COLUMNS
    frames: list[Frame]
    counts: dict[str, float]  # steps, pair lists made, CPU seconds


def run(scene: Scene, progress: Progress | None = None, checkpoint: str | Path | None = None) -> Trajectory:
    """Simulate `scene`; `progress` is called with the fraction done and a line of text.

    With `checkpoint` (an .npz file) the state is saved every few seconds, and a run that finds the file goes on from it with the same bits
    as if it had never stopped; a finished one is returned at once. Raises `InputError`, before computing, for anything that cannot be
    simulated. A run that diverges is returned up to there, with the reason in `stopped`.
    """
    path = None if checkpoint is None else Path(checkpoint)
    require([*requirements.problems_with(scene), *(() if path is None else disk.writable_problems(path))])
    report = progress or (lambda fraction, text: None)
    law, began = scene.contact.normal, clock.process_time()
    identity = {"scene": scene.content_hash, "code": code_version()}
    work = working(law, scene.particles, scene.box, 2.0 * float(scene.particles.radii.max(initial=0.0)) * scene.skin)
    require(requirements.overlap_problems(scene, largest_overlap(work)))
    plan = prepare(scene, work)
    for line in (*plan.notes, *(f"warning: {line}" for line in plan.warnings)):
        report(0.0, line)
    log = Log([], [], {"steps": 0, "pair_lists": 1, "cpu_seconds": 0.0})
    if path is not None and path.exists():
        work, log = _restored(scene, work, *disk.load(path, identity))
        report(len(log.rows) / (len(plan.outputs) + 1), f"going on from {path}")
    before, stopped, saved = log.counts["cpu_seconds"], None, began
    if not log.rows:
        _write_down(scene, work, plan, log, 0, 0)
    for number in range(len(log.rows), len(plan.outputs) + 1):
        stage, reached = plan.outputs[number - 1]
        since = reached - plan.outputs[0][1] if number == 1 or plan.outputs[number - 2][0] != stage else plan.outputs[number - 2][1]
        work, lists = follow(law, work, plan.deformations[stage], since, reached - since)
        if not (np.isfinite(work.position).all() and np.isfinite(work.velocity).all()):
            stopped = f"the motion diverged before output {number}: take a smaller time_step_fraction (the step is {plan.step.dt:.3g} s)"
            break
        log.counts["steps"] += reached - since
        log.counts["pair_lists"] += lists
        log.counts["cpu_seconds"] = before + clock.process_time() - began
        _write_down(scene, work, plan, log, stage, reached)
        if path is not None and (clock.process_time() - saved > CHECKPOINT_EVERY or number == len(plan.outputs)):
            disk.save(path, identity, *_saved(work, log))
            saved = clock.process_time()
        report(number / len(plan.outputs), _line(log.rows[-1]))
    return trajectory(scene, log.rows, log.frames, _statistics(scene, plan, log, identity), plan.notes, plan.warnings, stopped)


def prepare(scene: Scene, work: Working) -> Plan:
    """Time step, steps per stage and outputs; and the lines that say what was decided."""
    durations = requirements.durations(scene)
    step = _time_step(scene, work, durations)
    edges = np.array(scene.box.lengths)
    ends = [edges * np.array(stage.stretch) for stage in scene.programme]
    every = [max(1, math.ceil(duration / (step.dt * scene.outputs))) for duration in durations]
    deformations = tuple(
        Deformation(before, after, n * scene.outputs, duration / (n * scene.outputs), drag)
        for before, after, n, duration, drag in zip([edges, *ends], ends, every, durations, requirements.drags(scene), strict=False)
    )
    outputs = tuple((stage, n * k) for stage, n in enumerate(every) for k in range(1, scene.outputs + 1))
    within = [round(k * scene.outputs / scene.frames) for k in range(1, scene.frames + 1)]
    kept = {0} | {stage * scene.outputs + k for stage in range(len(every)) for k in within}
    notes = (*requirements.left_out(scene), *requirements.motion_notes(scene, durations), step.note)
    return Plan(deformations, outputs, frozenset(kept), step, notes, requirements.rate_warnings(scene, durations))


def _time_step(scene: Scene, work: Working, durations: tuple[float, ...]) -> TimeStep:
    bodies, law = scene.particles, scene.contact.normal
    if bodies.size == 0:
        return TimeStep(min(durations) / scene.outputs, math.inf, 0.0, 0.0, 0)
    squeezed = 2.0 * work.widest * (1.0 - min(1.0, *(stretch for stage in scene.programme for stretch in stage.stretch)))
    speed = 2.0 * float(np.sqrt((bodies.velocity**2).sum(axis=1)).max())
    overlap = largest_overlap(work) + NON_AFFINE * squeezed + collision_overlap(law, bodies, speed)
    return time_step(law, bodies, overlap or 1e-6 * work.widest, scene.time_step_fraction)


def _write_down(scene: Scene, work: Working, plan: Plan, log: Log, stage: int, reached: int) -> None:
    deformation = plan.deformations[stage]
    x, y, z = (float(length) for length in lengths_at(deformation, reached))
    box = Box((x, y, z), scene.box.periodic)
    limit = math.inf if scene.contact.fitted_overlap is None else scene.contact.fitted_overlap
    values, contacts, pressure = observe(scene.contact.normal, work, box, scene.box, limit)
    time = sum(d.steps * d.dt for d in plan.deformations[:stage]) + reached * deformation.dt
    values |= {"time": time, "stage": stage}
    log.rows.append([float(values[name]) for name in COLUMNS])
    if len(log.rows) - 1 in plan.kept:
        own = [in_scene_order(work, rows) for rows in (work.position, work.velocity, contacts, pressure)]
        log.frames.append(Frame(len(log.rows) - 1, time, box, scene.particles.id, scene.particles.radii, *own))


def _saved(work: Working, log: Log) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    arrays = {f"work_{name}": value for name, value in arrays_of(work).items()}
    arrays["rows"] = np.array(log.rows)
    arrays["frame_outputs"] = np.array([frame.output for frame in log.frames])
    arrays["frame_lengths"] = np.array([frame.box.lengths for frame in log.frames])
    for name in ("position", "velocity", "contacts", "pressure"):
        arrays[f"frame_{name}"] = np.array([getattr(frame, name) for frame in log.frames])
    return dict(log.counts), arrays


def _restored(scene: Scene, work: Working, counts: dict[str, Any], arrays: dict[str, np.ndarray]) -> tuple[Working, Log]:
    work = with_arrays(work, {name.removeprefix("work_"): value for name, value in arrays.items() if name.startswith("work_")})
    rows = arrays["rows"].tolist()
    own = zip(*(arrays[f"frame_{name}"] for name in ("outputs", "lengths", "position", "velocity", "contacts", "pressure")), strict=True)
    same = (scene.particles.id, scene.particles.radii)
    frames = [
        Frame(int(output), rows[int(output)][0], Box(tuple(edges.tolist()), scene.box.periodic), *same, *rest)
        for output, edges, *rest in own
    ]
    return work, Log(rows, frames, counts)


def _line(row: list[float]) -> str:
    named = dict(zip(COLUMNS, row, strict=True))
    pressure = sum(named[f"stress {a}{a}"] for a in "xyz") / 3.0
    return f"t = {named['time']:.3g} s, pressure {pressure:.3g} Pa, {named['coordination']:.2f} contacts per particle"


def law_hash(law: object) -> str:
    """Twelve hexadecimal digits of a law's parameters and of the sources that all laws of this project come from."""
    return hashlib.sha256(law_bytes(law) + source_hash("contactlaws").encode()).hexdigest()[:12]


def _statistics(scene: Scene, plan: Plan, log: Log, identity: dict[str, str]) -> dict[str, Any]:
    law, seconds = scene.contact.normal, max(log.counts["cpu_seconds"], 1e-9)
    return {
        **log.counts,
        "particle_steps_per_cpu_second": log.counts["steps"] * scene.particles.size / seconds,
        "dt": [deformation.dt for deformation in plan.deformations],
        "dt_over_critical": [deformation.dt / plan.step.critical for deformation in plan.deformations],
        "stiffness_bound": plan.step.stiffness,
        "overlap_reckoned_with": plan.step.overlap,
        "law": dispatch.law_of(law).name,
        "law_source": dispatch.law_of(law).source,
        "law_parameters": {name: np.asarray(value).tolist() for name, value in law._asdict().items()},  # type: ignore[attr-defined]
        "law_hash": law_hash(law),
        "scene_hash": identity["scene"],
        "code_version": identity["code"],
    }
