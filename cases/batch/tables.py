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


def write(folder: Path, tasks: Sequence[Task], records: Mapping[str, Record]) -> list[Path]:
    """Write curves.csv, unloadings.csv and unloadings.parquet from those of a run's curves that are there; without any, older ones go."""
    curves = [(task, records[task.id]) for task in tasks if task.kind == "curves" and task.id in records]
    if not curves:
        for name in (CURVES, f"{UNLOADINGS}.csv", f"{UNLOADINGS}.parquet"):
            (folder / name).unlink(missing_ok=True)
        return []
    with no_garbage():
        columns = _columns(curves)
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
        unloadings = unloading_rows.write(folder, [record for _, record in curves if record.usable], UNLOADINGS)
    return [write_text(folder / CURVES, text.getvalue()), *unloadings]


def write_again(folder: Path) -> list[Path]:
    """`write` for what is there of the last run; raises `InputError` if nothing was run there."""
    with no_garbage():
        case, found = load_case(folder)
        names = [item["task"].split(".", 1) for item in case["tasks"]]
        tasks = [Task(kind, name, item["values"], key=item["key"]) for (kind, name), item in zip(names, case["tasks"], strict=True)]
        return write(folder, tasks, {record.task: record for record in found if record is not None})


def _columns(curves: Sequence[tuple[Task, Record]]) -> dict[str, list[Any]]:
    """The columns of curves.csv by their names, in which SI units stand."""
    values, records = [task.values for task, _ in curves], [record for _, record in curves]
    materials, summaries = [value["material"] for value in values], [record.summary for record in records]
    errors = [summary.get("errors", {}) for summary in summaries]
    return {
        "curve": [task.name for task, _ in curves],
        "state": [record.state for record in records],
        "reason": [record.reason for record in records],
        "youngs_modulus_Pa": [material["youngs_modulus"] for material in materials],
        "poissons_ratio": [material["poissons_ratio"] for material in materials],
        "yield_stress_Pa": [material["yield_stress"] for material in materials],
        "radius_m": [value["radius"] for value in values],
        "aspect": [value["aspect"] for value in values],
        "tolerance": [value["tolerance"] for value in values],
        "max_overlap_m": [summary.get("max_overlap") for summary in summaries],
        "max_force_N": [summary.get("max_force") for summary in summaries],
        "unloadings": [summary.get("unloadings") for summary in summaries],
        "yield_overlap_m": [summary.get("yield_overlap") for summary in summaries],
        **{f"error_{name}": [error.get(name) for error in errors] for name in QUANTITIES},
        "states": [summary.get("states") for summary in summaries],
        "solver_cpu_seconds": [summary.get("cost") for summary in summaries],
        "cpu_seconds": [record.cpu_seconds for record in records],
        "hash": [summary.get("hash") for summary in summaries],
        "key": [task.key for task, _ in curves],
        "code": [record.code for record in records],
        "file": [record.files.get("curve") for record in records],
    }
