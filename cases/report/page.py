"""report.html: one file without any link, made from the records and files in a folder of results.

Whatever is printed says which curve it is from, how wrong it may be, and what it cost.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import jinja2

from cases.batch.results import load_case
from cases.batch.store import Record
from cases.report import parts
from contactlaws.files import write_text

#: more are told by their reasons
FEW_FAILURES = 20
TEMPLATE = Path(__file__).with_name("report.html.j2")


def write(folder: Path) -> Path:
    """Write `folder`/report.html, table.csv and table.parquet from what is there; raises `InputError` if nothing was run there."""
    case, records = load_case(folder)
    there = {record.task: record for record in records if record is not None and record.usable}
    sections = [section for section in parts.sections(folder, case, there) if section["blocks"]]
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    template = environment.from_string(TEMPLATE.read_text(encoding="utf-8"))
    text = template.render(
        title=case["title"], lead=_lead(case, list(there.values())), failures=list(_failures(case, records)), sections=sections
    )
    return write_text(folder / "report.html", text)


def _lead(case: Mapping[str, Any], records: list[Record]) -> str:
    versions = sorted({record.code for record in records})
    cost = sum(record.cpu_seconds for record in records)
    made = versions[0] if len(versions) == 1 else f"{len(versions)} code versions, see the last table"
    return f"{len(records)} of {len(case['tasks'])} results, {cost:.0f} CPU seconds in all; {made}."


def _failures(case: Mapping[str, Any], records: list[Record | None]) -> Iterator[dict[str, str]]:
    """One line each, or one for all that have the same reason where they are many."""
    reasons: dict[str, list[str]] = {}
    for item, record in zip(case["tasks"], records, strict=True):
        if record is None or record.state != "done":
            reasons.setdefault("is not there yet" if record is None else f"{record.state}: {record.reason}", []).append(item["task"])
    few = sum(map(len, reasons.values())) <= FEW_FAILURES
    for reason, tasks in reasons.items():
        if few:
            yield from ({"task": task, "reason": reason} for task in tasks)
        else:
            yield {"task": tasks[0] + (f" and {len(tasks) - 1} more" if len(tasks) > 1 else ""), "reason": reason}
