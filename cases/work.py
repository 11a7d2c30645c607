"""What a task of each kind does: a function per kind, all with the same arguments and result.

Each takes the task, the folder of results, the records of what it is made from, and a progress callback. It returns the files that it wrote
(relative to the folder), numbers for tables and the report, and why it ended early (None: it did not).
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from cases.plan import Task
from cases.store import Record
from contactlaws.material import Material

Outcome = tuple[dict[str, str], dict[str, Any], str | None]
Report = Callable[[float, str], None]
Made = Mapping[str, Record]


def curves(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """A reference curve, with the fields at the states that it unloads from."""
    import fem
    from contactlaws.curve_files import write_curve

    values = dict(task.values)
    file, fields = _place(folder, task, ".parquet"), _empty_folder(folder / "fields" / f"{task.name}-{task.key}")
    material = Material(**values.pop("material"))
    curve = fem.press(material, **values, fields=fields, progress=report)
    write_curve(curve, file)
    summary = {
        "hash": curve.content_hash,
        "errors": dict(curve.errors),
        "cost": curve.provenance.get("cpu_seconds"),
        "states": int(curve.overlap.size),
        "yield_overlap": curve.yield_overlap,
        "yield_place": curve.yield_place,
    }
    return {"curve": _relative(file, folder), "fields": _relative(fields, folder)}, summary, curve.stopped


def fits(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """A law fitted to curves, and its row for the table."""
    import calibration
    from calibration import table
    from contactlaws import fitted
    from contactlaws.curve_files import read_curve

    material = None if task.values["material"] is None else Material(**task.values["material"])
    found = [read_curve(folder / made[need].files["curve"]) for need in task.needs]
    found += [read_curve(path, radius=task.values["radius"], material=material) for path in task.given]
    fit = calibration.fit(found, law=task.values["law"])
    law, row = _place(folder, task, ".json"), _place(folder, task, ".csv")
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
    return {"law": _relative(law, folder), "row": _relative(row, folder)}, summary, None


def _law(task: Task, folder: Path, made: Made) -> Any:
    """The fitted law that a task uses: made by another task, or given as a file."""
    from contactlaws import fitted

    made_by = [need for need in task.needs if need.startswith("fits.")]
    return fitted.load(folder / made[made_by[0]].files["law"] if made_by else task.given[0])


def _place(folder: Path, task: Task, ending: str) -> Path:
    """The file of a task, in a folder that exists."""
    (folder / task.kind).mkdir(exist_ok=True)
    return folder / task.kind / f"{task.name}-{task.key}{ending}"


def _empty_folder(folder: Path) -> Path:
    """A folder without what a killed attempt may have left there."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def _relative(path: Path, folder: Path) -> str:
    return path.relative_to(folder).as_posix()
