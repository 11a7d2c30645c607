"""Laws drawn from the errors of a fit."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import contactlaws  # noqa: F401  (all laws: any may stand in the file)
from calibration.law_draws import draw
from cases.batch.task import Task
from cases.batch.work.place import Made, Outcome, Report, place, relative
from contactlaws import fitted


def make(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """One law, by the standard errors and the correlation that the fit has stated."""
    fit = made[task.needs[0]]
    free = fit.summary["free"]
    correlation = np.array(fit.summary["correlation"], dtype=np.float64)
    drawn = draw(fitted.load(folder / fit.files["law"]), free, correlation, task.values["seed"])
    file = place(folder, task, ".json")
    fitted.save(drawn, file)
    parameters = {name: getattr(drawn.law, name) for name in free}
    return {"law": relative(file, folder)}, {"parameters": parameters, **drawn.origin["drawn"]}, None
