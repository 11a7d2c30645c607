"""The same batch on a Dask cluster of this machine whose processes are killed; and what is said where there is none.

`python -m cases.verification.batch_faults` does the same with finite elements and more processes.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import os
import random
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from cases.batch import runner, store
from cases.batch.cluster import DaskCluster
from cases.batch.task import Task
from cases.batch.worker import Job
from cases.verification.dask_processes import DaskProcesses, until
from contactlaws.errors import InputError
from tests.cases.stand_in import Silent, alive, begun, make, prepared, run_on_dask, task, traced, whole

pytestmark = pytest.mark.compiled_only(reason="nothing is compiled here, and starting processes takes long")

KILLS, TASKS = 3, 24


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    distributed = pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    import dask

    # the harshest setting: a scheduler gives up whatever a worker that was lost held, though it was not begun; and this kind of cluster
    # closes for ever what is not back in time, which on a busy machine may be long
    settings = {"distributed.scheduler.allowed-failures": 0, "distributed.deploy.lost-worker-timeout": "10 minutes"}
    with (
        dask.config.set(settings),
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as found,
    ):
        yield found


def test_without_the_extra_it_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install 'fe2dem\[cluster\]'"):
        DaskCluster("tcp://127.0.0.1:1", tmp_path)


def test_a_scheduler_that_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    monkeypatch.setattr("cases.batch.cluster.CONNECT_SECONDS", 1)
    with pytest.raises(InputError, match="no scheduler answers there"):
        DaskCluster("tcp://127.0.0.1:1", tmp_path)


def test_workers_must_see_the_folder(cluster: Any, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not see"):
        DaskCluster(cluster.scheduler_address, tmp_path / "elsewhere")


def test_needs_failures_and_reuse_are_as_on_one_machine(cluster: Any, tmp_path: Path) -> None:
    store.prepare(tmp_path)
    tasks = [task("c", "a", "b"), task("a"), task("b"), task("broken"), task("after", "broken")]
    for turn in range(2):
        watcher = Silent()
        with DaskCluster(cluster.scheduler_address, tmp_path) as workers:
            records = runner.run(tasks, tmp_path, workers, watcher, make)
        assert (tmp_path / records["curves.c"].files["text"]).read_text() == "curves.acurves.b"
        assert records["curves.broken"].reason == "ValueError: on purpose"
        assert records["curves.after"].state == "failed"
        assert (("started", "a") in watcher.seen) == (turn == 0)
    assert sorted((tmp_path / "log").read_text().split()) == ["a", "b", "broken", "c"]


def judge(folder: Path, tasks: list[Task], in_vain: int) -> None:
    """Every task has its whole record, none was begun twice or by two at once, and no more were begun in vain."""
    assert [one.name for one in tasks if not whole(folder, one)] == []
    assert begun(folder, tasks) - len(tasks) <= in_vain


def test_killed_workers_lose_only_what_they_were_at(cluster: Any, tmp_path: Path) -> None:
    prepared(tmp_path)
    chance, stop = random.Random(5), threading.Event()
    killed: list[int] = []

    def kill() -> None:
        while len(killed) < KILLS and not stop.wait(chance.uniform(0.02, 0.2)):
            pids = [int(path.name) for path in (tmp_path / "workers").iterdir() if alive(int(path.name))]
            if pids:
                killed.append(chance.choice(pids))
                os.kill(killed[-1], signal.SIGKILL)

    thread = threading.Thread(target=kill)
    tasks = [task(f"t{number}") for number in range(TASKS)]
    with DaskCluster(cluster.scheduler_address, tmp_path) as workers:
        thread.start()
        runner.run(tasks, tmp_path, workers, Silent(), traced)
        stop.set()
        thread.join()
    assert killed
    judge(tmp_path, tasks, len(killed))


def test_a_task_that_kills_its_worker_fails_after_three_deaths_and_its_neighbours_do_not(cluster: Any, tmp_path: Path) -> None:
    store.prepare(tmp_path)
    tasks = [task("killed"), *(task(f"t{number}") for number in range(6))]
    with DaskCluster(cluster.scheduler_address, tmp_path) as workers:
        records = runner.run(tasks, tmp_path, workers, Silent(), make)
    assert records["curves.killed"].state == "failed"
    assert records["curves.killed"].passing  # the next run tries it again
    assert "killed 3 times" in (records["curves.killed"].reason or "")
    assert {records[one.id].state for one in tasks[1:]} == {"done"}
    assert sorted((tmp_path / "log").read_text().split()) == ["killed"] * 3 + [f"t{number}" for number in range(6)]
    assert not any((tmp_path / "tasks" / ".begun").iterdir())


def test_two_clients_at_once_on_one_folder(cluster: Any, tmp_path: Path) -> None:
    prepared(tmp_path)
    runs = [threading.Thread(target=run_on_dask, args=(cluster.scheduler_address, str(tmp_path), TASKS)) for _ in range(2)]
    for one in runs:
        one.start()
    for one in runs:
        one.join()
    judge(tmp_path, [task(f"t{number}") for number in range(TASKS)], 0)


def test_one_scheduler_serves_two_folders(cluster: Any, tmp_path: Path) -> None:
    """The same task in another folder is another job, also while the first is still known to the scheduler."""
    folders = [tmp_path / "a", tmp_path / "b"]
    for folder in folders:
        store.prepare(folder)
    with DaskCluster(cluster.scheduler_address, folders[0]) as first, DaskCluster(cluster.scheduler_address, folders[1]) as second:
        for folder, workers in zip(folders, (first, second), strict=True):
            runner.run([task("a")], folder, workers, Silent(), make)
            assert store.load(folder, "curves.a", task("a").key, verify=True) is not None


@pytest.mark.parametrize("cancelled", [asyncio.CancelledError, concurrent.futures.CancelledError])
def test_a_job_that_is_lost_with_its_scheduler_after_it_was_done_is_no_error(cluster: Any, tmp_path: Path, cancelled: type) -> None:
    """Its record is on the disk; that it could not be fetched any more says only that the scheduler is gone."""
    store.prepare(tmp_path)

    class Lost:
        status = "finished"

        def result(self, timeout: float) -> None:
            raise cancelled

    with DaskCluster(cluster.scheduler_address, tmp_path) as workers:
        assert workers._outcome(Lost(), Job(task("a"), str(tmp_path), {})) is None


def test_a_client_that_is_killed_loses_nothing(cluster: Any, tmp_path: Path) -> None:
    """What its workers were at is finished by them, and the next client finds it."""
    prepared(tmp_path)
    code = f"from tests.cases.stand_in import run_on_dask; run_on_dask({cluster.scheduler_address!r}, {str(tmp_path)!r}, {TASKS})"
    client = subprocess.Popen([sys.executable, "-c", code], cwd=Path(__file__).parents[2])
    until(lambda: len(list((tmp_path / "logs").iterdir())) > 3)
    client.kill()
    client.wait()
    run_on_dask(cluster.scheduler_address, str(tmp_path), TASKS)
    judge(tmp_path, [task(f"t{number}") for number in range(TASKS)], 0)


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads the states of processes where Linux has them")
def test_a_scheduler_that_is_restarted_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The run waits for it, and goes on; workers end with their scheduler, so each loses the task that it was at."""
    pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    monkeypatch.setattr("cases.batch.cluster.CONNECT_SECONDS", 2)
    prepared(tmp_path)
    with DaskProcesses(1, tmp_path, {}) as processes:
        run = threading.Thread(target=run_on_dask, args=(processes.address, str(tmp_path), TASKS))
        run.start()
        until(lambda: len(list((tmp_path / "logs").iterdir())) > 3)
        processes.kill()
        processes.start()
        run.join()
    judge(tmp_path, [task(f"t{number}") for number in range(TASKS)], 1)


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads the states of processes where Linux has them")
def test_scheduler_and_workers_end_with_who_started_them(tmp_path: Path) -> None:
    """Also if that one is killed: nothing of a verification that was broken off stays behind."""
    pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    code = (
        "import sys, time, pathlib\n"
        "from cases.verification.dask_processes import DaskProcesses\n"
        "with DaskProcesses(1, pathlib.Path(sys.argv[1]), {}) as processes:\n"
        "    print(*processes.groups, flush=True)\n"
        "    time.sleep(600)\n"
    )
    command = [sys.executable, "-c", code, str(tmp_path)]
    with subprocess.Popen(command, cwd=Path(__file__).parents[2], stdout=subprocess.PIPE, text=True) as starter:
        assert starter.stdout is not None
        groups = {int(group) for group in starter.stdout.readline().split()}
        left = members(groups)
        starter.kill()
    assert len(left) >= 3  # the scheduler, who looks after the worker, and the worker
    until(lambda: not any(map(alive, left)))
    assert not members(groups)


def members(groups: set[int]) -> list[int]:
    """Processes of these groups that run."""
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(ProcessLookupError):
            if os.getpgid(int(place.name)) in groups and alive(int(place.name)):
                found.append(int(place.name))
    return found
