"""A Dask cluster of this machine as separate processes, the way a user starts one: what can be killed, and started again."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType

from cases.verification import ends_with_parent

#: s; starting takes five at most on an idle machine
PATIENCE = 120.0


class DaskProcesses:
    """`dask scheduler` and `dask worker --nworkers N`, which starts a worker that died again; as a context, ended when left.

    If this process is killed, the scheduler ends by itself, and the workers end with it.
    """

    def __init__(self, workers: int, folder: Path, settings: Mapping[str, str], preload: str | None = None) -> None:
        self.address = f"tcp://127.0.0.1:{_free_port()}"
        self._workers, self._folder, self._preload = workers, folder, preload
        self._environment = {**os.environ, **settings, ends_with_parent.PARENT: str(os.getpid())}
        self._running: dict[str, subprocess.Popen[bytes]] = {}

    def __enter__(self) -> DaskProcesses:
        self.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        while self._running:
            self._end(self._running.popitem()[1])

    @property
    def groups(self) -> list[int]:
        """Numbers of the process groups, one for the scheduler and one for all workers."""
        return [process.pid for process in self._running.values()]

    def start(self) -> None:
        """Scheduler and workers; returns when all are there."""
        port = self.address.rsplit(":", 1)[1]
        watched = ("--preload", ends_with_parent.__name__)
        self._start("scheduler", "scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard", "--no-show", *watched)
        preload = ("--preload", self._preload) if self._preload else ()
        numbers = ("--nworkers", str(self._workers), "--nthreads", "1", "--death-timeout", str(PATIENCE))
        folder = ("--local-directory", str(self._folder))
        self._start("workers", "worker", self.address, *numbers, *folder, "--no-dashboard", *preload)
        self.wait_for(self._workers)

    def _start(self, name: str, *arguments: str) -> None:
        log = (self._folder / f"{name}.log").open("ab")
        command = [sys.executable, "-m", "dask", *arguments]
        self._running[name] = subprocess.Popen(command, stdout=log, stderr=log, env=self._environment, start_new_session=True)
        log.close()

    def wait_for(self, workers: int) -> None:
        """Until so many workers are there; raises `TimeoutError` with what the processes have printed if they do not come."""
        from distributed import Client

        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            with contextlib.suppress(OSError, TimeoutError), Client(self.address, timeout=5, set_as_default=False) as client:
                client.wait_for_workers(workers, timeout=30)
                return
            time.sleep(0.2)
        raise TimeoutError("\n".join(log.read_text(errors="replace")[-2000:] for log in self._folder.glob("*.log")))

    def kill(self) -> None:
        """kill -9 of the scheduler, and then of its workers, which would end without it, but only after seconds."""
        for name in ("scheduler", "workers"):
            self._end(self._running.pop(name), signal.SIGKILL)

    def _end(self, process: subprocess.Popen[bytes], with_signal: int = signal.SIGTERM) -> None:
        """End a process and all that it has started."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, with_signal)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(10.0)
        with contextlib.suppress(ProcessLookupError):  # also those that it has left behind
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def until(condition: Callable[[], bool], seconds: float = PATIENCE) -> None:
    """Poll; raises `TimeoutError` if it does not come true."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError("nothing happened")
        time.sleep(0.02)


def alive(process: int) -> bool:
    """Whether a process runs; one that ended and was not yet fetched does not (Linux)."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False
