"""Tiny stand-ins for the real work of a task; they leave traces by which a test sees how often a task was really done.

A module of its own: worker processes load it, and shall not load pytest.
"""

from __future__ import annotations

import errno
import os
import signal
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cases.batch import runner, shards, store
from cases.batch.local import LocalProcesses
from cases.batch.store import Record, hash_of
from cases.batch.task import Task
from contactlaws.files import write_text

Outcome = tuple[dict[str, str], dict[str, Any], str | None]
KEPT = 0.02  # s that a task of the test of kills takes


class Silent:
    """Counts what it is told."""

    def __init__(self) -> None:
        self.seen: list[tuple[str, str]] = []

    def reused(self, task: Task, record: Record) -> None:
        self.seen.append(("reused", task.name))

    def started(self, task: Task) -> None:
        self.seen.append(("started", task.name))

    def advanced(self, task: Task, fraction: float, text: str) -> None:
        pass

    def finished(self, task: Task, record: Record) -> None:
        self.seen.append((record.state, task.name))

    def waiting(self) -> None:
        pass


def task(name: str, *needs: str, key: str = "") -> Task:
    return Task("curves", name, {}, tuple(f"curves.{need}" for need in needs), (), hash_of(name, key))


def leave(file: Path, text: str) -> None:
    """One line at the end of a file, by one system call: lines of several processes do not mix."""
    handle = os.open(file, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    os.write(handle, text.encode() + b"\n")
    os.close(handle)


def make(task: Task, folder: Path, made: Mapping[str, Record], report: Any) -> Outcome:
    """Does what its name says, and leaves a line in a log so that a second computation would show."""
    leave(folder / "log", task.name)
    if task.name.startswith("killed"):
        os.kill(os.getpid(), signal.SIGKILL)
    if task.name.startswith("broken"):
        raise ValueError("on purpose")
    if task.name.startswith("full"):
        raise OSError(errno.ENOSPC, "no space")
    if task.name.startswith("slow"):
        (folder / "pid").write_text(str(os.getpid()))
        time.sleep(60.0 if not (folder / "hurry").exists() else 0.0)
    (folder / "curves").mkdir(exist_ok=True)
    file = folder / "curves" / f"{task.name}-{task.key}.txt"
    write_text(file, "".join(sorted(made)))
    return {"text": f"curves/{file.name}"}, {}, None


def traced(task: Task, folder: Path, made: Mapping[str, Record], report: Any) -> Outcome:
    """Leaves "begin" and "end" in a log of its own, and says there if it should not have begun: done already, or being done."""
    log = folder / "logs" / task.name
    if store.load(folder, task.id, task.key) is not None:
        leave(log, "twice")
    lines = log.read_text().split("\n")[:-1] if log.exists() else []
    if lines and lines[-1].startswith("begin") and alive(int(lines[-1].split()[1])):
        leave(log, "overlap")
    leave(log, f"begin {os.getpid()}")
    (folder / "workers" / str(os.getpid())).touch()
    time.sleep(KEPT)
    file = folder / "curves" / f"{task.name}-{task.key}.txt"
    write_text(file, task.name * 1000)
    leave(log, f"end {os.getpid()}")
    return {"text": f"curves/{file.name}"}, {}, None


def run_traced(folder: str, count: int, method: str | None = None) -> None:
    """A whole run of the tasks that `traced` does, in two processes: what the test of kills kills."""
    with LocalProcesses(2, method=method) as workers:
        runner.run([task(f"t{number}") for number in range(count)], Path(folder), workers, Silent(), traced)


def refuse(*_: object) -> Any:
    """In the place of what must not be called."""
    raise AssertionError("this is not to be read")


def notes(folder: Path, kind: str) -> list[Path]:
    """Files of the index that hold entries of a kind."""
    return sorted(shards.place(folder).glob(f"{kind}-*"))


def alive(pid: int) -> bool:
    """Whether a process runs; one that ended and was not yet fetched does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def prepared(folder: Path) -> Path:
    """A folder for tasks that `traced` does."""
    for name in ("logs", "curves", "workers", "tasks"):
        (folder / name).mkdir()
    return folder


def whole(folder: Path, task: Task) -> bool:
    """Whether a task that `traced` did is done, and was never begun when it was done already, nor by two at once."""
    record = store.load(folder, task.id, task.key, verify=True)
    lines = (folder / "logs" / task.name).read_text().split()
    return record is not None and record.state == "done" and not {"twice", "overlap"} & set(lines) and "end" in lines[-2:]


def begun(folder: Path, tasks: Sequence[Task]) -> int:
    """How often tasks that `traced` does were begun."""
    return sum((folder / "logs" / task.name).read_text().split().count("begin") for task in tasks)


def run_on_dask(address: str, folder: str, count: int) -> None:
    """`run_traced` on the workers of a scheduler."""
    from cases.batch.cluster import DaskCluster

    with DaskCluster(address, Path(folder)) as workers:
        runner.run([task(f"t{number}") for number in range(count)], Path(folder), workers, Silent(), traced)
