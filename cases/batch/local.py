"""Worker processes on this machine. One that dies takes its own task along and nothing else."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
from collections.abc import Iterator, Sequence
from multiprocessing.connection import Connection, wait
from types import TracebackType
from typing import Any, NamedTuple

from cases.batch import worker
from cases.batch.store import Record
from cases.batch.worker import Job

#: what keeps libraries to one thread; kernels of ours take as many as a scene asks for
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


class Said(NamedTuple):
    """A job says how far it is."""

    job: Job
    fraction: float
    text: str


class Done(NamedTuple):
    """A job has its record."""

    job: Job
    record: Record


class Died(NamedTuple):
    """The process of a job is gone."""

    job: Job
    times: int = 1  # how many deaths are the task's own, as far as whoever says so knows


Event = Said | Done | Died


class _Worker(NamedTuple):
    process: Any
    pipe: Connection


class LocalProcesses:
    """At most `jobs` processes, with one thread each but for scenes that ask for more, started when there is something to do.

    They are forked, where the system can, from a process that has loaded the modules of all `kinds` once; so a new one is there at once.
    method: another of multiprocessing's ways to start them.
    """

    def __init__(self, jobs: int, kinds: Sequence[str] = (), method: str | None = None) -> None:
        method = method or ("forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn")
        self._context: Any = multiprocessing.get_context(method)
        if method == "forkserver":
            rows = ["calibration.unloadings"] if "curves" in kinds else []  # whoever makes a curve notes its rows of the table
            self._context.set_forkserver_preload(["cases.batch.worker", *(f"cases.batch.work.{kind}" for kind in kinds), *rows])
        self.jobs = jobs
        self._idle: list[_Worker] = []
        self._busy: dict[Any, tuple[_Worker, Job]] = {}  # by pipe

    def __enter__(self) -> LocalProcesses:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """Nothing in work is waited for; a task that is cut off leaves no trace but its temporary files."""
        for process, pipe in [*self._idle, *(found for found, _ in self._busy.values())]:
            pipe.close()
            process.terminate()
        for process, _ in [*self._idle, *(found for found, _ in self._busy.values())]:
            process.join()

    @property
    def free(self) -> int:
        """How many more jobs can be taken."""
        return self.jobs - len(self._busy)

    def submit(self, job: Job) -> None:
        """Hand a job to a process."""
        one = self._idle.pop() if self._idle else self._start()
        try:
            one.pipe.send(job)
        except OSError:  # it died while it had nothing to do
            one.process.join()
            one = self._start()
            one.pipe.send(job)
        self._busy[one.pipe] = one, job

    def wait(self, seconds: float) -> Iterator[Event]:
        """What has happened, waiting so long at most for something to happen."""
        for pipe in wait(list(self._busy), seconds):
            one, job = self._busy[pipe]
            try:
                message = one.pipe.recv()
            except (EOFError, OSError):
                del self._busy[pipe]
                one.pipe.close()
                one.process.join()
                yield Died(job)
                continue
            if isinstance(message, Record):
                del self._busy[pipe]
                self._idle.append(one)
                yield Done(job, message)
            else:
                yield Said(job, *message)

    def _start(self) -> _Worker:
        ours, theirs = self._context.Pipe()
        process = self._context.Process(target=worker.serve, args=(theirs,), daemon=True)
        with _single_threaded():
            process.start()
        theirs.close()
        return _Worker(process, ours)


@contextlib.contextmanager
def _single_threaded() -> Iterator[None]:
    """Numerical libraries read these when they are loaded, in the processes that are started meanwhile."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
