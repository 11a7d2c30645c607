"""One task in one process: does it if nobody else has, writes what it made, and says how it went."""

from __future__ import annotations

import errno
import functools
import importlib
import os
import signal
import threading
import time
from collections.abc import Callable, Mapping
from multiprocessing import parent_process
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple

from cases.batch import attempts, store, unloading_rows
from cases.batch.claims import claimed
from cases.batch.store import Record
from cases.batch.task import Task
from contactlaws.errors import InputError
from contactlaws.version import code_version

INTERVAL = 0.2  # s between two messages about the same task
#: a task whose process has died so often is not tried again in the same run
DEATHS = 3

Report = Callable[[float, str], None]
Make = Callable[[Task, Path, Mapping[str, Record], Report], tuple[dict[str, str], dict[str, Any], str | None]]


class Job(NamedTuple):
    """A task and all that a process needs to do it."""

    task: Task
    folder: str
    made: Mapping[str, Record]  # the records of what it needs
    make: Make | None = None  # what does it; None: the module of its kind in `cases.batch.work`
    run: str | None = None  # a word for the run, where deaths are counted by `attempts`; None: whoever gave the job sees its process die


def serve(pipe: Connection) -> None:
    """Do jobs until the pipe closes. Ctrl-C is the parent's business, and a parent that was killed takes its workers along."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        while True:
            job = pipe.recv()
            pipe.send(perform(job, _reporter(pipe)))
    except (EOFError, OSError):
        return


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _reporter(pipe: Connection) -> Report:
    """A progress callback that sends a message now and then, and all that is said before the work begins."""
    last = 0.0

    def report(fraction: float, text: str) -> None:
        nonlocal last
        if fraction == 0.0 or time.monotonic() - last >= INTERVAL:
            last = time.monotonic()
            pipe.send((float(fraction), text))

    return report


def silent(fraction: float, text: str) -> None:
    """Where nobody listens."""


def perform(job: Job, report: Report = silent) -> Record:
    """Do one job, or wait for whoever is doing it; the record returned is on disk already, unless the disk refused."""
    task, folder = job.task, Path(job.folder)
    with claimed(folder, task.key):
        found = store.load(folder, task.id, task.key, verify=True)
        if found is not None and not found.passing:
            return found
        if job.run is None:
            return _saved(folder, _made(job, report))
        return _noted(job, job.run, report)


def _noted(job: Job, run: str, report: Report) -> Record:
    """Do a job, and leave a note as long as it is not done; one that has killed its process too often is not begun again."""
    task, folder = job.task, Path(job.folder)
    if attempts.begun(folder, task, run) >= DEATHS:
        record = _saved(folder, killed(task))
    else:
        attempts.begin(folder, task, run)
        record = _saved(folder, _made(job, report))
    attempts.end(folder, task)
    return record


def killed(task: Task) -> Record:
    """What is recorded of a task whose process has died too often; the next run tries it again."""
    reason = f"its process was killed {DEATHS} times (out of memory?)"
    return Record(task.id, task.key, "failed", reason, passing=True, input=task.input)


def _made(job: Job, report: Report) -> Record:
    task, cpu, wall = job.task, time.process_time(), time.perf_counter()
    make = job.make or importlib.import_module(f"cases.batch.work.{task.kind}").make
    with _libraries(make).limit(limits=1):
        try:
            files, summary, stopped = make(task, Path(job.folder), job.made, report)
            outcome: dict[str, Any] = {"state": "stopped" if stopped else "done", "reason": stopped, "files": files, "summary": summary}
        except Exception as error:  # a failure is a result: recorded with its reason, and the other tasks go on
            outcome = _failure(error)
    outcome |= {"cpu_seconds": time.process_time() - cpu, "wall_seconds": time.perf_counter() - wall, "code": code_version()}
    return Record(task.id, task.key, **outcome, input=task.input)


@functools.cache
def _libraries(make: Make) -> Any:
    """The threaded libraries that are loaded when this is first to be done: to look for them takes longer than a small task."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def _saved(folder: Path, record: Record) -> Record:
    try:
        whole = store.save(folder, record)
    except (OSError, InputError) as error:
        return Record(record.task, record.key, **_failure(error), code=record.code, input=record.input)
    unloading_rows.note(folder, whole)
    return whole


def _failure(error: Exception) -> dict[str, Any]:
    """What a record says of an exception; a cause in the machine rather than in the input is passing."""
    cause = next((found for found in (error, error.__cause__) if isinstance(found, OSError)), None)
    number = cause.errno if cause is not None else None
    passing = isinstance(error, MemoryError) or (number is not None and number not in (errno.ENOENT, errno.EISDIR))
    reason = str(error) if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
    return {"state": "failed", "reason": reason, "passing": passing, "summary": {} if number is None else {"errno": number}}
