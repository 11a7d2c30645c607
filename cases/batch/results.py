"""What a folder of results holds as a whole: whose it is, what is there, and what is left of other versions."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from cases.batch import store
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
    try:
        case = json.loads((folder / "case.json").read_text(encoding="utf-8"))
        return case, [store.load(folder, item["task"], item["key"]) for item in case["tasks"]]
    except (OSError, ValueError, KeyError, TypeError):
        raise InputError(Problem("folder", str(folder), "holds no results of fe2dem run", "give the folder that --out named")) from None


def listing(folder: Path) -> Listing:
    """`load_case`, and how many results of other sources or other input the folder keeps."""
    case, records = load_case(folder)
    wanted = {store.record_path(folder, item["task"], item["key"]).name for item in case["tasks"]}
    inputs = {item.get("input") for item in case["tasks"]}
    with os.scandir(folder / "tasks") as entries:
        others = [entry.path for entry in entries if entry.name.endswith(".json") and entry.name not in wanted]
    same = sum(_input_of(path) in inputs for path in others)
    return Listing(case, records, same, len(others) - same)


def _input_of(path: str) -> str | None:
    try:
        return store.record_in(Path(path).read_bytes()).input or None
    except (OSError, ValueError, TypeError):
        return None


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
