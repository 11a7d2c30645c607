"""How fast a run goes and how long it has left, weighed by what its tasks cost."""

from __future__ import annotations

import json
import os
import platform
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from cases.batch import store
from cases.batch.store import Record
from cases.batch.task import Task
from contactlaws.errors import InputError

#: s between two notes on how far a run is; one that is much older is of a run that was killed
NOTE_EVERY = 2.0
STALE = 30.0


class Pace:
    """Counts what is done and measures what it took."""

    def __init__(self, tasks: Iterable[Task], jobs: int) -> None:
        self._open = {task.id: task for task in tasks}
        self._jobs = jobs
        self._began = time.monotonic()
        self._seconds: dict[str, float] = {}  # wall seconds of one process, by kind
        self._weight: dict[str, float] = {}
        self._left: dict[str, float] = {}  # weight, by kind
        for task in self._open.values():
            self._left[task.kind] = self._left.get(task.kind, 0.0) + task.weight
        self.total = len(self._open)
        self.computed = 0
        self.failed = 0

    @property
    def done(self) -> int:
        """How many have their records, reused ones included."""
        return self.total - len(self._open)

    def reused(self, task: Task) -> None:
        """A task that needs not be done."""
        if self._open.pop(task.id, None) is not None:
            self._left[task.kind] -= task.weight

    def finished(self, task: Task, record: Record) -> None:
        """A task that was done, or failed."""
        self.reused(task)
        self.computed += 1
        self.failed += record.state != "done"
        if record.wall_seconds > 0.0:
            self._seconds[task.kind] = self._seconds.get(task.kind, 0.0) + record.wall_seconds
            self._weight[task.kind] = self._weight.get(task.kind, 0.0) + task.weight

    @property
    def elapsed(self) -> float:
        """Seconds since the beginning."""
        return time.monotonic() - self._began

    @property
    def per_minute(self) -> float | None:
        """Results computed per minute; None before the first."""
        return 60.0 * self.computed / self.elapsed if self.computed and self.elapsed > 0.0 else None

    @property
    def seconds_left(self) -> float | None:
        """By what the tasks done so far took; a kind that none is done of yet is taken at its weight. None before the first."""
        if not self._weight:
            return None
        scale = sum(self._seconds.values()) / sum(self._weight.values())
        each = {kind: self._seconds[kind] / self._weight[kind] if kind in self._weight else scale for kind in self._left}
        return sum(max(weight, 0.0) * each[kind] for kind, weight in self._left.items()) / self._jobs

    def sentence(self) -> str:
        """How far, how fast, how long still.

        >>> Pace([], 1).sentence()
        '0 of 0'
        """
        rate, left = self.per_minute, self.seconds_left
        failed = f", {self.failed} failed" if self.failed else ""
        speed = "" if rate is None else f"; {rate:.3g} per minute"
        return f"{self.done:,} of {self.total:,}{failed}{speed}" + ("" if left is None else f", about {duration(left)} left")

    def note(self) -> dict[str, Any]:
        """What `fe2dem status` says of a run that goes on."""
        return {
            "process": os.getpid(),
            "host": os.uname().nodename if hasattr(os, "uname") else "",
            "time": time.time(),
            "text": self.sentence(),
        }


def duration(seconds: float) -> str:
    """A time as one says it.

    >>> duration(8.2), duration(100), duration(4000), duration(200000)
    ('8 s', '2 min', '1 h 7 min', '2 d 7 h')
    """
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    if minutes < 60:
        return f"{minutes} min"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours < 48 else f"{hours // 24} d {hours % 24} h"


def write_note(folder: Path, pace: Pace) -> None:
    """Leave word of how far a run is; what cannot be written is left out."""
    try:
        store.write_json(folder / "running.json", pace.note())
    except InputError:
        return


def remove_note(folder: Path) -> None:
    """The run is over."""
    (folder / "running.json").unlink(missing_ok=True)


def read_note(folder: Path) -> str | None:
    """How far a run is that goes on now; None if there is none."""
    try:
        note = json.loads((folder / "running.json").read_text(encoding="utf-8"))
        age = time.time() - note["time"]
        gone = note["host"] == platform.node() and not _alive(note["process"])
        return None if gone or age > STALE else f"{note['text']} ({duration(age)} ago)"
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
