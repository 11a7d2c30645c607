"""Reference curves."""

from __future__ import annotations

from pathlib import Path

from cases.batch.task import Task
from cases.batch.work.place import Made, Outcome, Report, empty_folder, place, relative
from contactlaws.curve_files import write_curve
from contactlaws.material import Material
from fem.press import press


def make(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """A reference curve, if asked for with the fields at the states that it unloads from."""
    values = dict(task.values)
    file = place(folder, task, ".parquet")
    fields = empty_folder(folder / "fields" / f"{task.name}-{task.key}") if values.pop("fields") else None
    material = Material(**values.pop("material"))
    curve = press(material, **values, fields=fields, progress=report)
    write_curve(curve, file)
    summary = {
        "hash": curve.content_hash,
        "errors": dict(curve.errors),
        "cost": curve.provenance.get("cpu_seconds"),
        "states": int(curve.overlap.size),
        "unloadings": len(curve.unloadings),
        "max_overlap": float(curve.overlap[curve.rows(0)][-1]),
        "max_force": float(curve.force[curve.rows(0)][-1]),
        "yield_overlap": curve.yield_overlap,
        "yield_place": curve.yield_place,
    }
    files = {"curve": relative(file, folder)} | ({} if fields is None else {"fields": relative(fields, folder)})
    return files, summary, curve.stopped
