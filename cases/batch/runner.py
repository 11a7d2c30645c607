"""Brings every task to a record: what is there is reused, what fails is recorded, what can go on goes on, long tasks first."""

from __future__ import annotations

import errno
import heapq
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Protocol

from cases.batch import store
from cases.batch.local import Died, Done, Event, LocalProcesses, Said
from cases.batch.store import Record
from cases.batch.task import Task
from cases.batch.worker import DEATHS, Job, Make, killed
from contactlaws.errors import InputError, Problem


class Watcher(Protocol):
    """Is told what happens, as it happens."""

    def reused(self, task: Task, record: Record) -> None: ...

    def started(self, task: Task) -> None: ...

    def advanced(self, task: Task, fraction: float, text: str) -> None: ...

    def finished(self, task: Task, record: Record) -> None: ...

    def waiting(self) -> None: ...


class Workers(Protocol):
    """Do jobs, somewhere; left as a context, they are ended."""

    jobs: int  # how many are done at the same time

    @property
    def free(self) -> int: ...

    def submit(self, job: Job) -> None: ...

    def wait(self, seconds: float) -> Iterator[Event]: ...

    def __enter__(self) -> Workers: ...

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None: ...


def there(tasks: Sequence[Task], folder: Path) -> dict[str, Record]:
    """The records of those tasks that need not be done."""
    found = {task.id: store.load(folder, task.id, task.key, verify=True) for task in tasks}
    return {task: record for task, record in found.items() if record is not None and not record.passing}


def run_locally(tasks: Sequence[Task], folder: Path, jobs: int, watcher: Watcher, make: Make | None = None) -> dict[str, Record]:
    """`run` in at most `jobs` processes of this machine."""
    kinds = sorted({task.kind for task in tasks}) if make is None else ()
    with LocalProcesses(min(jobs, max(len(tasks), 1)), kinds) as workers:
        return run(tasks, folder, workers, watcher, make)


def run(tasks: Sequence[Task], folder: Path, workers: Workers, watcher: Watcher, make: Make | None = None) -> dict[str, Record]:
    """Bring every task to a record; `make` does the work, if not the module of a task's kind.

    Raises `InputError` if the folder cannot be written or its disk is full. Records that are there stay there, so that another run goes on
    from them.
    """
    store.prepare(folder)
    records = there(tasks, folder)
    for known in tasks:
        if known.id in records:
            watcher.reused(known, records[known.id])
    agenda = Agenda([task for task in tasks if task.id not in records], records)
    while agenda.open:
        while workers.free > 0 and (task := agenda.next()) is not None:
            failed = [need for need in task.needs if not records[need].usable]
            if failed:
                _keep(_skipped(task, failed, records), agenda, records, watcher)
            else:
                watcher.started(task)
                workers.submit(Job(task, str(folder), {need: records[need] for need in task.needs}, make))
        if not agenda.open:
            break
        watcher.waiting()
        for event in workers.wait(1.0):
            if isinstance(event, Said):
                watcher.advanced(event.job.task, event.fraction, event.text)
            elif isinstance(event, Done):
                _keep(event.record, agenda, records, watcher)
                _require_space(event.record, folder)
            else:
                _after_death(event, agenda, folder, records, watcher)
    return records


class Agenda:
    """Which task comes next: of those whose needs are met, the one that takes longest; tasks with the same key are one."""

    def __init__(self, tasks: Sequence[Task], records: Mapping[str, Record]) -> None:
        self._alike: dict[tuple[str, str], list[Task]] = {}
        for task in tasks:
            self._alike.setdefault((task.kind, task.key), []).append(task)
        firsts = [group[0] for group in self._alike.values()]
        self._tasks = {task.id: task for task in tasks}
        self._missing = {task.id: {need for need in task.needs if need not in records} for task in firsts}
        self._awaited: dict[str, list[Task]] = {}
        for task in firsts:
            for need in self._missing[task.id]:
                self._awaited.setdefault(need, []).append(task)
        self._ready: list[tuple[float, int, Task]] = []
        self._deaths: dict[str, int] = {}
        self._count = 0
        for task in firsts:
            if not self._missing[task.id]:
                self._push(task)
        self.open = len(tasks)

    def _push(self, task: Task) -> None:
        self._count += 1
        heapq.heappush(self._ready, (-task.weight, self._count, task))

    def next(self) -> Task | None:
        """A task whose needs have their records; None if there is none now."""
        return heapq.heappop(self._ready)[2] if self._ready else None

    def close(self, task: Task) -> list[Task]:
        """A task has its record; returns it and all that are the same under another name."""
        alike = self._alike.pop((task.kind, task.key))
        self.open -= len(alike)
        for one in alike:
            for waiting in self._awaited.pop(one.id, ()):
                self._missing[waiting.id].discard(one.id)
                if not self._missing[waiting.id]:
                    self._push(waiting)
        return alike

    def again(self, task: Task, times: int) -> bool:
        """A task's process died; whether it is tried again."""
        self._deaths[task.id] = self._deaths.get(task.id, 0) + times
        if self._deaths[task.id] < DEATHS:
            self._push(task)
            return True
        return False

    def task(self, name: str) -> Task:
        """The task with this id."""
        return self._tasks[name]


def _keep(record: Record, agenda: Agenda, records: dict[str, Record], watcher: Watcher) -> None:
    for task in agenda.close(agenda.task(record.task)):
        records[task.id] = replace(record, task=task.id)
        watcher.finished(task, records[task.id])


def _after_death(event: Died, agenda: Agenda, folder: Path, records: dict[str, Record], watcher: Watcher) -> None:
    """The process of a job was killed: perhaps after it was done; else it is tried again, but not for ever."""
    task = event.job.task
    found = store.load(folder, task.id, task.key)
    if found is not None and not found.passing:
        _keep(found, agenda, records, watcher)
    elif not agenda.again(task, event.times):
        _keep(store.save(folder, killed(task)), agenda, records, watcher)


def _skipped(task: Task, failed: list[str], records: Mapping[str, Record]) -> Record:
    passing = any(records[need].passing for need in failed)
    return Record(task.id, task.key, "failed", f"not tried because {', '.join(failed)} failed", passing=passing, input=task.input)


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
