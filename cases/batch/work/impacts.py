"""Restitution curves of fitted laws."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import contactlaws  # noqa: F401  (all laws: any may stand in the file)
from cases.batch.task import Task
from cases.batch.work.place import Made, Outcome, Report, law_file
from contactlaws import fitted
from dem.impact import restitution


def make(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """Restitution at every speed; the numbers are few and stand in the record itself."""

    fit = fitted.load(law_file(folder, task, made))
    report(0.0, f"{len(task.values['speed'])} speeds")
    table = restitution(fit.law, task.values["radius"], task.values["density"], task.values["speed"])
    summary = {name: column.tolist() for name, column in table._asdict().items()}
    return {}, summary | {"warnings": list(range_warnings(fit, table.speed, table.largest_overlap, task.values["radius"]))}, None


def range_warnings(fit: Any, speeds: Any, overlaps: Any, radius: float) -> Iterator[str]:
    """One sentence if a law is used beyond what it was fitted to; `overlaps` (m) are those of a pair of spheres of `radius` (m)."""
    limit = fit.max_overlap / fit.law.radius
    beyond = [float(speed) for speed, overlap in zip(speeds, overlaps, strict=True) if 0.5 * overlap / radius > limit * (1.0 + 1e-9)]
    if beyond:
        yield f"from {min(beyond):g} m/s on, overlaps go beyond δ/R = {limit:.3g}, up to which {fit.name} was fitted: extrapolated"
