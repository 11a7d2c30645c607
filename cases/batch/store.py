"""A folder of results: one record per task, named by the hash of all that it depends on, and never half written.

DIR/case.json               what the last run wanted: title, checked input, and the tasks in their order
DIR/tasks/KIND.NAME-KEY.json    one record per task; it appears last, when the files that it names are complete
DIR/curves/, fits/, ...     the files themselves, with the same KEY in their names
"""

from __future__ import annotations

import hashlib
import json
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from contactlaws.errors import InputError, Problem, require
from contactlaws.files import write_text

FINISHED = ("done", "stopped")  # states whose results can be used


@dataclass(frozen=True)
class Record:
    """What became of one task."""

    task: str  # KIND.NAME
    key: str  # hash of input, sources and what it was made from
    state: str  # done; stopped: ended early, kept up to there; failed
    reason: str | None = None  # why it stopped or failed
    passing: bool = False  # failed for a cause outside the input (memory, disk, a killed process): the next run tries again
    cpu_seconds: float = 0.0
    wall_seconds: float = 0.0
    code: str = ""  # release and source hash that made it
    files: Mapping[str, str] = field(default_factory=dict)  # what it wrote: paths relative to the folder
    summary: Mapping[str, Any] = field(default_factory=dict)  # numbers for tables and report; JSON types

    @property
    def kind(self) -> str:
        """curves, fits, packings, impacts or scenes."""
        return self.task.split(".", 1)[0]

    @property
    def name(self) -> str:
        """The name that the case file gives it."""
        return self.task.split(".", 1)[1]

    @property
    def usable(self) -> bool:
        """Whether others may be made from it."""
        return self.state in FINISHED


def hash_of(*parts: object) -> str:
    """Twelve hexadecimal digits of JSON-like values, independent of the order of keys."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()[:12]


def prepare(folder: Path) -> None:
    """Create the folder and try to write there; raises `InputError` before any computing if that cannot be done."""
    require(problems_with_folder("--out", folder / "tasks"))


def problems_with_folder(name: str, folder: Path) -> Iterator[Problem]:
    """Create a folder if it isn't there, and try to write into it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        yield Problem(name, str(folder), f"cannot be created ({error.strerror})", "choose another folder")
        return
    yield from problems_with_writing(name, folder)


def problems_with_writing(name: str, folder: Path) -> Iterator[Problem]:
    """Try to write a little into an existing folder: permission and space are only known by trying."""
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(b"\0" * 65536)
            file.flush()
    except OSError as error:
        yield Problem(name, str(folder), f"cannot be written ({error.strerror})", "choose another place, or free some space")


def write_json(path: Path, value: object) -> None:
    """JSON by atomic rename."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, json.dumps(value, indent=1, default=_plain) + "\n")


def _plain(value: Any) -> Any:
    """numpy's numbers and arrays as JSON has them."""
    return value.tolist() if hasattr(value, "tolist") else str(value)


def record_path(folder: Path, task: str, key: str) -> Path:
    """Where the record of a task stands."""
    return folder / "tasks" / f"{task}-{key}.json"


def save(folder: Path, record: Record) -> None:
    """Make a record known."""
    write_json(record_path(folder, record.task, record.key), asdict(record))


def load(folder: Path, task: str, key: str) -> Record | None:
    """The record of a task if it is there, readable, and all its files exist; None means the task is to be done."""
    try:
        record = Record(**json.loads(record_path(folder, task, key).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None
    return record if all((folder / file).exists() for file in record.files.values()) else None


def load_case(folder: Path) -> tuple[dict[str, Any], list[Record | None]]:
    """What the last run in `folder` wanted, and its records in order (None: not there yet). Raises `InputError` if there are none."""
    try:
        case = json.loads((folder / "case.json").read_text(encoding="utf-8"))
        return case, [load(folder, item["task"], item["key"]) for item in case["tasks"]]
    except (OSError, ValueError, KeyError, TypeError):
        raise InputError(Problem("folder", str(folder), "holds no results of fe2dem run", "give the folder that --out named")) from None
