"""How often a run has begun a task without ending it: where nobody sees a worker die, so its deaths are counted.

A Dask scheduler blames a lost worker on all tasks that it held, also on those that only waited there. So whoever begins a task notes it in
the folder of results, and takes the note away when the task has its record, whatever that says. Notes of other runs do not count: these
may have been ended, with all their workers, for reasons of their own.
"""

from __future__ import annotations

import os
from pathlib import Path

from cases.batch.task import Task

NOTES = ".begun"


def begun(folder: Path, task: Task, run: str) -> int:
    """How often `run` has begun a task that was never ended."""
    try:
        return _note(folder, task).read_text(encoding="ascii").split().count(run)
    except OSError:
        return 0


def begin(folder: Path, task: Task, run: str) -> None:
    """Note that `run` (a word) begins a task."""
    path = _note(folder, task)
    path.parent.mkdir(exist_ok=True)
    handle = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)
    try:
        os.write(handle, f"{run}\n".encode("ascii"))
    finally:
        os.close(handle)


def end(folder: Path, task: Task) -> None:
    """The task has its record."""
    _note(folder, task).unlink(missing_ok=True)


def _note(folder: Path, task: Task) -> Path:
    return folder / "tasks" / NOTES / f"{task.kind}-{task.key}"
