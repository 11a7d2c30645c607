"""What a folder of results holds as a whole: whose it is, what is there, and what is left of other versions."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from cases.batch import store
from cases.batch.index import all_records
from cases.batch.store import Record
from cases.batch.task import Task
from contactlaws.errors import InputError, Problem


class Listing(NamedTuple):
    """What the last run in a folder wanted, and what is there of it."""

    case: dict[str, Any]
    records: list[Record | None]  # in the order of case["tasks"]; None: not there yet
    other_code: int  # results of the same input by other sources; kept, not used
    other_input: int  # results of other input; kept, not used


def load_case(folder: Path) -> tuple[dict[str, Any], list[Record | None]]:
    """What the last run in `folder` wanted, and its records in order (None: not there yet). Raises `InputError` if there are none."""
    found = listing(folder)
    return found.case, found.records


def listing(folder: Path) -> Listing:
    """`load_case`, and how many results of other sources or other input the folder keeps."""
    try:
        case = json.loads((folder / "case.json").read_text(encoding="utf-8"))
        wanted = [(item["task"], f"{item['task'].split('.', 1)[0]}-{item['key']}.json", item.get("input")) for item in case["tasks"]]
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise InputError(Problem("folder", str(folder), "holds no results of fe2dem run", "give the folder that --out named")) from None
    known = all_records(folder)
    records = [_found(folder, known.get(name), task) for task, name, _ in wanted]
    others = known.keys() - {name for _, name, _ in wanted}
    inputs = {item for _, _, item in wanted}
    same = sum(known[name].input in inputs for name in others)
    return Listing(case, records, same, len(others) - same)


def _found(folder: Path, record: Record | None, task: str) -> Record | None:
    if record is None or not store.is_whole(folder, record):
        return None
    return record if record.task == task else replace(record, task=task)


def declare(folder: Path, title: str, source: Path, code: str, tasks: Sequence[Task]) -> None:
    """Write down what a run wants."""
    listed = [
        {"task": task.id, "key": task.key, "input": task.input, "values": task.values, "needs": task.needs, "given": task.given}
        for task in tasks
    ]
    store.write_json(folder / "case.json", {"title": title, "source": str(source), "code": code, "tasks": listed})


def require_own(folder: Path, source: Path, tasks: Iterable[Task]) -> None:
    """Raise `InputError` if the folder holds the results of another study.

    It is the same study if its file is the same, whatever has changed in it, or if all that one of the two wants is wanted by the other: a
    file that was moved, or made longer.
    """
    try:
        case = json.loads((folder / "case.json").read_text(encoding="utf-8"))
        before = {item.get("input", item["key"]) for item in case["tasks"]}
    except (OSError, ValueError, KeyError, TypeError):
        return
    now = {task.input for task in tasks}
    if case.get("source") == str(source) or before <= now or now <= before:
        return
    bound = f"holds the results of another study, {case['title']!r} ({case.get('source', 'of an older release')})"
    remedy = "choose another folder, or say --take-over: its results stay there, but tables and report become those of this study"
    raise InputError(Problem("--out", str(folder), bound, remedy))
