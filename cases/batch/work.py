"""What a task of each kind does: a function per kind, all with the same arguments and result.

Each takes the task, the folder of results, the records of what it is made from, and a progress callback. It returns the files that it wrote
(relative to the folder), numbers for tables and the report, and why it ended early (None: it did not).
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from cases.batch.plan import Task
from cases.batch.store import Record, hash_of
from contactlaws.files import write_atomically
from contactlaws.material import Material
from contactlaws.version import code_version

Outcome = tuple[dict[str, str], dict[str, Any], str | None]
Report = Callable[[float, str], None]
Made = Mapping[str, Record]


def curves(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """A reference curve, if asked for with the fields at the states that it unloads from."""
    import fem
    from contactlaws.curve_files import write_curve

    values = dict(task.values)
    file = _place(folder, task, ".parquet")
    fields = _empty_folder(folder / "fields" / f"{task.name}-{task.key}") if values.pop("fields") else None
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
    files = {"curve": _relative(file, folder)} | ({} if fields is None else {"fields": _relative(fields, folder)})
    return files, summary, curve.stopped


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


def packings(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """A random close packing: positions, radius and box in an .npz file."""
    import numpy as np

    from dem.packing import random_close_packing

    report(0.0, "pushing spheres apart")
    packing = random_close_packing(**task.values)
    file = _place(folder, task, ".npz")

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
    return {"packing": _relative(file, folder)}, summary, None


def impacts(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """Restitution at every speed; the numbers are few and stand in the record itself."""
    from dem.impact import restitution

    fit = _law(task, folder, made)
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


def scenes(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """A packing compressed and released on a law: history table, LAMMPS dump, .vtu frames."""
    import dem
    from cases.report import history
    from dem import output

    fit, values = _law(task, folder, made), task.values
    contact = dem.Contact(normal=fit.law, fitted_overlap=fit.max_overlap / fit.law.radius)
    packing = next(_packing(folder / made[need].files["packing"]) for need in task.needs if need.startswith("packings."))
    programme = dem.uniaxial_compression(values["strain"], strain_rate=values["strain_rate"], release=values["release"])
    scene = dem.packed_scene(packing, values["density"], contact, programme)
    # a run can only be continued by the code that began it, so the code is in the checkpoint's name
    checkpoint = _place(folder, task, f"-{hash_of(code_version())}.checkpoint.npz")
    trajectory = dem.run(scene, progress=report, checkpoint=checkpoint)
    table, dump = _place(folder, task, ".parquet"), _place(folder, task, ".dump")
    frames = _empty_folder(folder / "frames" / f"{task.name}-{task.key}")
    history.write(history.columns(trajectory), table)
    output.write_dump(trajectory, dump)
    output.write_vtu(trajectory, frames)
    checkpoint.unlink(missing_ok=True)
    files = {"history": _relative(table, folder), "dump": _relative(dump, folder), "frames": _relative(frames, folder)}
    summary = {"notes": list(trajectory.notes), "warnings": list(trajectory.warnings), "statistics": dict(trajectory.statistics)}
    return files, summary, trajectory.stopped


def _packing(path: Path) -> Any:
    import numpy as np

    from dem.box import Box
    from dem.packing import Packing

    with np.load(path, allow_pickle=False) as file:
        lengths = tuple(float(value) for value in file["lengths"])
        return Packing(file["position"], float(file["radius"]), Box(lengths), float(file["packing_fraction"]), 0.0, 0, 0.0)  # type: ignore[arg-type]
