"""The same jobs on a Dask cluster that somebody has started: `dask scheduler`, and `dask worker ADDRESS --nthreads 1` on every core.

The workers must see the folder of results under the same path, and run the same sources. All that is lasting is written by the job
itself, so it doesn't matter who dies: client, scheduler or worker.
"""

from __future__ import annotations

import queue
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any

from cases.batch.local import DEATHS, Died, Done, Event
from cases.batch.worker import Job, perform
from contactlaws.errors import InputError, Problem
from contactlaws.version import code_version, sources_alone

#: jobs that wait at the scheduler for each one in work, so that no worker waits for the client
AHEAD = 2
CONNECT_SECONDS = 10


class DaskCluster:
    """The workers of the scheduler at `address`; raises `InputError` if they cannot do the work."""

    def __init__(self, address: str, folder: Path) -> None:
        distributed = _distributed()
        try:
            self._client = distributed.Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise _refused(
                address, f"no scheduler answers there ({error})", "start one with `dask scheduler`, and give what it prints"
            ) from None
        self._address = address
        self._killed: Any = distributed.scheduler.KilledWorker
        self._arrived: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._running: dict[str, tuple[Any, Job]] = {}
        try:
            self._examine(address, folder)
        except BaseException:
            self._client.close()
            raise

    def _examine(self, address: str, folder: Path) -> None:
        threads = self._client.nthreads()
        if not threads:
            raise _refused(address, "the scheduler has no workers", f"start some with `dask worker {address} --nthreads 1`")
        if max(threads.values()) > 1:
            raise _refused(address, "workers of several threads measure each other's time", "start them with --nthreads 1")
        versions, seen = self._client.run(code_version), self._client.run(_sees, str(folder))
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
            raise _refused(address, f"{blind[0]} does not see {folder}", "give a folder that all machines share, under the same path")
        self.jobs = len(threads)

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
        """Hand a job to the scheduler."""
        future = self._client.submit(perform, job, key=f"fe2dem-{job.task.kind}-{job.task.key}", pure=False)
        self._running[future.key] = future, job
        future.add_done_callback(self._arrived.put)

    def wait(self, seconds: float) -> Iterator[Event]:
        """What has happened, waiting so long at most for something to happen."""
        try:
            arrived = [self._arrived.get(timeout=seconds)]
            while not self._arrived.empty():
                arrived.append(self._arrived.get())
        except queue.Empty:
            return
        for future in arrived:
            _, job = self._running.pop(future.key)
            yield self._outcome(future, job)

    def _outcome(self, future: Any, job: Job) -> Event:
        if future.status == "finished":
            return Done(job, future.result())
        error = future.exception() if future.status == "error" else None
        if isinstance(error, self._killed):  # the scheduler has tried it on several workers
            return Died(job, DEATHS)
        if error is not None:
            raise error
        if self._client.status != "running":
            raise _refused(self._address, "the scheduler is gone", "start it again and run again; all finished results are kept")
        return Died(job)


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
