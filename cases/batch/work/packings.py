"""Random close packings, of spheres and of ellipsoids."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cases.batch.task import Task
from cases.batch.work.place import Made, Outcome, Report, place, relative
from contactlaws.files import write_atomically
from dem.ellipsoid_packing import half_axes, random_ellipsoids
from dem.packing import random_close_packing


def make(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """A random close packing: positions and box in an .npz file, with the radius, or half axes and orientations."""

    arrays, summary = (_ellipsoids if "shape" in task.values else _spheres)(task.values, report)
    file = place(folder, task, ".npz")

    def write(path: Path) -> None:
        with path.open("wb") as out:
            np.savez(out, **arrays)

    write_atomically(file, write)
    return {"packing": relative(file, folder)}, summary, None


def _spheres(values: Mapping[str, Any], report: Report) -> tuple[dict[str, Any], dict[str, Any]]:
    report(0.0, "pushing spheres apart")
    packing = random_close_packing(**values)
    arrays = {"position": packing.position, "radius": packing.radius, "lengths": packing.box.lengths}
    summary = {"packing_fraction": packing.packing_fraction, "worst_overlap": packing.worst_overlap, "moves": int(packing.moves)}
    return arrays | {"packing_fraction": packing.packing_fraction}, summary


def _ellipsoids(values: Mapping[str, Any], report: Report) -> tuple[dict[str, Any], dict[str, Any]]:
    report(0.0, "pressing ellipsoids together")
    packing = random_ellipsoids(values["count"], values["packing_fraction"], half_axes(values["shape"], values["radius"]), values["seed"])
    arrays = {"position": packing.position, "axes": packing.axes, "orientation": packing.orientation, "lengths": packing.box.lengths}
    summary = {"packing_fraction": packing.packing_fraction, "worst_overlap": packing.worst_overlap, "steps": packing.steps}
    return arrays | {"packing_fraction": packing.packing_fraction}, summary
