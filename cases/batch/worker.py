"""One task in one process: does it, writes what it made, and says how it went."""

from __future__ import annotations

import errno
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from cases.batch import store
from cases.batch.plan import Task
from cases.batch.store import Record
from contactlaws.errors import InputError
from contactlaws.version import code_version

_messages: Any = None  # the queue to the process that watches; set once per worker process
INTERVAL = 0.2  # s between two messages about the same task


def begin(messages: Any) -> None:
    """Prepare a worker process: Ctrl-C is the parent's business, and a parent that was killed takes its workers along."""
    global _messages
    _messages = messages
    messages.cancel_join_thread()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def reporter(task: Task) -> Callable[[float, str], None]:
    """A progress callback for one task that sends a message now and then, and all that is said before the work begins."""
    last = 0.0

    def report(fraction: float, text: str) -> None:
        nonlocal last
        if _messages is not None and (fraction == 0.0 or time.monotonic() - last >= INTERVAL):
            last = time.monotonic()
            _messages.put((task.id, float(fraction), text))

    return report


def perform(task: Task, folder: str, made: Mapping[str, Record]) -> Record:
    """Do one task from the records `made` of what it needs; the record returned is on disk already, unless the disk refused."""
    from threadpoolctl import threadpool_limits

    from cases.batch import work

    cpu, wall = time.process_time(), time.perf_counter()
    with threadpool_limits(1):
        try:
            files, summary, stopped = getattr(work, task.kind)(task, Path(folder), made, reporter(task))
            outcome: dict[str, Any] = {"state": "stopped" if stopped else "done", "reason": stopped, "files": files, "summary": summary}
        except Exception as error:  # a failure is a result: recorded with its reason, and the other tasks go on
            outcome = _failure(error)
    outcome |= {"cpu_seconds": time.process_time() - cpu, "wall_seconds": time.perf_counter() - wall, "code": code_version()}
    return _saved(Path(folder), Record(task.id, task.key, **outcome))


def _saved(folder: Path, record: Record) -> Record:
    try:
        store.save(folder, record)
    except (OSError, InputError) as error:
        return Record(record.task, record.key, **_failure(error), code=record.code)
    return record


def _failure(error: Exception) -> dict[str, Any]:
    """What a record says of an exception; a cause in the machine rather than in the input is passing."""
    cause = next((found for found in (error, error.__cause__) if isinstance(found, OSError)), None)
    number = cause.errno if cause is not None else None
    passing = isinstance(error, MemoryError) or (number is not None and number not in (errno.ENOENT, errno.EISDIR))
    reason = str(error) if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
    return {"state": "failed", "reason": reason, "passing": passing, "summary": {} if number is None else {"errno": number}}
