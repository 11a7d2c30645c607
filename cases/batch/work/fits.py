"""Laws fitted to curves."""

from __future__ import annotations

from pathlib import Path

import calibration
from calibration import recipes, table
from cases.batch.task import Task
from cases.batch.work.place import Made, Outcome, Report, place, relative
from contactlaws import fitted
from contactlaws.curve_files import read_curve
from contactlaws.material import Material


def make(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """A law fitted to curves, and its row for the table."""

    material = None if task.values["material"] is None else Material(**task.values["material"])
    found = [read_curve(folder / made[need].files["curve"]) for need in task.needs]
    in_time = task.values["law"] in recipes.IN_TIME
    found += [read_curve(path, radius=task.values["radius"], material=material, in_time=in_time) for path in task.given]
    fit = calibration.fit(found, law=task.values["law"])
    law, row = place(folder, task, ".json"), place(folder, task, ".csv")
    fitted.save(fit.fitted, law)
    table.write([fit], row)
    summary = {
        "law": fit.fitted.name,
        "curves": [curve.content_hash for curve in found],
        "free": list(fit.free),
        "standard_errors": dict(fit.standard_errors),
        "correlation": fit.correlation.tolist(),
        "condition_number": fit.condition_number,
        "misfit": fit.misfit,
        "residuals": fit.residuals._asdict(),
        "warnings": list(fit.warnings),
    }
    return {"law": relative(law, folder), "row": relative(row, folder)}, summary, None
