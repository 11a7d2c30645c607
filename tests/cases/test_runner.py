"""The runner: nothing twice, nothing lost, failures recorded, the rest goes on. Tasks here are tiny stand-ins for the real work."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import pytest

from cases.batch import runner, store
from cases.batch.plan import Task
from cases.batch.store import Record
from contactlaws.errors import InputError

pytestmark = pytest.mark.compiled_only(reason="nothing is compiled here, and starting processes takes long")


def stand_in(task: Task, folder: str, made: Mapping[str, Record]) -> Record:
    """Does what its name says, and leaves a line in a log so that a second computation would show."""
    place = Path(folder)
    with (place / "log").open("a") as log:
        log.write(task.name + "\n")
    if task.name.startswith("killed"):
        os.kill(os.getpid(), signal.SIGKILL)
    if task.name.startswith("full"):
        return Record(task.id, task.key, "failed", "no space", passing=True, summary={"errno": errno.ENOSPC})
    (place / "curves").mkdir(exist_ok=True)
    file = place / "curves" / f"{task.name}.txt"
    file.write_text("".join(sorted(made)))
    state = "failed" if task.name.startswith("broken") else "done"
    record = Record(task.id, task.key, state, "on purpose" if state == "failed" else None, files={"text": f"curves/{file.name}"})
    store.save(place, record)
    return record


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


def task(name: str, *needs: str, key: str = "k") -> Task:
    return Task("curves", name, {}, tuple(f"curves.{need}" for need in needs), (), key)


def run(folder: Path, *tasks: Task) -> tuple[dict[str, Record], list[tuple[str, str]]]:
    watcher = Silent()
    return runner.run(list(tasks), folder, 2, watcher, stand_in), watcher.seen


def test_tasks_wait_for_what_they_need_and_a_second_run_reuses_all(tmp_path: Path) -> None:
    tasks = (task("a"), task("b"), task("c", "a", "b"))
    records, _ = run(tmp_path, *tasks)
    assert {record.state for record in records.values()} == {"done"}
    assert (tmp_path / "curves" / "c.txt").read_text() == "curves.acurves.b"
    again, seen = run(tmp_path, *tasks)
    assert again == records
    assert seen == [("reused", name) for name in "abc"]
    assert sorted((tmp_path / "log").read_text().split()) == ["a", "b", "c"]


def test_another_key_or_a_lost_file_is_computed_anew(tmp_path: Path) -> None:
    run(tmp_path, task("a"), task("b"))
    (tmp_path / "curves" / "b.txt").unlink()
    run(tmp_path, task("a", key="other"), task("b"))
    assert sorted((tmp_path / "log").read_text().split()) == ["a", "a", "b", "b"]


def test_a_half_written_record_counts_as_none(tmp_path: Path) -> None:
    run(tmp_path, task("a"))
    path = store.record_path(tmp_path, "curves.a", "k")
    path.write_text(path.read_text()[:40])
    _, seen = run(tmp_path, task("a"))
    assert ("started", "a") in seen


def test_a_failure_is_recorded_and_the_rest_goes_on(tmp_path: Path) -> None:
    tasks = (task("broken"), task("after", "broken"), task("other"))
    records, _ = run(tmp_path, *tasks)
    assert records["curves.broken"].reason == "on purpose"
    assert records["curves.after"].state == "failed"
    assert "curves.broken failed" in (records["curves.after"].reason or "")
    assert records["curves.other"].state == "done"
    _, seen = run(tmp_path, *tasks)
    assert ("started", "broken") not in seen


def test_a_killed_process_takes_nothing_but_its_own_task(tmp_path: Path) -> None:
    records, _ = run(tmp_path, task("killed"), task("a"), task("b"), task("c"))
    assert records["curves.killed"].passing
    assert "killed" in (records["curves.killed"].reason or "")
    assert {records[f"curves.{name}"].state for name in "abc"} == {"done"}
    # passing: the machine's fault, so the next run tries again
    _, seen = run(tmp_path, task("killed"), task("a"))
    assert ("started", "killed") in seen
    assert ("reused", "a") in seen


def test_a_full_disk_is_one_clear_error_and_keeps_what_is_there(tmp_path: Path) -> None:
    run(tmp_path, task("a"))
    with pytest.raises(InputError, match="full") as caught:
        run(tmp_path, task("a"), task("full"))
    assert "run again" in caught.value.problems[0].remedy
    _, seen = run(tmp_path, task("a"))
    assert seen == [("reused", "a")]


def test_a_place_that_cannot_be_written_is_refused_before_computing(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(InputError, match="cannot be created"):
        run(tmp_path / "file" / "results", task("a"))


def test_records_survive_their_file(tmp_path: Path) -> None:
    record = Record("curves.a", "k", "stopped", "half way", cpu_seconds=1.5, summary={"errors": {"force": 0.01}})
    store.save(tmp_path, record)
    assert store.load(tmp_path, "curves.a", "k") == record
    assert store.load(tmp_path, "curves.a", "other") is None
    store.save(tmp_path, replace(record, files={"curve": "gone"}))
    assert store.load(tmp_path, "curves.a", "k") is None


def patient(task: Task, folder: str, made: Mapping[str, Record]) -> Record:
    """As `stand_in`, but "slow" says who works on it and then takes a minute."""
    if task.name == "slow":
        (Path(folder) / "pid").write_text(str(os.getpid()))
        time.sleep(60.0)
    return stand_in(task, folder, made)


def run_patiently(folder: str) -> None:
    """What the test below kills."""
    runner.run([task("quick"), task("slow")], Path(folder), 2, Silent(), patient)


def test_a_run_that_is_killed_loses_nothing_and_leaves_no_process(tmp_path: Path) -> None:
    code = f"from tests.cases.test_runner import run_patiently\nif __name__ == '__main__': run_patiently({str(tmp_path)!r})"
    process = subprocess.Popen([sys.executable, "-c", code], cwd=Path(__file__).parents[2])
    try:
        wait_for(lambda: (tmp_path / "pid").exists() and store.load(tmp_path, "curves.quick", "k") is not None)
    finally:
        process.kill()
        process.wait()
    worker = int((tmp_path / "pid").read_text())
    wait_for(lambda: not alive(worker))
    records, seen = run(tmp_path, task("quick"), task("slow"))
    assert ("reused", "quick") in seen
    assert records["curves.slow"].state == "done"


def wait_for(condition: Callable[[], bool]) -> None:
    """Poll; a minute is far more than starting a process takes."""
    end = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


def alive(pid: int) -> bool:
    """Whether a process runs; one that ended and was not yet fetched does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False
