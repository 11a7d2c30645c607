"""Random close packings."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cases.batch.task import Task
from cases.batch.work.place import Made, Outcome, Report, place, relative
from contactlaws.files import write_atomically
from dem.packing import random_close_packing


def make(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """A random close packing: positions, radius and box in an .npz file."""

    report(0.0, "pushing spheres apart")
    packing = random_close_packing(**task.values)
    file = place(folder, task, ".npz")

    def write(path: Path) -> None:
        with path.open("wb") as out:
            np.savez(
                out,
                position=packing.position,
                radius=packing.radius,
                lengths=packing.box.lengths,
                packing_fraction=packing.packing_fraction,
            )

    write_atomically(file, write)
    summary = {"packing_fraction": packing.packing_fraction, "worst_overlap": packing.worst_overlap, "moves": int(packing.moves)}
    return {"packing": relative(file, folder)}, summary, None
