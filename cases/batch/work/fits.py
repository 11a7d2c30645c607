"""Laws fitted to curves."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import calibration
from calibration import Fit, law_choice, recipes, table
from cases.batch.task import Task
from cases.batch.work.place import Made, Outcome, Report, place, relative
from contactlaws import fitted
from contactlaws.curve import Curve
from contactlaws.curve_files import read_curve
from contactlaws.material import Material


def make(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """A law fitted to curves, and its row for the table."""

    if "tolerance" in task.values:
        return _cheapest(task, folder, made, report)
    material = None if task.values["material"] is None else Material(**task.values["material"])
    found = [read_curve(folder / made[need].files["curve"]) for need in task.needs]
    in_time = task.values["law"] in recipes.IN_TIME
    found += [read_curve(path, radius=task.values["radius"], material=material, in_time=in_time) for path in task.given]
    return _written(task, folder, calibration.fit(found, law=task.values["law"]), found)


def _cheapest(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """The cheapest law whose error on the curves, as deep as they are asked for, is small enough."""
    found = [read_curve(folder / made[need].files["curve"]) for need in task.needs] + [read_curve(path) for path in task.given]
    within = [curve.up_to(task.values["reach"]) for curve in found]
    choice = law_choice.fit_within(within, task.values["tolerance"], progress=report, also=("unloading_force",))
    files, summary, failed = _written(task, folder, choice.fit, found)
    reach = f"up to D = {task.values['reach']:g}, as deep as the scene can reach"
    if not any(len(curve.unloadings) for curve in within):
        bound = f"no curve unloads {reach}: the law was chosen by its loading alone, and may be elastic though the body is not"
        summary["warnings"] = [*summary["warnings"], f"{bound}; give the curve an unload_from there"]
    better = ", ".join(f"{trial.law} {trial.error:.2g}" for trial in choice.trials[:-1] if trial.error is not None) or "none"
    told = f"{choice.fit.fitted.name} is the cheapest law within {task.values['tolerance']:g} of the curves, loading and unloading, "
    summary["notes"] = [f"{told}{reach}: {choice.trials[-1].error:.2g}; cheaper ones miss by: {better}"]
    tried = [{"law": trial.law, "nanoseconds": trial.nanoseconds, "error": trial.error, "reason": trial.reason} for trial in choice.trials]
    return files, summary | {"tolerance": task.values["tolerance"], "up_to": task.values["reach"], "tried": tried}, failed


def _written(task: Task, folder: Path, fit: Fit, found: Sequence[Curve]) -> Outcome:
    """The files and the summary of a fit."""
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
