"""Packings compressed and released on a law."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contactlaws  # noqa: F401  (all laws: any may stand in the file)
import dem
from cases.batch.store import hash_of
from cases.batch.task import Task
from cases.batch.work.place import Made, Outcome, Report, empty_folder, law_file, place, relative
from cases.report import history
from contactlaws import fitted
from contactlaws.version import code_version
from dem import output
from dem.box import Box
from dem.packing import Packing


def make(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """A packing compressed and released on a law: history table, LAMMPS dump, .vtu frames."""

    fit, values = fitted.load(law_file(folder, task, made)), task.values
    contact = dem.Contact(normal=fit.law, fitted_overlap=fit.max_overlap / fit.law.radius)
    packing = next(_packing(folder / made[need].files["packing"]) for need in task.needs if need.startswith("packings."))
    programme = dem.uniaxial_compression(values["strain"], strain_rate=values["strain_rate"], release=values["release"])
    scene = dem.packed_scene(packing, values["density"], contact, programme)
    # a run can only be continued by the code that began it, so the code is in the checkpoint's name
    checkpoint = place(folder, task, f"-{hash_of(code_version())}.checkpoint.npz")
    trajectory = dem.run(scene, progress=report, checkpoint=checkpoint)
    table, dump = place(folder, task, ".parquet"), place(folder, task, ".dump")
    frames = empty_folder(folder / "frames" / f"{task.name}-{task.key}")
    history.write(history.columns(trajectory), table)
    output.write_dump(trajectory, dump)
    output.write_vtu(trajectory, frames)
    checkpoint.unlink(missing_ok=True)
    files = {"history": relative(table, folder), "dump": relative(dump, folder), "frames": relative(frames, folder)}
    summary = {"notes": list(trajectory.notes), "warnings": list(trajectory.warnings), "statistics": dict(trajectory.statistics)}
    return files, summary, trajectory.stopped


def _packing(path: Path) -> Any:

    with np.load(path, allow_pickle=False) as file:
        lengths = tuple(float(value) for value in file["lengths"])
        return Packing(file["position"], float(file["radius"]), Box(lengths), float(file["packing_fraction"]), 0.0, 0, 0.0)  # type: ignore[arg-type]
