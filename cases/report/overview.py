"""The report of a study: what so many results have in common, where a small case shows each of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from calibration import table as fit_tables
from calibration.residuals import Measures
from cases.batch.store import Record
from cases.console import number, percent
from contactlaws.curve import QUANTITIES

Block = dict[str, Any]
#: more results of one kind are shown as a whole
FEW = {"curves": 12, "fits": 20, "impacts": 12, "scenes": 12}
PERCENTILES = (50, 75, 90, 100)


def is_large(kind: str, there: Mapping[str, Record]) -> bool:
    """Whether results of a kind are too many to show each."""
    return sum(record.kind == kind for record in there.values()) > FEW[kind]


def curves(case: Mapping[str, Any], there: Mapping[str, Record]) -> Iterator[Block]:
    """Counts, ranges, percentiles of the estimated errors and of the cost."""
    records = [record for record in there.values() if record.kind == "curves"]
    values = [item["values"] for item in case["tasks"] if item["task"] in there and item["task"].startswith("curves.")]
    yield _text(
        f"{len(records)} bodies pressed by their mid-plane against a rigid frictionless flat, by finite elements at finite strain, with "
        f"{sum(record.summary.get('unloadings', 0) for record in records):,} unloadings: {', '.join(_ranges(values))}. curves.csv has a "
        "row for each curve, unloadings.csv and unloadings.parquet one for each unloading."
    )
    rows = []
    for name in QUANTITIES:
        errors = [record.summary.get("errors", {}).get(name) for record in records]
        shown = (lambda value: number(value, 2)) if name == "unloading_exponent" else percent
        rows.append((f"estimated error of the {name.replace('_', ' ')}", *map(shown, _percentiles(errors))))
    rows.append(("solver, CPU s", *(number(value, 3) for value in _percentiles(record.summary.get("cost") for record in records))))
    yield _table(("over the curves", "half of them up to", "three quarters", "nine tenths", "all"), rows)


def _ranges(values: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """What varies between the curves, and between which bounds."""
    ratios = {
        value["material"]["youngs_modulus"] / value["material"]["yield_stress"] for value in values if value["material"]["yield_stress"]
    }
    columns = {"E/Y": ratios, "ν": {value["material"]["poissons_ratio"] for value in values}}
    columns |= {"R (m)": {value["radius"] for value in values}, "aspect": {value["aspect"] for value in values}}
    columns |= {"tolerance": {value["tolerance"] for value in values}}
    for name, found in columns.items():
        if found:
            low, high = min(found), max(found)
            yield f"{name} {low:g}" if low == high else f"{name} {low:g} to {high:g} ({len(found)} values)"


def laws(folder: Path, there: Mapping[str, Record]) -> Iterator[Block]:
    """Percentiles of the differences between law and curve, law by law, and what their fits warn of."""
    records = [record for record in there.values() if record.kind == "fits"]
    found = {record.task: fit_tables.read(folder / record.files["row"]).rows[0] for record in records}
    write_tables(folder, found.values())
    yield _text(
        "Differences between law and curve, each quantity apart: force and contact radius along the loading, then unloading stiffness "
        "1/(δ_max − δ_0), residual overlap, force along the unloadings, and energy given back; half of the fits / nine tenths / all of "
        "them are below. table.csv and table.parquet have a row for each fit."
    )
    by_law: dict[str, list[fit_tables.Row]] = {}
    for row in found.values():
        by_law.setdefault(row.fitted.name, []).append(row)
    body = []
    for name, rows in by_law.items():
        measures = [_percentiles(getattr(row.residuals, measure) for row in rows) for measure in Measures._fields]
        body.append((name, str(len(rows)), *(" / ".join(map(percent, (three[0], three[2], three[3]))) for three in measures)))
    yield _table(("law", "fits", *(name.replace("_", " ") for name in Measures._fields)), body)
    for text, names in _warnings(records).items():
        yield _text(f"{names[0]}{f' and {len(names) - 1} more' if len(names) > 1 else ''}: {text}.", note=True)


def _warnings(records: Iterable[Record]) -> dict[str, list[str]]:
    """Which results warn of what; warnings that differ in their numbers alone are the same."""
    found: dict[str, list[str]] = {}
    shown: dict[str, str] = {}
    for record in records:
        for text in dict.fromkeys(record.summary.get("warnings", ())):
            kind = "".join(character for character in text if not character.isdigit())
            found.setdefault(shown.setdefault(kind, text), []).append(record.name)
    return dict(sorted(found.items(), key=lambda item: -len(item[1]))[:12])


def many(kind: str, there: Mapping[str, Record]) -> Iterator[Block]:
    """Where a kind has no percentiles worth showing: how many there are and where their numbers stand."""
    count = sum(record.kind == kind for record in there.values())
    yield _text(f"{count} results of this kind: too many to draw. Each has its numbers in the folders tasks and {kind}.")


def costs(there: Mapping[str, Record]) -> Iterator[Block]:
    """Cost by kind, and which code made what."""
    rows = []
    for kind, count in Counter(record.kind for record in there.values()).items():
        cost = [record.cpu_seconds for record in there.values() if record.kind == kind]
        rows.append((kind, f"{count:,}", f"{sum(cost):,.1f}", *(number(value, 3) for value in _percentiles(cost))))
    yield _text("CPU seconds of the results when they were made, compilation of kernels included.")
    yield _table(("results", "how many", "CPU s in all", "half of them up to", "three quarters", "nine tenths", "all"), rows)
    for code, count in Counter(record.code for record in there.values()).items():
        yield _text(f"{count:,} results by {code}.", note=True)


def write_tables(folder: Path, rows: Iterable[fit_tables.Row]) -> None:
    """table.csv and table.parquet of these fits; without any, older ones go."""
    rows = list(rows)
    for name in ("table.csv", "table.parquet"):
        if rows:
            fit_tables.write(rows, folder / name)
        else:
            (folder / name).unlink(missing_ok=True)


def _percentiles(values: Iterable[float | None]) -> list[float | None]:
    """The values that so many per cent do not exceed; None where there are none."""
    known = [value for value in values if value is not None and np.isfinite(value)]
    return [float(np.percentile(known, share, method="higher")) if known else None for share in PERCENTILES]


def _text(words: str, note: bool = False) -> Block:
    return {"kind": "text", "text": words, "note": note}


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> Block:
    return {"kind": "table", "columns": columns, "rows": rows}
