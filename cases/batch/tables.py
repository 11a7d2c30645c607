"""Tables of a run that pandas and spreadsheets open: curves and unloadings; that of the laws comes with the report."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cases.batch import unloading_rows
from cases.batch.index import no_garbage
from cases.batch.results import load_case
from cases.batch.store import Record
from cases.batch.task import Task
from contactlaws.curve import QUANTITIES
from contactlaws.files import write_text

CURVES, UNLOADINGS = "curves.csv", "unloadings"
#: columns of curves.csv; SI units stand in the names
COLUMNS = (
    "curve",
    "state",
    "reason",
    "youngs_modulus_Pa",
    "poissons_ratio",
    "yield_stress_Pa",
    "radius_m",
    "aspect",
    "tolerance",
    "max_overlap_m",
    "max_force_N",
    "unloadings",
    "yield_overlap_m",
    *(f"error_{name}" for name in QUANTITIES),
    "states",
    "solver_cpu_seconds",
    "cpu_seconds",
    "hash",
    "key",
    "code",
    "file",
)


def write(folder: Path, tasks: Sequence[Task], records: Mapping[str, Record]) -> list[Path]:
    """Write curves.csv, unloadings.csv and unloadings.parquet from those of a run's curves that are there; without any, older ones go."""
    curves = [(task, records[task.id]) for task in tasks if task.kind == "curves" and task.id in records]
    if not curves:
        for name in (CURVES, f"{UNLOADINGS}.csv", f"{UNLOADINGS}.parquet"):
            (folder / name).unlink(missing_ok=True)
        return []
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    with no_garbage():
        writer.writerows(list(_row(task, record).values()) for task, record in curves)
        unloadings = unloading_rows.write(folder, [record for _, record in curves if record.usable], UNLOADINGS)
    return [write_text(folder / CURVES, text.getvalue()), *unloadings]


def write_again(folder: Path) -> list[Path]:
    """`write` for what is there of the last run; raises `InputError` if nothing was run there."""
    with no_garbage():
        case, found = load_case(folder)
    names = [item["task"].split(".", 1) for item in case["tasks"]]
    tasks = [Task(kind, name, item["values"], key=item["key"]) for (kind, name), item in zip(names, case["tasks"], strict=True)]
    return write(folder, tasks, {record.task: record for record in found if record is not None})


def _row(task: Task, record: Record) -> dict[str, Any]:
    values, summary = task.values, record.summary
    material = values["material"]
    return {
        "curve": task.name,
        "state": record.state,
        "reason": record.reason,
        "youngs_modulus_Pa": material["youngs_modulus"],
        "poissons_ratio": material["poissons_ratio"],
        "yield_stress_Pa": material["yield_stress"],
        "radius_m": values["radius"],
        "aspect": values["aspect"],
        "tolerance": values["tolerance"],
        "max_overlap_m": summary.get("max_overlap"),
        "max_force_N": summary.get("max_force"),
        "unloadings": summary.get("unloadings"),
        "yield_overlap_m": summary.get("yield_overlap"),
        **{f"error_{name}": summary.get("errors", {}).get(name) for name in QUANTITIES},
        "states": summary.get("states"),
        "solver_cpu_seconds": summary.get("cost"),
        "cpu_seconds": record.cpu_seconds,
        "hash": summary.get("hash"),
        "key": task.key,
        "code": record.code,
        "file": record.files.get("curve"),
    }
