"""Where the files of a task stand."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from cases.batch.store import Record
from cases.batch.task import Task

Outcome = tuple[dict[str, str], dict[str, Any], str | None]
Report = Callable[[float, str], None]
Made = Mapping[str, Record]


def place(folder: Path, task: Task, ending: str) -> Path:
    """The file of a task, in a folder that exists."""
    (folder / task.kind).mkdir(exist_ok=True)
    return folder / task.kind / f"{task.name}-{task.key}{ending}"


def empty_folder(folder: Path) -> Path:
    """A folder without what a killed attempt may have left there."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def relative(path: Path, folder: Path) -> str:
    return path.relative_to(folder).as_posix()


def law_file(folder: Path, task: Task, made: Made) -> Path:
    """The file of the law that a task uses: made by another task, or given."""
    made_by = [need for need in task.needs if need.startswith(("fits.", "draws."))]
    return folder / made[made_by[0]].files["law"] if made_by else Path(task.given[0])
