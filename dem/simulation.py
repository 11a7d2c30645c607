"""The run: from a scene to a trajectory."""

from __future__ import annotations

import hashlib
import math
import time as clock
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.errors import require
from contactlaws.sources import source_hash
from contactlaws.version import code_version
from dem import checkpoint as disk
from dem import requirements
from dem.ellipsoid_timestep import MOST_TURN
from dem.forces import LARGEST
from dem.laws import known_law
from dem.measure import Network, largest_overlap, stress_tensor
from dem.motion import Deformation
from dem.quasi_static import step_to, step_to_stress
from dem.record import COLUMNS, Beyond, Frame, deepest_beyond, in_scene_order, observe, pressures
from dem.reduction import faster_than_reckoned, reduced
from dem.scene import QuasiStatic, Scene, beginnings, law_bytes
from dem.timestep import TimeStep, collision_overlap, scene_time_step
from dem.trajectory import Trajectory, trajectory
from dem.working import Working, arrays_of, follow, with_arrays, working

FloatArray = npt.NDArray[np.float64]
Progress = Callable[[float, str], None]

#: particles are pushed around, so contacts get deeper than the affine motion alone makes them
NON_AFFINE = 2.0
#: share of the target stress over which the servo brings its strain rate down to 0
SERVO_BAND = 0.05
#: how many times longer than the cautious step an adaptive one may become
LONGER = 10.0
#: CPU seconds between two checkpoints
CHECKPOINT_EVERY = 5.0


class Plan(NamedTuple):
    """Everything decided before the first step."""

    durations: tuple[float, ...]  # s, of each stage
    drags: tuple[float, ...]  # 1/s
    kept: frozenset[int]  # the outputs whose positions are kept
    step: TimeStep
    notes: tuple[str, ...]
    warnings: tuple[str, ...]


class Log(NamedTuple):
    """What a run has written down so far."""

    rows: list[list[float]]  # see record.COLUMNS
    frames: list[Frame]
    beyond: list[Beyond]  # contacts outside their law's range, the deepest of each output
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
    began = clock.process_time()
    identity = {"scene": scene.content_hash, "code": code_version()}
    asked, (scene, replaced) = scene, reduced(scene, requirements.durations(scene))
    work = working(scene)
    require(requirements.overlap_problems(scene, largest_overlap(work)))
    plan = prepare(scene, work, replaced)
    for line in (*plan.notes, *(f"warning: {line}" for line in plan.warnings)):
        report(0.0, line)
    total = len(scene.programme) * scene.outputs
    log = Log([], [], [], {"steps": 0, "pair_lists": 1, "cpu_seconds": 0.0})
    if path is not None and path.exists():
        work, log = _restored(scene, work, *disk.load(path, identity))
        report(len(log.rows) / (total + 1), f"going on from {path}")
    before, stopped, saved = log.counts["cpu_seconds"], None, began
    if not log.rows:
        write_down(scene, work, plan, log, 0.0, 0)
    for number in range(len(log.rows), total + 1):
        stage, part = divmod(number - 1, scene.outputs)
        if part == 0:
            _begin(scene, work, stage)
        if scene.quasi_static is None:
            deepest = largest_overlap(work) if scene.adaptive_step else 0.0
            deformation = interval_of(scene, plan, work.begun[0], deepest, stage, part)
            work, lists = follow(work, deformation, 0, deformation.steps, scene.moving_walls)
            steps, dt, lost = deformation.steps, deformation.dt, None
        else:
            work, steps, lost = _rested(scene, work, plan, scene.quasi_static, stage, part)
            dt, lists = plan.durations[stage] / scene.outputs, 0
        stopped = reason_to_stop(work, number, dt)
        if stopped is not None:
            break
        log.counts["steps"] += steps
        log.counts["pair_lists"] += lists
        log.counts["cpu_seconds"] = before + clock.process_time() - began
        if lost is not None:
            stopped = f"no rest was found for output {number}: {lost}; its row and frame are those of the state that was reached"
            plan = plan._replace(kept=plan.kept | {number})
        write_down(scene, work, plan, log, dt, number)
        if stopped is not None:
            break
        if path is not None and (clock.process_time() - saved > CHECKPOINT_EVERY or number == total):
            disk.save(path, identity, *_saved(work, log))
            saved = clock.process_time()
        report(number / total, progress_line(log.rows[-1]))
    warnings = (*plan.warnings, *faster_than_reckoned(asked, scene, log.rows))
    return trajectory(
        scene, log.rows, log.frames, log.beyond, statistics_of(scene, plan, log, identity, work), plan.notes, warnings, stopped
    )


def reason_to_stop(work: Working, number: int, dt: float) -> str | None:
    """Why a run cannot go on, None if it can."""
    if not (np.isfinite(work.bodies.position).all() and np.isfinite(work.bodies.velocity).all()):
        return f"the motion diverged before output {number}: take a smaller time_step_fraction (the step is {dt:.3g} s)"
    for axis, side, place, _ in work.walls.tolist():
        if bool(np.any(side * (work.bodies.position[:, int(axis)] - place) <= 0.0)):
            return f"before output {number} a particle went through a wall: load less, or slower, or take a smaller time_step_fraction"
    deepest = float(work.tally[:, LARGEST].max())
    if deepest >= 1.0:
        return f"before output {number} a particle was pressed by {deepest:.3g} of its radius, where the body ends: load less, or slower"
    return None


def counts_anew(scene: Scene, stage: int) -> bool:
    """Whether the stretch of a stage counts from the box in which it begins."""
    return stage > 0 and scene.programme[stage - 1].follows_stress


def _begin(scene: Scene, work: Working, stage: int) -> None:
    """Note with which stress a stage begins, and from which box the stretch counts."""
    if counts_anew(scene, stage):
        work.begun[0] = work.cell
    work.begun[1] = stress_tensor(work, with_motion=False)


def _rested(scene: Scene, work: Working, plan: Plan, settings: QuasiStatic, stage: int, part: int) -> tuple[Working, int, str | None]:
    """Go from one output to the next by states of rest; also the iterations it took, and what went wrong."""
    start, end = (_cell(scene, work.begun[0], stage, (part + k) / scene.outputs) for k in (0, 1))
    asked, duration, iterations = scene.programme[stage].stress, plan.durations[stage] / scene.outputs, 0
    change = max(float(np.abs(np.linalg.solve(start, end) - np.eye(3)).max()), 0.0)
    load, first = requirements.LOAD_SHARE * requirements.typical_force(scene), np.diag(work.begun[1])

    def critical(overlap: float) -> float:
        return scene_time_step(scene, overlap, 1.0).critical if scene.particles.size else 1.0

    parts = max(1, math.ceil(change / settings.strain_step * (1.0 - 1e-9)))
    for k in range(parts):
        cell = end if k + 1 == parts else start + (end - start) * ((k + 1) / parts)
        step = (duration / parts, scene.affine, critical, load, settings)
        if scene.programme[stage].follows_stress:
            share = (part + (k + 1) / parts) / scene.outputs
            target = tuple(None if stress is None else begun + (stress - begun) * share for stress, begun in zip(asked, first, strict=True))
            work, rest = step_to_stress(work, cell, target, *step)
        else:
            work, rest = step_to(work, cell, *step)
        iterations += rest.iterations
        if not rest.found:
            return work, iterations, rest.report
    return work, iterations, None


def _cell(scene: Scene, begun: FloatArray, stage: int, share: float) -> FloatArray:
    """Edge vectors in m when `share` of a stage is done, as the programme wants them; stretch counts from `begun`."""
    ends, box = (beginnings(scene.programme)[stage], scene.programme[stage]), scene.box.with_cell(begun)
    before, after = (box.stretched(end.stretch, end.shear).cell for end in ends)
    return after if share == 1.0 else before + (after - before) * share


def interval_of(scene: Scene, plan: Plan, begun: FloatArray, overlap: float, stage: int, part: int) -> Deformation:
    """The steps from one output to the next. Stretch counts from the edge vectors `begun` (m); `overlap` (m) is the deepest there is."""
    duration = plan.durations[stage] / scene.outputs
    most = plan.step.dt
    if scene.adaptive_step and scene.particles.size:
        deepest = overlap + NON_AFFINE * 2.0 * float(scene.particles.radii.max()) * _squeeze(scene, stage) / scene.outputs
        most = min(scene_time_step(scene, deepest, scene.time_step_fraction).dt, LONGER * most)
    steps = max(1, math.ceil(duration / most))
    target, gain, fastest = np.zeros(3), np.zeros(3), 0.0
    wanted = scene.programme[stage].stress
    if scene.programme[stage].follows_stress:
        fastest = scene.inertial_number / requirements.inertial_time(scene)
        scale = max(stress or 0.0 for stress in wanted) or requirements.reference_pressure(scene, requirements.SERVO_STRAIN)
        target = np.array([stress or 0.0 for stress in wanted])
        gain = np.array([0.0 if stress is None else fastest / (SERVO_BAND * scale) for stress in wanted])
    start, end = (_cell(scene, begun, stage, (part + k) / scene.outputs) for k in (0, 1))
    return Deformation(start, end, steps, duration / steps, plan.drags[stage], scene.affine, target, gain, fastest)


def _squeeze(scene: Scene, stage: int) -> float:
    """Largest strain or shear that a stage adds."""
    return requirements.changes(scene)[stage]


def prepare(scene: Scene, work: Working, replaced: tuple[str, ...] = ()) -> Plan:
    """Time step, durations and outputs; and the lines that say what was decided."""
    durations = requirements.durations(scene)
    step = _time_step(scene, work, durations)
    within = [round(k * scene.outputs / scene.frames) for k in range(1, scene.frames + 1)]
    kept = {0} | {stage * scene.outputs + k for stage in range(len(durations)) for k in within}
    notes = (*replaced, *requirements.left_out(scene, work), *requirements.motion_notes(scene, durations))
    if scene.quasi_static is None:
        notes = (*notes, step.note + ("; it follows the deepest contact from output to output" if scene.adaptive_step else ""))
    warnings = (*requirements.shape_warnings(scene), *requirements.rate_warnings(scene, durations))
    return Plan(durations, requirements.drags(scene), frozenset(kept), step, notes, warnings)


def _time_step(scene: Scene, work: Working, durations: tuple[float, ...]) -> TimeStep:
    bodies = scene.particles
    if bodies.size == 0:
        return TimeStep(min(durations) / scene.outputs, math.inf, 0.0, 0.0, 0, math.inf)
    widest, speed = float(bodies.radii.max()), 2.0 * float(np.sqrt((bodies.velocity**2).sum(axis=1)).max())
    fastest = 0.0
    if bodies.axes is not None and bodies.spin is not None:  # surfaces that turn towards each other
        fastest = float(np.sqrt((bodies.spin**2).sum(axis=1)).max())
        speed += 2.0 * fastest * float(bodies.axes.max())
    squeezed = 2.0 * widest * min(requirements.largest_strain(scene), 1.0)
    if any(stage.follows_stress for stage in scene.programme):
        squeezed += 2.0 * widest * requirements.SERVO_STRAIN
    overlap = largest_overlap(work) + NON_AFFINE * squeezed
    overlap += max(collision_overlap(contact.normal, bodies._replace(mass=scene.masses), speed) for contact in scene.contacts)
    step = scene_time_step(scene, overlap, scene.time_step_fraction)
    return step._replace(dt=min(step.dt, MOST_TURN / fastest)) if fastest > 0.0 else step


def write_down(scene: Scene, work: Working, plan: Plan, log: Log, dt: float, number: int) -> None:
    """Add the row of output `number`, reached with time steps of `dt` (s), and its frame if that is kept, to the log."""
    values, found = observe(scene, work, scene.box, dt)
    stage, part = divmod(max(number - 1, 0), scene.outputs)
    time = sum(plan.durations[:stage]) + (plan.durations[stage] * ((part + 1) / scene.outputs) if number else 0.0)
    values |= {"time": time, "stage": stage, "steps": log.counts["steps"]}
    log.rows.append([float(values[name]) for name in COLUMNS])
    beyond = deepest_beyond(scene, work, found, number)
    if beyond is not None:
        log.beyond.append(beyond)
    if number in plan.kept:
        contacts, pressure = pressures(work, found)
        position, velocity, contacts, pressure = (
            in_scene_order(work, rows) for rows in (work.bodies.position, work.bodies.velocity, contacts, pressure)
        )
        second = np.where(found.second >= 0, work.order[np.maximum(found.second, 0)], found.second).astype(np.int64)
        named = found._replace(first=work.order[found.first].astype(np.int64), second=second)
        bodies = scene.particles
        frame = Frame(number, time, work.box, bodies.id, bodies.radii, position, velocity, contacts, pressure, named)
        if work.shapes is not None:
            frame = frame._replace(axes=bodies.axes, orientation=in_scene_order(work, work.shapes.orientation))
        log.frames.append(frame)


def _saved(work: Working, log: Log) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    numbers, arrays = saved_log(log)
    return numbers, arrays | {f"work_{name}": value for name, value in arrays_of(work).items()}


def saved_log(log: Log) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """A log as numbers and arrays."""
    arrays = {"rows": np.array(log.rows)}
    arrays["frame_outputs"] = np.array([frame.output for frame in log.frames])
    arrays["frame_cells"] = np.array([frame.box.cell for frame in log.frames])
    for number, frame in enumerate(log.frames):
        arrays |= {f"network{number}_{name}": value for name, value in frame.network._asdict().items() if value is not None}
        if frame.orientation is not None:
            arrays[f"orientation{number}"] = frame.orientation
    for name in ("position", "velocity", "contacts", "pressure"):
        arrays[f"frame_{name}"] = np.array([getattr(frame, name) for frame in log.frames])
    return {"counts": dict(log.counts), "beyond": [list(beyond) for beyond in log.beyond]}, arrays


def _restored(scene: Scene, work: Working, numbers: dict[str, Any], arrays: dict[str, np.ndarray]) -> tuple[Working, Log]:
    work = with_arrays(work, {name.removeprefix("work_"): value for name, value in arrays.items() if name.startswith("work_")})
    return work, restored_log(scene, numbers, arrays)


def restored_log(scene: Scene, numbers: dict[str, Any], arrays: dict[str, np.ndarray]) -> Log:
    """What `saved_log` made of it."""
    rows = arrays["rows"].tolist()
    own = zip(*(arrays[f"frame_{name}"] for name in ("outputs", "cells", "position", "velocity", "contacts", "pressure")), strict=True)
    same = (scene.particles.id, scene.particles.radii)
    named: list[dict[str, Any]] = [
        {name: arrays.get(f"network{k}_{name}") for name in Network._fields} for k in range(len(arrays["frame_outputs"]))
    ]
    frames: list[Frame] = []
    for (output, cell, position, velocity, contacts, pressure), contact in zip(own, named, strict=True):
        row, turns = int(output), arrays.get(f"orientation{len(frames)}")
        frame = Frame(row, rows[row][0], scene.box.with_cell(cell), *same, position, velocity, contacts, pressure, Network(**contact))
        frames.append(frame if turns is None else frame._replace(axes=scene.particles.axes, orientation=turns))
    beyond = [Beyond(int(a), int(b), c, d, tuple(e)) for a, b, c, d, e in numbers["beyond"]]
    return Log(rows, frames, beyond, numbers["counts"])


def progress_line(row: list[float]) -> str:
    """A row of the table in a few words."""
    named = dict(zip(COLUMNS, row, strict=True))
    pressure = sum(named[f"stress {a}{a}"] for a in "xyz") / 3.0
    return f"t = {named['time']:.3g} s, pressure {pressure:.3g} Pa, {named['coordination']:.2f} contacts per particle"


def law_hash(law: object) -> str:
    """Twelve hexadecimal digits of a law's parameters and of the sources that all laws of this project come from."""
    return hashlib.sha256(law_bytes(law) + source_hash("contactlaws").encode()).hexdigest()[:12]


def statistics_of(scene: Scene, plan: Plan, log: Log, identity: dict[str, str], work: Working) -> dict[str, Any]:
    """What a run cost, and which law, scene and code it was."""
    law, seconds = scene.contact.normal, max(log.counts["cpu_seconds"], 1e-9)
    steps = [row[COLUMNS.index("time step")] for row in log.rows[1:]]
    mine = [steps[k : k + scene.outputs] for k in range(0, len(steps), scene.outputs)]
    return {
        **log.counts,
        "particle_steps_per_cpu_second": log.counts["steps"] * scene.particles.size / seconds,
        "dt": [] if scene.quasi_static else [max(stage) for stage in mine],
        "dt_over_critical": [] if scene.quasi_static else [max(stage) / plan.step.critical for stage in mine],
        "itasca_dt": plan.step.itasca,
        "routine": "quasi-static" if scene.quasi_static else "dynamic",
        "bytes_per_particle": work.bytes_used / max(scene.particles.size, 1),
        "threads": scene.threads,
        "stiffness_bound": plan.step.stiffness,
        "overlap_reckoned_with": plan.step.overlap,
        "law": known_law(law).name,
        "law_source": known_law(law).source,
        "law_parameters": {name: np.asarray(value).tolist() for name, value in law._asdict().items()},  # type: ignore[attr-defined]
        "law_hash": law_hash(law),
        "scene_hash": identity["scene"],
        "code_version": identity["code"],
    }
