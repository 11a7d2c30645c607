"""The runner: nothing twice, nothing lost, failures recorded, the rest goes on. Tasks here are tiny stand-ins for the real work."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from cases.batch import runner, store
from cases.batch.local import LocalProcesses
from cases.batch.store import Record
from cases.batch.task import Task
from contactlaws.errors import InputError
from tests.cases.stand_in import Silent, alive, make, task

pytestmark = pytest.mark.compiled_only(reason="nothing is compiled here, and starting processes takes long")


def run(folder: Path, *tasks: Task) -> tuple[dict[str, Record], list[tuple[str, str]]]:
    watcher = Silent()
    with LocalProcesses(2) as workers:
        return runner.run(tasks, folder, workers, watcher, make), watcher.seen


def log(folder: Path) -> list[str]:
    return sorted((folder / "log").read_text().split())


def test_tasks_wait_for_what_they_need_and_a_second_run_reuses_all(tmp_path: Path) -> None:
    tasks = (task("c", "a", "b"), task("a"), task("b"))
    records, _ = run(tmp_path, *tasks)
    assert {record.state for record in records.values()} == {"done"}
    assert (tmp_path / records["curves.c"].files["text"]).read_text() == "curves.acurves.b"
    again, seen = run(tmp_path, *tasks)
    assert again == records
    assert seen == [("reused", name) for name in "cab"]
    assert log(tmp_path) == ["a", "b", "c"]


def test_another_key_or_a_lost_file_is_computed_anew(tmp_path: Path) -> None:
    records, _ = run(tmp_path, task("a"), task("b"))
    (tmp_path / records["curves.b"].files["text"]).unlink()
    run(tmp_path, task("a", key="other"), task("b"))
    assert log(tmp_path) == ["a", "a", "b", "b"]


def test_the_same_task_under_two_names_is_done_once(tmp_path: Path) -> None:
    """Names change when a grid grows; results are found by what they are, not by what they are called."""
    first = task("a")
    records, _ = run(tmp_path, first, replace(first, name="b"), task("after", "b"))
    assert {record.state for record in records.values()} == {"done"}
    again, _ = run(tmp_path, replace(first, name="longer-name"))
    assert again["curves.longer-name"].task == "curves.longer-name"
    assert log(tmp_path) == ["a", "after"]


@pytest.mark.parametrize("torn", ["half of the record", "an empty record", "half of the file", "zeros in the file"])
def test_what_a_power_cut_tears_is_found_and_computed_anew(tmp_path: Path, torn: str) -> None:
    records, _ = run(tmp_path, task("c", "a", "b"), task("a"), task("b"))
    path = tmp_path / records["curves.c"].files["text"] if "file" in torn else store.record_path(tmp_path, "curves.c", task("c").key)
    content = path.read_bytes()
    path.write_bytes(b"\0" * len(content) if "zeros" in torn else content[: len(content) // 2] if "half" in torn else b"")
    again, _ = run(tmp_path, task("c", "a", "b"), task("a"), task("b"))
    assert log(tmp_path) == ["a", "b", "c", "c"]
    assert (tmp_path / again["curves.c"].files["text"]).read_text() == "curves.acurves.b"


def test_a_failure_is_recorded_and_the_rest_goes_on(tmp_path: Path) -> None:
    tasks = (task("broken"), task("after", "broken"), task("other"))
    records, _ = run(tmp_path, *tasks)
    assert records["curves.broken"].reason == "ValueError: on purpose"
    assert records["curves.after"].state == "failed"
    assert "curves.broken failed" in (records["curves.after"].reason or "")
    assert records["curves.other"].state == "done"
    _, seen = run(tmp_path, *tasks)
    assert ("started", "broken") not in seen


def test_a_killed_process_takes_nothing_but_its_own_task(tmp_path: Path) -> None:
    records, _ = run(tmp_path, task("killed"), task("a"), task("b"), task("c"))
    assert records["curves.killed"].passing
    assert "killed 3 times" in (records["curves.killed"].reason or "")
    assert log(tmp_path) == ["a", "b", "c", "killed", "killed", "killed"]
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


def test_a_disk_without_space_for_a_study_is_said_before_computing(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="GB free"):
        store.prepare(tmp_path, {"curves": 10**13})


def test_records_survive_their_file(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("content")
    record = Record(
        "curves.a", "0123", "stopped", "half way", cpu_seconds=1.5, summary={"errors": {"force": 0.01}}, files={"curve": "file"}
    )
    whole = store.save(tmp_path, record)
    assert store.load(tmp_path, "curves.a", "0123", verify=True) == whole
    assert store.load(tmp_path, "curves.a", "4567") is None
    (tmp_path / "file").unlink()
    assert store.load(tmp_path, "curves.a", "0123") is None


def test_a_run_that_is_killed_loses_nothing_and_leaves_no_process(tmp_path: Path) -> None:
    code = f"""
from tests.cases.test_runner import run, task
from pathlib import Path
if __name__ == '__main__': run(Path({str(tmp_path)!r}), task("quick"), task("slow"))
"""
    process = subprocess.Popen([sys.executable, "-c", code], cwd=Path(__file__).parents[2])
    try:
        wait_for(lambda: (tmp_path / "pid").exists() and store.load(tmp_path, "curves.quick", task("quick").key) is not None)
    finally:
        process.kill()
        process.wait()
    worker = int((tmp_path / "pid").read_text())
    wait_for(lambda: not alive(worker))
    (tmp_path / "hurry").touch()
    records, seen = run(tmp_path, task("quick"), task("slow"))
    assert ("reused", "quick") in seen
    assert records["curves.slow"].state == "done"


def wait_for(condition: Callable[[], bool]) -> None:
    """Poll; a minute is far more than starting a process takes."""
    end = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)
