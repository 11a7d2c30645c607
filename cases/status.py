"""`fe2dem status`: what is there of a run, what failed and why, what is still to be made, and how long that takes."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from rich.markup import escape

from cases.batch import pace
from cases.batch.results import Listing
from cases.console import one_line, out, sheet
from cases.progress import FEW, reasons

STATES = ("done", "stopped", "failed", "not there yet")


def show_status(found: Listing, folder: Path, everything: bool = False) -> None:
    """One row per task of a small run, one per kind of a large one; then failures with their reasons, and what else the folder keeps."""
    out.print(found.case["title"])
    if everything or len(found.records) <= FEW:
        _each(found)
    else:
        _counts(found)
        for line in reasons(record for record in found.records if record is not None and record.state != "done"):
            out.print(line)
    running = pace.read_note(folder)
    if running is not None:
        out.print(f"running: {running}")
    elif None in found.records:
        out.print("not running; run it again and it goes on from what is there")
    for count, cause in ((found.other_code, "the same input by another version of the code"), (found.other_input, "other input")):
        if count:
            out.print(f"also kept, and used for nothing here: {count:,} results of {cause}")


def _each(found: Listing) -> None:
    """One line each, never broken, so that it can be searched: names of grids are long, and reasons are longer."""
    out.print(f"{'state':13} {'CPU s':>8}  {'key':16}  task")
    for item, record in zip(found.case["tasks"], found.records, strict=True):
        state = STATES[-1] if record is None else record.state
        cost = "" if record is None else f"{record.cpu_seconds:.1f}"
        reason = f": {one_line(record)}" if record is not None and record.reason else ""
        out.print(f"{state:13} {cost:>8}  {item['key']:16}  {escape(item['task'])}{reason}")


def _counts(found: Listing) -> None:
    counts: dict[str, Counter[str]] = {}
    cost: Counter[str] = Counter()
    for item, record in zip(found.case["tasks"], found.records, strict=True):
        kind = item["task"].split(".", 1)[0]
        counts.setdefault(kind, Counter())[record.state if record is not None else STATES[-1]] += 1
        cost[kind] += record.cpu_seconds if record is not None else 0.0  # type: ignore[assignment]
    table = sheet("kind", *STATES, "CPU s")
    for kind, states in counts.items():
        table.add_row(kind, *(f"{states[state]:,}" for state in STATES), f"{cost[kind]:,.1f}")
    out.print(table)
