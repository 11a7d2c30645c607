"""The same jobs on a Dask cluster that somebody has started: `dask scheduler`, and `dask worker ADDRESS --nthreads 1` on every core.

The workers must see the folder of results under the same path, and run the same sources. All that is lasting is written by the job
itself, so it doesn't matter who dies: client, scheduler or worker. Workers may come and go; a scheduler that is gone is waited for.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import queue
import time
import uuid
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any

from cases.batch import attempts
from cases.batch.local import Died, Done, Event
from cases.batch.worker import Job, perform
from cases.console import log
from contactlaws.errors import InputError, Problem
from contactlaws.version import code_version, sources_alone

#: jobs that wait at the scheduler for each one in work, so that no worker waits for the client
AHEAD = 2
CONNECT_SECONDS = 10
#: s for which a scheduler that is gone is waited for
RETURN_SECONDS = 120
#: s between two counts of the workers
COUNT_EVERY = 5.0
#: so often a scheduler may give a job up that no worker has begun
NEVER_BEGUN = 5


class DaskCluster:
    """The workers of the scheduler at `address`; raises `InputError` if they cannot do the work."""

    def __init__(self, address: str, folder: Path) -> None:
        self._distributed = _distributed()
        self._address, self._folder, self._run = address, folder, uuid.uuid4().hex[:12]
        self._arrived: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._running: dict[str, tuple[Any, Job]] = {}
        self._given_up: Counter[str] = Counter()
        self._submitted = 0
        self._lost: list[Job] = []  # with a scheduler
        self._connect()

    def _connect(self) -> None:
        remedy = "start one with `dask scheduler`, and give what it prints"
        try:
            self._client = self._distributed.Client(self._address, timeout=CONNECT_SECONDS, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise _refused(self._address, f"no scheduler answers there ({error})", remedy) from None
        try:
            self._examine()
        except (OSError, TimeoutError) as error:  # it has gone since, or a worker has
            self._client.close()
            raise _refused(self._address, f"scheduler or workers have gone ({error})", remedy) from None
        except BaseException:
            self._client.close()
            raise

    def _examine(self) -> None:
        address, threads = self._address, self._client.nthreads()
        if not threads:
            raise _refused(address, "the scheduler has no workers", f"start some with `dask worker {address} --nthreads 1`")
        if max(threads.values()) > 1:
            raise _refused(address, "workers of several threads measure each other's time", "start them with --nthreads 1")
        versions, seen = self._client.run(code_version), self._client.run(_sees, str(self._folder))
        own = sources_alone(code_version())
        others = sorted({sources_alone(version) for version in versions.values()} - {own})
        if others:
            raise _refused(
                address,
                f"workers run other sources: {others[0]}, here {own}",
                "install the same version there, and restart them",
            )
        blind = sorted(worker for worker, sees in seen.items() if not sees)
        if blind:
            bound = f"{blind[0]} does not see {self._folder}"
            raise _refused(address, bound, "give a folder that all machines share, under the same path")
        self.jobs, self._counted, self._deserted = len(threads), time.monotonic(), False

    def __enter__(self) -> DaskCluster:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """Jobs in work are finished by their workers; those that wait are withdrawn."""
        self._client.close()

    @property
    def free(self) -> int:
        """How many more jobs can be taken."""
        return AHEAD * self.jobs - len(self._running)

    def submit(self, job: Job) -> None:
        """Hand a job to the scheduler, under a name of its own: the same task may be another client's, or have been given up before."""
        if self._client.status != "running":
            self._find_again()
        self._submitted += 1
        key = f"fe2dem-{job.task.kind}-{job.task.key}-{self._run}-{self._submitted}"
        future = self._client.submit(perform, job._replace(run=self._run), key=key, pure=False)
        self._running[future.key] = future, job
        future.add_done_callback(self._arrived.put)

    def wait(self, seconds: float) -> Iterator[Event]:
        """What has happened, waiting so long at most for something to happen."""
        if not self._lost:
            for future in self._news(seconds):
                if future.key in self._running:  # else of a scheduler that is gone
                    event = self._outcome(future, self._running[future.key][1])
                    if event is None:
                        self._find_again()
                        break
                    del self._running[future.key]
                    yield event
        lost, self._lost = self._lost, []
        yield from (Died(job, 0) for job in lost)  # none is done before its record is there, so each is as good as not begun
        if time.monotonic() - self._counted > COUNT_EVERY:
            self._count()

    def _news(self, seconds: float) -> list[Any]:
        try:
            arrived = [self._arrived.get(timeout=seconds)]
            while not self._arrived.empty():
                arrived.append(self._arrived.get())
        except queue.Empty:
            return []
        return arrived

    def _outcome(self, future: Any, job: Job) -> Event | None:
        """What became of a job; None: it was lost with its scheduler."""
        try:
            if future.status == "finished":
                return Done(job, future.result(timeout=CONNECT_SECONDS))
            error = future.exception(timeout=CONNECT_SECONDS)
        except (asyncio.CancelledError, concurrent.futures.CancelledError):
            return None
        except (OSError, TimeoutError, self._distributed.scheduler.KilledWorker):
            return Died(job, 0)  # its worker was lost before it could pass the record on
        if not isinstance(error, self._distributed.scheduler.KilledWorker):
            if isinstance(error, Exception):
                raise error
            return Died(job, 0)
        # workers were lost that held it: perhaps by another task, so that counts only which was begun
        self._given_up[job.task.id] += 1
        if self._given_up[job.task.id] >= NEVER_BEGUN and not attempts.begun(self._folder, job.task, self._run):
            bound = f"workers die before they begin {job.task.id}"
            raise _refused(self._address, bound, "look for the reason in what the workers print, and run again; what is finished is kept")
        return Died(job, 0)

    def _count(self) -> None:
        """How many workers there are now; without any, the jobs wait for some."""
        with contextlib.suppress(OSError, ValueError, TimeoutError):  # if the scheduler is gone, the jobs in work will say so
            now = len(self._client.nthreads())
            if (now == 0) != self._deserted:
                self._deserted = now == 0
                log.print(f"no workers are left at {self._address}; waiting for some" if now == 0 else f"{now} workers have come")
            self.jobs = max(1, now)
        self._counted = time.monotonic()

    def _find_again(self) -> None:
        """Connect to the scheduler that takes the place of one that is gone."""
        self._lost += [job for _, job in self._running.values()]
        self._running.clear()
        self._client.close()
        log.print(f"the scheduler at {self._address} is gone; waiting for it for up to {RETURN_SECONDS} s")
        end = time.monotonic() + RETURN_SECONDS
        while True:
            try:
                self._connect()
                break
            except InputError as error:
                if time.monotonic() > end:
                    remedy = "start scheduler and workers again and run again; all finished results are kept"
                    raise _refused(self._address, f"the scheduler is gone ({error.problems[0].bound})", remedy) from None
                time.sleep(1.0)
        log.print(f"it is back, with {self.jobs} workers")


def _sees(folder: str) -> bool:
    return (Path(folder) / "tasks").is_dir()


def _distributed() -> Any:
    try:
        import distributed
    except ImportError:
        bound = "needs the package distributed, which is not installed"
        raise InputError(Problem("--scheduler", None, bound, "pip install 'fe2dem[cluster]', or use --jobs")) from None
    return distributed


def _refused(address: str, bound: str, remedy: str) -> InputError:
    return InputError(Problem("--scheduler", address, bound, remedy))
