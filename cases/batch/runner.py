"""Runs tasks in local processes: what is there is reused, what fails is recorded, what can go on goes on."""

from __future__ import annotations

import contextlib
import errno
import multiprocessing
import os
import queue
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, Protocol

from cases.batch import store, worker
from cases.batch.plan import Task
from cases.batch.store import Record
from contactlaws.errors import InputError, Problem


class Watcher(Protocol):
    """Is told what happens, as it happens."""

    def reused(self, task: Task, record: Record) -> None: ...

    def started(self, task: Task) -> None: ...

    def advanced(self, task: Task, fraction: float, text: str) -> None: ...

    def finished(self, task: Task, record: Record) -> None: ...


def run(tasks: list[Task], folder: Path, jobs: int, watcher: Watcher, perform: Callable[..., Record] = worker.perform) -> dict[str, Record]:
    """Bring every task to a record, in at most `jobs` processes; `perform` does one task and runs in them.

    Raises `InputError` if the folder cannot be written or its disk is full; `KeyboardInterrupt` passes on when they are ended.
    Records that are there stay there, so that another run goes on from them.
    """
    store.prepare(folder)
    records: dict[str, Record] = {}
    for task in tasks:
        found = store.load(folder, task.id, task.key)
        if found is not None and not found.passing:
            records[task.id] = found
            watcher.reused(task, found)
    todo = [task for task in tasks if task.id not in records]
    while todo:
        todo, suspects = _round(todo, records, folder, min(jobs, len(todo)), watcher, perform)
        for suspect in suspects:  # a process that dies takes its neighbours along; alone, each shows whether it was the one
            _round([suspect], records, folder, 1, watcher, perform)
    return records


def _round(
    todo: list[Task], records: dict[str, Record], folder: Path, jobs: int, watcher: Watcher, perform: Callable[..., Record]
) -> tuple[list[Task], list[Task]]:
    """Work through `todo` on one pool of processes; returns what is left, and the suspects, because a process died."""
    waiting, running = list(todo), dict[Future[Record], Task]()
    by_id = {task.id: task for task in todo}
    with _pool(jobs) as (pool, messages):
        try:
            while waiting or running:
                for task in [task for task in waiting if all(need in records for need in task.needs)]:
                    failed = [need for need in task.needs if not records[need].usable]
                    if failed:
                        waiting.remove(task)
                        records[task.id] = _skipped(task, failed, records)
                        watcher.finished(task, records[task.id])
                    elif len(running) < jobs:
                        running[pool.submit(perform, task, str(folder), {need: records[need] for need in task.needs})] = task
                        waiting.remove(task)
                        watcher.started(task)
                done, _ = wait(running, timeout=0.1, return_when=FIRST_COMPLETED)
                _pass_on(messages, by_id, watcher)
                for future in done:
                    record = future.result()
                    task = running.pop(future)
                    records[task.id] = record
                    watcher.finished(task, record)
                    _require_space(record, folder)
        except BrokenProcessPool:
            return waiting, _after_a_death(list(running.values()), folder, records, watcher)
    return [], []


def _after_a_death(running: list[Task], folder: Path, records: dict[str, Record], watcher: Watcher) -> list[Task]:
    """A process was killed, and the pool with it. Returns the tasks that it may have been; one that was alone has failed."""
    suspects = []
    for task in running:
        found = store.load(folder, task.id, task.key)
        whole = found if found is not None and not found.passing else None
        if whole is None and len(running) > 1:
            suspects.append(task)
        else:
            records[task.id] = whole or Record(task.id, task.key, "failed", "its process was killed (out of memory?)", passing=True)
            watcher.finished(task, records[task.id])
    return suspects


def _skipped(task: Task, failed: list[str], records: dict[str, Record]) -> Record:
    passing = any(records[need].passing for need in failed)
    return Record(task.id, task.key, "failed", f"not tried because {', '.join(failed)} failed", passing=passing)


def _require_space(record: Record, folder: Path) -> None:
    if record.passing and record.summary.get("errno") in (errno.ENOSPC, errno.EDQUOT):
        raise InputError(
            Problem(
                "disk",
                str(folder),
                f"is full ({record.task} could not be written)",
                "free some space and run again; all finished results are kept",
            )
        )


def _pass_on(messages: Any, by_id: dict[str, Task], watcher: Watcher) -> None:
    with contextlib.suppress(queue.Empty):
        while True:
            task, fraction, text = messages.get_nowait()
            if task in by_id:
                watcher.advanced(by_id[task], fraction, text)


@contextlib.contextmanager
def _pool(jobs: int) -> Iterator[tuple[ProcessPoolExecutor, Any]]:
    """Spawned processes with one thread each; all are ended if the body is left by an exception, Ctrl-C among them."""
    context = multiprocessing.get_context("spawn")
    messages = context.Queue()
    before = multiprocessing.active_children()
    with _single_threaded():
        pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=worker.begin, initargs=(messages,))
        try:
            yield pool, messages
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in set(multiprocessing.active_children()) - set(before):
                process.terminate()
            raise
        pool.shutdown()


@contextlib.contextmanager
def _single_threaded() -> Iterator[None]:
    """Numerical libraries read these when they are loaded, in the processes that are started meanwhile."""
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
